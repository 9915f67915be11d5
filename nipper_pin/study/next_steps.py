"""Next steps after the check of a model: missing parts, and commands to run."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass

from .check import ModelReport

_OFTEN_SHORT = ("restitution", "stiffness")


@dataclass(frozen=True)
class NextSteps:
    """What to do with a model after its check.

    Attributes:
        missing: What is wrong or missing and what to change, one sentence each.
        commands: Commands to run next, each behind what it is for.
    """

    missing: tuple[str, ...]
    commands: tuple[str, ...]


def next_steps(
    report: ModelReport, model: str, given: Sequence[str] = (), start: Sequence[str] = ()
) -> NextSteps:
    """Sentences that lead from a checked model to its first runs.

    Args:
        model: How the user calls the model on the command line.
        given: Further words of the command line that make the machine and its speed.
        start: Its words that say where turns start.
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
        names, verb = " and --".join(short), "mean" if len(short) > 1 else "means"
        missing.append(f"--{names} of the command line {verb} nothing yet: add [shortcuts]")
    if not mechanism.provenance:
        missing.append("no number says where it comes from: add [provenance]")
    for item in report.masses:
        if item.doubt:
            missing.append(
                f"link {item.link} weighs {item.mass_kg:g} kg, {item.doubt}: is it in grams?"
            )
    sentences = [f"Missing: {text}" for text in missing]
    machine, commands = [model, *given], []
    if report.closing_index is not None and not report.no_transition:
        commands.append(_command("Run next", "simulate", *machine))
    elif mechanism.transition_stop and report.no_transition:
        sentences.append(f"No transition: {report.no_transition}")
    label, turns = "Then" if sentences or commands else "Run next", ("--window", "cycle")
    commands.append(_command(label, "simulate", *machine, *turns, *start))
    picture = f"{mechanism.name}.html"
    commands.append(_command("Look at it", "view", *machine, *start, "--html", picture))
    return NextSteps(tuple(sentences), tuple(commands))


def _command(label: str, *words: str) -> str:
    """A command ready to be pasted, behind what it is for."""
    return f"{label}: {shlex.join(['nipper-pin', *words])}"
