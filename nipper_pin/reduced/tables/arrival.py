"""Tables of a turn from its opening to the touch, for the premise of a transition.

In the phase that clamps (x = 0, the transition stop closed) the other stop, with coordinate y, is
open until the drives bring it back: the opening. Its collision there throws the transition stop
open, and from then on y is the one coordinate that is left, a body that bounces on a stop, rests on
it, and is released where y'' at y = y' = 0 changes its sign. That is independent of the past.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System
from ...errors import SimulationError
from ...hybrid.error_estimate.local_error import at_start
from ...mechanism import Mechanism, Stop
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import TABLE_ERROR_SAFETY
from ..kernels.layout import Charts, Turn
from . import series2d
from .functions import Sampler
from .tables import CELL_RAD, Domain, checks, levers, resolved, stacked, trimmed
from .tables import Tables as Series

# Step of the search for the opening [rad].
_STEP = math.radians(3.0)
# Nodes of functions of one variable; cells as in tables of two.
_NODES, _TOUCH_NODES, _NODES_Y = 16, 24, 8
_CHECKS = 16


@dataclass(frozen=True, kw_only=True)
class Arrival:
    """Tables of a turn from its opening to the touch.

    Attributes:
        charts: Functions of (u, y), u counted from the opening; None where these are not known.
        turn: Functions along stops and at the touch, or None.
        why: Reason why there are no tables; empty if there are.
        asked: Whether the premise can be decided; without tables by simulating whole turns.
    """

    charts: Charts | None = field(repr=False)
    turn: Turn | None = field(repr=False)
    why: str = ""
    asked: bool = True


class Opening(NamedTuple):
    """Angle at which the waiting stop is reached again and the transition stop opens.

    Attributes:
        travel: Travel from the touch configuration [rad].
        q: Configuration, shape (1, nv).
    """

    travel: float
    q: FloatArray


class Waiting(NamedTuple):
    """The stop of the initial phase, from its opening on.

    Attributes:
        sampler: Functions of (u, y).
        weights: Weights of the functions in y'', shape (functions,).
        gap_max: Largest y.
    """

    stop: Stop
    sampler: Sampler
    weights: FloatArray
    gap_max: float


def unknown(why: str, *, asked: bool = True) -> Arrival:
    """Return an arrival without tables."""
    return Arrival(charts=None, turn=None, why=why, asked=asked)


NOT_SAMPLED = unknown("the rest of the turn was not sampled")


def arrival(
    system: System, sampler: Sampler, opening: Opening, waiting: Waiting, tolerance: float
) -> Arrival:
    """Sample the functions of a turn between its opening and the touch.

    Args:
        system: The held system; its shaft turns at 1 rad/s from the touch configuration.
        sampler: Functions of (u, x).
        opening: Where y comes back to zero.
        waiting: The stop that waits, and its functions of (u, y).
        tolerance: Relative accuracy of the tables.

    Raises:
        SimulationError: The turn is not one of those that the tables describe.
        ConvergenceError: Its functions are not smooth enough.
    """
    mechanism, stop, high = system.mechanism, waiting.stop, waiting.gap_max
    n, m = sampler.rates(np.array([opening.travel]), opening.q)
    throw, approach = float(n[0, stop.index]), float(m[0, stop.index])
    if throw <= 0.0 or approach >= 0.0:
        message = f"stop {stop.name!r} does not open {mechanism.transition_stop!r} by its collision"
        raise SimulationError(message, throw=throw, approach=approach)
    clamping = frozenset({mechanism.transition_stop})
    rounded = at_start(system, clamping, opening.travel, opening.q[0], m[0])
    travel = 2.0 * math.pi - opening.travel
    domain = Domain(travel, -high / 16.0, high, begin=-travel, count_x=_NODES_Y)
    tables, _ = resolved(waiting.sampler, domain, waiting.weights, tolerance)
    _check_open(mechanism, tables)
    kept = trimmed(
        checks(waiting.sampler, domain, tables), domain, tables, waiting.weights, tolerance
    )
    count_x = kept.equation.shape[-1]
    at_zero = np.polynomial.chebyshev.chebvander(domain.places(np.zeros(1)), count_x - 1)[0]
    touch, touch_errors = _touch(waiting.sampler, mechanism, domain)
    clamped, clamped_residual = _clamping(sampler, opening.travel)
    wrong = rounded.size(sampler.size + stop.index)
    place = [item.name for item in mechanism.stops].index(stop.name)
    chart = replace(kept, stop=place, meets=(approach, wrong, 0.0, 0.0))
    return Arrival(
        charts=stacked([chart], [0], levers(mechanism)),
        turn=Turn(
            opening=opening.travel,
            restitution=stop.restitution,
            clamping=clamped,
            waiting=np.ascontiguousarray(kept.equation @ at_zero),
            residual=clamped_residual,
            touch=touch,
            touch_errors=touch_errors,
        ),
    )


def found_opening(sampler: Sampler, stop: Stop) -> Opening | None:
    """Angle at which y returns to zero with x at zero; None if it does not, or is unknown."""
    u = np.arange(_STEP, 2.0 * math.pi, _STEP)
    before = np.zeros((1, sampler.size))
    try:
        for travel, row in zip(u, sampler.along(u, np.zeros(1), before), strict=True):
            if stop.gap(row[0]) <= 0.0:
                low = float(travel - _STEP)
                if low <= 0.0:
                    # The stop does not open.
                    return None
                found, q = sampler.closing(stop, low, float(travel), before)
                return Opening(found, q[None])
            before = row
    except SimulationError:
        return None
    return None


def _check_open(mechanism: Mechanism, tables: Series) -> None:
    """Refuse a turn in which the transition stop can close while the waiting one has y >= 0."""
    gaps = tables.q[:, :, mechanism.stop(mechanism.transition_stop).index]
    if (np.diff(gaps, axis=1) <= 0.0).any() or (gaps[:, tables.x >= 0.0] <= 0.0).any():
        message = f"stop {mechanism.transition_stop!r} can close between its opening and the touch"
        raise SimulationError(message)


def _clamping(sampler: Sampler, opening: float) -> tuple[FloatArray, FloatArray]:
    """Functions in x'' along x = 0 as series in u on cells, and bounds on their errors."""
    cells = max(1, math.ceil(opening / CELL_RAD))
    width = opening / cells
    inner = 0.5 * width * (series2d.gauss_nodes(_NODES) + 1.0)
    u = (width * np.arange(cells)[:, None] + inner).ravel()
    zero = np.zeros_like(u)
    q = sampler.grid(u, np.zeros(1))[:, 0]
    values = sampler.at(u, zero, q).equation.reshape(-1, cells, _NODES, 1)
    series = series2d.fit(values)[..., 0]
    tail = np.abs(series[:, :, -2:]).sum(axis=2).max(axis=1)
    round_off = 4.0 * EPS * np.abs(values).max((1, 2, 3))
    return np.ascontiguousarray(series), TABLE_ERROR_SAFETY * tail + round_off


def _touch(sampler: Sampler, mechanism: Mechanism, domain: Domain) -> tuple[FloatArray, FloatArray]:
    """x, dx/dy and dx/du at the touch as series in y, and bounds on their errors."""
    column = mechanism.stop(mechanism.transition_stop).index

    def values(places: FloatArray) -> FloatArray:
        q = sampler.grid(np.zeros(1), domain.coordinates(places))[0]
        n, m = sampler.rates(np.zeros(len(places)), q)
        return np.array([q[:, column], n[:, column], m[:, column]])

    series = series2d.fit(values(series2d.gauss_nodes(_TOUCH_NODES))[:, None, None])[:, 0, 0]
    between = np.linspace(-1.0, 1.0, _CHECKS)
    true = values(between)
    found = np.array([np.polynomial.chebyshev.chebval(between, row) for row in series])
    error = np.abs(found - true).max(axis=1)
    return series, TABLE_ERROR_SAFETY * error + 4.0 * EPS * np.abs(true).max(axis=1)
