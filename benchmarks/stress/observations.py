"""Samples of a solution for its checks, and messages about violations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts2
from scipy.interpolate import BarycentricInterpolator

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import Segment, Solution
from nipper_pin.hybrid.motion.panel import Panel

EVENTS = 100
"""Of many events and borders of panels that many are looked at, evenly chosen."""
# Of many segments and of their panels that many are looked at, evenly chosen.
_SEGMENTS, _PANELS, _POINTS = 24, 3, 5


class Shown(NamedTuple):
    """Public values of a solution at K times, shape (K, nv), (K, m), (K, drives) and (K,).

    Closures are the forces of the cut joints on their frames a, in world axes; drives are torques;
    stops the forces of those that are closed, by name, positive when they push.
    """

    q: FloatArray
    v: FloatArray
    a: FloatArray
    closures: FloatArray
    drives: FloatArray
    stops: dict[str, FloatArray]


def shown(solution: Solution, closed: frozenset[str], t: FloatArray) -> Shown:
    """Motion and forces at times of a segment with these closed stops."""
    motion, forces = solution.trajectory.evaluate(t), solution.trajectory.reactions(t)
    none = np.empty((len(t), 0))
    return Shown(
        motion.q,
        motion.v,
        forces.a,
        np.hstack([none, *forces.closures.values()]),
        np.stack([*forces.drives.values()], axis=1) if forces.drives else none,
        {stop.name: forces.stops[stop.name] for stop in solution.mechanism.stops
         if stop.name in closed},
    )  # fmt: skip


def beyond(what: str, found: float, most: float) -> Iterator[str]:
    """Yield a message if a value exceeds its limit."""
    # A comparison with a number that is none is false: such a number is beyond every limit.
    if not found <= most:
        yield f"{what}: {found:.3g}, at most {most:.3g}"


def samples(solution: Solution) -> Iterator[tuple[Segment, Panel, FloatArray]]:
    """Panels and times at which a solution is checked: evenly chosen, copies of a turn once."""
    seen: set[tuple[int, int]] = set()
    for place in some(len(solution.segments), _SEGMENTS):
        segment = solution.segments[place]
        parts = list(segment.pieces())
        for panel, begin, end in (parts[i] for i in some(len(parts), _PANELS)):
            key = (segment.source, segment.panels.index(panel))
            if key not in seen:
                seen.add(key)
                # The end belongs to the next segment.
                yield segment, panel, np.linspace(begin, np.nextafter(end, begin), _POINTS)


def polynomial(values: FloatArray) -> BarycentricInterpolator:
    """Through values at the Chebyshev-Lobatto nodes of a panel, shape (N, nv); it is [0, 1]."""
    return BarycentricInterpolator(0.5 * (1.0 + chebpts2(len(values))), values, rng=0)


def some(count: int, most: int) -> list[int]:
    """Places, evenly chosen where there are many: the first and the last are among them."""
    return sorted({round(x) for x in np.linspace(0, count - 1, min(count, most))})
