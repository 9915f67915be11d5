"""Two runs on one clock: films of both with the same frames, and their curves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...hybrid import Solution
from ...study.compare import Comparison
from ...units import MS_PER_S
from ..reading import shown_until
from ..scene import Film, Look, film
from ..scene.film import Curve, curves
from ..scene.pace import Pace, paced

COLOUR_A, COLOUR_B = "#0072B2", "#CC79A7"
"""Of lines and names; the second one also of all that is drawn of machine B."""


@dataclass(frozen=True)
class Pair:
    """Films of two runs.

    Attributes:
        b: Film of B, with a frame for each of A's.
        later: What is added to a time of A to find that of B in the same frame [s].
        inside: By run: whether a frame lies in it, shape (K,); outside it stands still.
    """

    a: Film
    b: Film
    later: float
    inside: tuple[NDArray[np.bool_], NDArray[np.bool_]]


@dataclass(frozen=True)
class Lane:
    """One pair of axes and the curves in it.

    Attributes:
        first: The curve that names it.
        lines: Colour and values of each curve; NaN where its run has no motion, shape (K,).
        most: Largest value that is drawn.
    """

    first: Curve
    lines: tuple[tuple[str, FloatArray], ...]
    most: float


def pair(comparison: Comparison, look: Look) -> Pair:
    """Put two runs on one clock.

    It counts from the start of both windows. At different speeds it is moved so that both
    transition stops are struck first at the same time; otherwise nobody could compare rebounds.

    Raises:
        InputError: One of them has no motion, or its gap cannot be drawn larger.
    """
    runs = comparison.a, comparison.b
    later = _later(*runs)
    ends = [shown_until(run) for run in runs]
    begin = max(0.0, -later)
    end = max(ends[0], ends[1] - later) - begin
    moved = begin, begin + later
    events = np.unique([
        event.t - by
        for run, by, last in zip(runs, moved, ends, strict=True)
        for event in run.events if by <= event.t <= last
    ])  # fmt: skip
    frames = paced(events, end, max(run.shaft.period for run in runs), look.slow)
    times = [frames.machine + by for by in moved]
    paces = [Pace(frames.playback, t, frames.stretch) for t in times]
    films = [film(run, look, own) for run, own in zip(runs, paces, strict=True)]
    # Rebounds are compared to one scale.
    least = min(item.larger for item in films)
    look = replace(look, exaggerate=least)
    a, b = (item if item.larger == least else film(item.solution, look, item.pace)
            for item in films)  # fmt: skip
    # Round-off of the sum is no time without motion.
    ends = [last * (1.0 + np.finfo(float).eps * 8.0) for last in ends]
    return Pair(a, b, later, (times[0] <= ends[0], times[1] <= ends[1]))


def clock_text(both: Pair) -> str:
    """Where the time of both is zero, in words."""
    runs = both.a.solution, both.b.solution
    text = "Both start together; times count from the start of the window."
    if both.later != 0.0:
        size, word = abs(both.later), "earlier" if both.later > 0.0 else "later"
        text = (
            "The speeds differ, so both are shown with their first collision at the same time: B "
            f"starts {MS_PER_S * size:.3f} ms {word} than A. Times count from the start of A."
        )
    if both.inside[0].all() and both.inside[1].all():
        return text
    first = 0 if not both.inside[0].all() else 1
    end = shown_until(runs[first]) - (both.later if first else 0.0)
    return f"{text} The run of {'AB'[first]} ends at {MS_PER_S * end:.3f} ms; then it stands still."


def lanes(both: Pair) -> list[Lane]:
    """Curves of both, those of one name in the same axes."""
    one, other = ({curve.label: curve for curve in curves(item)} for item in (both.a, both.b))
    found = []
    for label, first in {**other, **one}.items():
        lines, most = [], 0.0
        for own, colour, inside in zip(
            (one, other), (COLOUR_A, COLOUR_B), both.inside, strict=True
        ):  # fmt: skip
            if label in own:
                lines.append((colour, np.where(inside, own[label].values, np.nan)))
                most = max(most, own[label].most)
        found.append(Lane(first, tuple(lines), most))
    return sorted(found, key=lambda lane: lane.first.label not in one)


def _later(a: Solution, b: Solution) -> float:
    """First collision of B's transition stop less that of A's, if their speeds differ."""
    touches = [
        next((hit.t for hit in run.collisions if hit.stop == run.mechanism.transition_stop), None)
        for run in (a, b)
    ]
    if a.case.speed_rpm == b.case.speed_rpm or touches[0] is None or touches[1] is None:
        return 0.0
    return touches[1] - touches[0]
