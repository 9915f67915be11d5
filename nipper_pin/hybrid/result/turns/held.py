"""Forces along a turn: extremes of a stop's and a drive's, time with a force above a level."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from ....arrays import FloatArray
from ....dynamics.system import Multipliers
from ....mechanism.parallel import force_shares
from ....tolerances.hybrid import FORCE_RESOLVED, REAL_ROOT
from ...history import Segment
from ...motion.panel import Panel, forces_at
from ..solution import Solution

# Places of one polynomial, and halvings of what it does not hold.
_PLACES, _HALVINGS = 24, 3
_Force = Callable[[Segment, Multipliers], FloatArray | None]


@dataclass(frozen=True)
class Held:
    """How a stop was held shut.

    Attributes:
        least: Smallest force [N]; along the joint of a stop without a contact point [N or N m].
        largest: Largest force.
        above: Time with a force above the given one [s].
    """

    least: float
    largest: float
    above: float


def held(
    solution: Solution, stop: str, stretches: list[tuple[float, float]], level: float
) -> Held | None:
    """Read the force of a closed stop, and how long it is above a level; None if it is not closed.

    On each panel it is a polynomial to round-off, so its extremes and where it passes a level are
    roots of polynomials. Stretches are begins and ends of the times with the stop closed [s].
    """
    force = partial(_of_stop, solution, stop)
    found = [piece for stretch in stretches for piece in _pieces(solution, force, *stretch)]
    if not found:
        return None
    ends = [piece.extremes() for piece in found]
    return Held(
        least=min(low for low, _ in ends),
        largest=max(high for _, high in ends),
        above=math.fsum(piece.above(level) for piece in found),
    )


def largest_torque(solution: Solution, drive: str, begin: float, end: float) -> float:
    """Largest torque [N m], or force along a slide [N], of a drive from begin to end [s]."""
    place = [item.name for item in solution.mechanism.drives].index(drive)

    def torque(_: Segment, forces: Multipliers) -> FloatArray:
        return forces.drive[:, place]

    ends = [piece.extremes() for piece in _pieces(solution, torque, begin, end)]
    return max((max(-low, high) for low, high in ends), default=0.0)


def _of_stop(
    solution: Solution, stop: str, segment: Segment, forces: Multipliers
) -> FloatArray | None:
    """Force at the contact of a stop, shape (K,); None where it is open."""
    item = solution.mechanism.stop(stop)
    share = force_shares(solution.mechanism.stops, item.leader or stop)[stop]
    for place, leader in enumerate(solution.system.constraint_set(segment.closed).shut):
        if leader.name in (stop, item.leader):
            return share * forces.la_N[:, place] / item.lever
    return None


@dataclass(frozen=True, eq=False)
class _Piece:
    """The force on a short time, as a polynomial in x from -1 to 1."""

    begin: float
    end: float
    coefficients: FloatArray

    def extremes(self) -> tuple[float, float]:
        """Least and largest force."""
        x = [-1.0, *_roots(_array(chebyshev.chebder(self.coefficients))), 1.0]
        force = chebyshev.chebval(np.array(x), self.coefficients)
        return float(force.min()), float(force.max())

    def above(self, level: float) -> float:
        """Time with a force above a level [s]."""
        reduced = self.coefficients.copy()
        reduced[0] -= level
        x = np.array([-1.0, *_roots(reduced), 1.0])
        force = chebyshev.chebval(0.5 * (x[1:] + x[:-1]), reduced)
        return 0.5 * (self.end - self.begin) * float(np.diff(x)[force >= 0.0].sum())


def _roots(coefficients: FloatArray) -> list[float]:
    """Real roots of a Chebyshev series between -1 and 1, ascending."""
    if not np.any(coefficients[1:]):
        return []
    found = chebyshev.chebroots(chebyshev.chebtrim(coefficients))
    real = found.real[np.abs(found.imag) <= REAL_ROOT]
    return sorted(float(x) for x in real if -1.0 < x < 1.0)


def _pieces(solution: Solution, force: _Force, begin: float, end: float) -> Iterator[_Piece]:
    """A force on a stretch, where there is one."""
    for segment in solution.segments:
        if segment.t_end <= begin or segment.t_start >= end:
            continue
        for panel, low, high in segment.pieces():
            first, last = max(low, begin), min(high, end)
            if last > first:
                yield from _resolved(solution, force, segment, panel, first, last)


def _resolved(
    solution: Solution, force: _Force, segment: Segment, panel: Panel, begin: float, end: float,
    halvings: int = _HALVINGS,
) -> Iterator[_Piece]:  # fmt: skip
    """A force on a part of a panel, cut in halves until polynomials hold it."""
    system = solution.system
    phase, middle = system.constraint_set(segment.closed), 0.5 * (begin + end)
    # Places within, where no event at an end lets the force jump.
    x = np.cos(np.pi * (np.arange(_PLACES) + 0.5) / _PLACES)
    t = middle + 0.5 * (end - begin) * x
    values = force(segment, forces_at(system, phase, panel, t)[3])
    if values is None:
        return
    coefficients = _array(chebyshev.chebfit(x, values, _PLACES - 1))
    size = np.abs(coefficients)
    # The last ones are small where a polynomial holds the force.
    if halvings > 0 and size[-2:].max() > FORCE_RESOLVED * size.max():
        for half in ((begin, middle), (middle, end)):
            yield from _resolved(solution, force, segment, panel, *half, halvings - 1)
    else:
        yield _Piece(begin, end, coefficients)


def _array(values: Any) -> FloatArray:
    return np.asarray(values, dtype=np.float64)
