"""What to do next with a model that has been checked: what it lacks, and what to run."""

from __future__ import annotations

from .check import ModelReport

_OFTEN_SHORT = ("restitution", "stiffness")


def next_steps(report: ModelReport, model: str) -> tuple[str, ...]:
    """Sentences that lead from a checked model to its first runs.

    Args:
        report: The findings.
        model: How the user calls the model on the command line.

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
    steps = [f"Missing: {text}" for text in missing]
    if report.closing_index is not None:
        steps.append(f"Run next: nipper-pin simulate {model}")
    steps.append(f"{'Then' if steps else 'Run next'}: nipper-pin simulate {model} --window cycle")
    steps.append(f"Look at it: nipper-pin view {model} --html {mechanism.name}.html")
    return tuple(steps)
