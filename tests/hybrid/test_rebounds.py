"""The highest point of a rebound, wherever it lies, of made-up gaps as polynomials of time."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Chebyshev, Polynomial

from nipper_pin import Case, EventKind
from nipper_pin.dynamics import Partition
from nipper_pin.hybrid.motion.chebyshev import nodes
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.result.rebounds import Rebounds
from nipper_pin.hybrid.segment import Segment
from nipper_pin.mechanism import Stop

LOWER = Stop(name="floor", index=0, restitution=0.5, contact=None)
UPPER = Stop(name="floor", index=0, restitution=0.5, contact=None, sense=-1.0, at=0.25)
Gap = Any


def waves(count: float, rise: float) -> Gap:
    """Crests one after another between two zeros, each by ``rise`` higher than the one before."""
    return Chebyshev.interpolate(
        lambda t: t * (1.0 - t) * (1.5 + rise * t + math.copysign(1.0, count)
                                   * np.cos(2.0 * math.pi * abs(count) * t)),
        18, domain=[0.0, 1.0],
    )  # fmt: skip


def line(begin: tuple[float, float], end: tuple[float, float]) -> Gap:
    """A gap that changes evenly between two times."""
    (t, gap), (later, other) = begin, end
    slope = (other - gap) / (later - t)
    return Polynomial([gap - slope * t, slope])


PARABOLA = Polynomial([0.0, 4.0, -4.0])
TOP = (0.4, 0.3)
# Pieces of the gap, the times between which each holds, and the highest gap.
GAPS: dict[str, tuple[list[Gap], list[float]]] = {
    "one crest": ([PARABOLA], [0.0, 1.0]),
    "cut before the crest": ([PARABOLA] * 2, [0.0, 0.3, 1.0]),
    "cut at the crest": ([PARABOLA] * 2, [0.0, 0.5, 1.0]),
    "cut behind the crest": ([PARABOLA] * 3, [0.0, 0.6, 0.8, 1.0]),
    "a kink": ([line((0.0, 0.0), TOP), line(TOP, (1.0, 0.0))], [0.0, 0.4, 1.0]),
    "a crest that is cut off": ([PARABOLA, line((0.4, 0.96), (1.0, 0.0))], [0.0, 0.4, 1.0]),
    "a level": ([line((0.0, 0.0), (0.2, 0.3)), Polynomial([0.3]), line((0.7, 0.3), (1.0, 0.0))],
                [0.0, 0.2, 0.7, 1.0]),
    "the first of two crests": ([waves(2.0, -1.0)], [0.0, 1.0]),
    "the last of two crests": ([waves(2.0, 2.0)], [0.0, 1.0]),
    "the last of three crests": ([waves(-3.0, 3.0)], [0.0, 1.0]),
    "the middle one of three crests": ([waves(-3.0, 0.2)], [0.0, 1.0]),
    "crests on two pieces": ([waves(2.0, 2.0)] * 2, [0.0, 0.5, 1.0]),
    "a rise behind the crest": ([waves(2.0, 2.0), line((0.45, 2.0), (1.0, 0.0))],
                                [0.0, 0.45, 1.0]),
}  # fmt: skip


def panel(gap: Gap, begin: float, end: float, stop: Stop, *, integrated: bool) -> Panel:
    t = begin + (end - begin) * nodes(24).sigma
    q = stop.at + stop.sense * gap(t)
    v, a = stop.sense * gap.deriv()(t), stop.sense * gap.deriv(2)(t)
    shape = (len(t), 1)
    return Panel(begin, end - begin, *(np.broadcast_to(x, t.shape).reshape(shape)
                 for x in (q, v, a)), Partition.of([], 1), integrated=integrated)  # fmt: skip


@cache
def highest(name: str) -> float:
    """That of a fine grid: it lies at most 5e-6 s beside a crest, whose curvature is below 500."""
    gaps, times = GAPS[name]
    return max(float(gap(np.linspace(t, end, 100_001)).max())
               for gap, (t, end) in zip(gaps, pairwise(times), strict=True))  # fmt: skip


@pytest.mark.parametrize(("panels", "beyond"), [(1, 0.0), (1, 0.4), (3, 0.4)])
@pytest.mark.parametrize("integrated", [True, False])
@pytest.mark.parametrize("stop", [LOWER, UPPER], ids=["lower", "upper"])
@pytest.mark.parametrize("name", GAPS)
def test_the_highest_point_of_a_rebound(
    name: str, stop: Stop, integrated: bool, panels: int, beyond: float
) -> None:
    """Also where the last panel of each piece reaches beyond it."""
    gaps, times = GAPS[name]
    segments = []
    for gap, (begin, end) in zip(gaps, pairwise(times), strict=True):
        edges = np.linspace(begin, end, panels + 1)
        edges[-1] += beyond * (end - begin)
        parts = (panel(gap, *edge, stop, integrated=integrated) for edge in pairwise(edges))
        closed: frozenset[str] = frozenset()
        segments.append(Segment(begin, end, closed, tuple(parts), kinematic=not integrated))

    def event(number: int, t: float) -> Any:
        return SimpleNamespace(
            number=number, t=t, kind=EventKind.COLLISION, stops=("floor",), P_N={"floor": 1.0},
            v_after=np.array([stop.sense]), q=np.zeros(1), source=number,
        )  # fmt: skip

    events: Any = [event(1, 0.0), event(2, 1.0)]
    case = Case(speed_rpm=60.0)
    system: Any = SimpleNamespace(mechanism=SimpleNamespace(stop=lambda _: stop))
    found = Rebounds(system, segments, events, case).amplitude(events[0], "floor")
    assert found == pytest.approx(highest(name), rel=1e-8)
