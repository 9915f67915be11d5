"""Phase, impulses and numbers at one time of a transition."""

from __future__ import annotations

import math

from ...arrays import FloatArray
from ...hybrid import Solution
from ...hybrid.result.quantities import force_unit
from ...terms import digits
from ...units import MM_PER_M, MS_PER_S
from ..naming import coordinate_shown
from ..reading import index_at
from ..scene.arrows import FADE, HELD, drawn_collisions


def closed_at(solution: Solution, t: float) -> frozenset[str]:
    """Closed stops of the phase at one moment.

    Args:
        t: Time [s].
    """
    return next(item for item in reversed(solution.phases) if item.t_start <= t).closed


def impulses_at(solution: Solution, t: float, slow: float) -> dict[str, float]:
    """Impulses that have just been; each is held for a moment of playback and shrinks.

    Args:
        t: Time [s].
        slow: Seconds of playback in a second of the machine.

    Returns:
        Size of the arrow of each stop struck so far that has one, by the largest impulse [-].
    """
    # An impulse of a moment has another unit, and no arrow.
    hits = drawn_collisions(solution, math.inf)
    largest = max((item.impulse for item in hits), default=0.0)
    found = {}
    for hit in hits:
        left = (HELD + FADE - slow * (t - hit.t)) / FADE
        if hit.t <= t and largest > 0.0:
            # A new collision takes the arrow over from the one before it.
            found[hit.stop] = min(max(left, 0.0), 1.0) * hit.impulse / largest
    return found


def moment_text(solution: Solution, t: float, q: FloatArray) -> str:
    """Time, index, gaps of the stops and clamping force: the machine's, not the drawing's.

    Args:
        t: Time [s].
        q: Configuration, shape (nv,) [rad or m].
    """
    mechanism = solution.mechanism
    parts = [f"{MS_PER_S * t:.2f} ms", f"index {index_at(solution, t):.3f}"]
    for stop in mechanism.stops:
        main, gap = stop.name == mechanism.transition_stop, stop.gap(q)
        shown = coordinate_shown(mechanism, stop.index, small=main)
        parts.append(f"{stop.name} {shown.phrase(gap)}")
        if not main:
            continue
        if stop.contact is not None:
            parts.append(f"gap at the contact {digits(MM_PER_M * stop.lever * gap)} mm")
        force = solution.trajectory.reactions(t).contacts[stop.name][0]
        parts.append(f"clamping force {digits(float(force))} {force_unit(mechanism, stop)}")
    return ", ".join(parts)
