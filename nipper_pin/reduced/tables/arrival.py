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
from ...tolerances.reduced import TRIMMED_SHARE
from ..kernels.layout import Charts
from .functions import Sampler
from .tables import Chart, Domain, checks, levers, orders_of_gaps, resolved, stacked, trimmed
from .tables import Tables as Series

# Step of the search for the opening [rad].
_STEP = math.radians(3.0)
_NODES_Y = 8


@dataclass(frozen=True, kw_only=True)
class Arrival:
    """Tables of a turn from its opening to the touch.

    Attributes:
        charts: The chart of the transition stop from the touch to the opening, and that of the
            waiting stop from there to the touch; None where these are not known.
        why: Reason why there are no tables; empty if there are.
        asked: Whether the premise can be decided; without tables by simulating whole turns.
    """

    charts: Charts | None = field(repr=False)
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
        meets: Derivative by u of x before the touch, bound on its error, rate of y by that of x
            there, and bound on the error of its travel.
    """

    stop: Stop
    sampler: Sampler
    weights: FloatArray
    gap_max: float
    meets: tuple[float, float, float, float]


def unknown(why: str, *, asked: bool = True) -> Arrival:
    """Return an arrival without tables."""
    return Arrival(charts=None, why=why, asked=asked)


NOT_SAMPLED = unknown("the rest of the turn was not sampled")


def arrival(
    system: System, sampler: Sampler, opening: Opening, clamping: Chart, waiting: Waiting,
    tolerance: float,
) -> Arrival:  # fmt: skip
    """Sample the functions of a turn between its opening and the touch.

    Args:
        system: The held system; its shaft turns at 1 rad/s from the touch configuration.
        sampler: Functions of (u, x).
        opening: Where y comes back to zero.
        clamping: The chart of the transition stop from the touch up to there.
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
    closed = frozenset({mechanism.transition_stop})
    rounded = at_start(system, closed, opening.travel, opening.q[0], m[0])
    travel = 2.0 * math.pi - opening.travel
    domain = Domain(travel, -high / 16.0, high, begin=-travel, count_x=_NODES_Y)
    tables, _ = resolved(waiting.sampler, domain, waiting.weights, tolerance)
    _check_open(mechanism, tables)
    points = checks(waiting.sampler, domain, tables)
    kept = trimmed(
        points,
        domain,
        tables,
        waiting.weights,
        tolerance,
        orders_of_gaps(tables, TRIMMED_SHARE * tolerance),
    )
    wrong = rounded.size(sampler.size + stop.index)
    first = replace(clamping, meets=(approach, wrong, 1.0 / throw, 0.0))
    place = [item.name for item in mechanism.stops].index(stop.name)
    second = replace(kept, stop=place, begin=opening.travel, meets=waiting.meets)
    return Arrival(charts=stacked([first, second], [1, 0], levers(mechanism)))


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
