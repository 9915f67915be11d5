"""Next steps after the check of a model: missing parts, and commands to run."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from .check import ModelReport

_OFTEN_SHORT = ("restitution", "stiffness")


def next_steps(
    report: ModelReport, model: str, given: Sequence[str] = (), start: Sequence[str] = ()
) -> tuple[str, ...]:
    """Sentences that lead from a checked model to its first runs.

    Args:
        report: The findings.
        model: How the user calls the model on the command line.
        given: Further words of the command line that make the machine and its speed.
        start: Its words that say where turns start.

    Returns:
        What is missing, one sentence each, then commands.
    """
    mechanism = report.mechanism
    missing = []
    if not mechanism.drives:
        missing.append("nothing drives it: add [drives.NAME] with the joint and a law")
    if not mechanism.stops:
        missing.append(
            "nothing can collide: add [stops.NAME] with the joint that it limits and a "
            "restitution, and name it in transition_stop and in a phase"
        )
    elif report.closing_index is None:
        missing.append(
            f"stop {mechanism.transition_stop} is not struck in a turn at {report.speed_rpm:g} "
            "r/min: look at the motion (view), then at the drive laws and angle_at_touch_deg"
        )
    elif report.opening_index is None:
        missing.append(
            f"stop {mechanism.transition_stop} does not open again within the turn: look at the "
            "motion (view), then at the stop that should lift it"
        )
    overlaps = report.interferences
    if overlaps:
        pairs = sorted({f"{item.shape_a} with {item.shape_b}" for item in overlaps})
        missing.append(f"links overlap: {', '.join(pairs)}; move the shapes or the points")
    short = [name for name in _OFTEN_SHORT if name not in mechanism.shortcuts]
    if short and mechanism.stops:
        missing.append(
            f"--{' and --'.join(short)} of the command line mean nothing yet: add [shortcuts]"
        )
    if not mechanism.provenance:
        missing.append("no number says where it comes from: add [provenance]")
    for item in report.masses:
        if item.doubt:
            missing.append(
                f"link {item.link} weighs {item.mass_kg:g} kg, {item.doubt}: is it in grams?"
            )
    steps = [f"Missing: {text}" for text in missing]
    machine = [model, *given]
    if report.closing_index is not None and not report.no_transition:
        steps.append(_command("Run next", "simulate", *machine))
    elif mechanism.transition_stop and report.no_transition:
        steps.append(f"No transition: {report.no_transition}")
    label, turns = "Then" if steps else "Run next", ("--window", "cycle")
    steps.append(_command(label, "simulate", *machine, *turns, *start))
    view = _command("Look at it", "view", *machine, *start, "--html", f"{mechanism.name}.html")
    return (*steps, view)


def _command(label: str, *words: str) -> str:
    """A command ready to be pasted, behind what it is for."""
    return f"{label}: {shlex.join(['nipper-pin', *words])}"
