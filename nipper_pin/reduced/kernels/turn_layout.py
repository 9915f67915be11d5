"""Layout of the arrays of whole turns that compiled code reads and writes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .layout import numbered

# Kinds of events.
COLLISION, REST, RELEASE = numbered(3)
# Columns of the table of events.
(
    KIND, STOP, TIME, TRAVEL, APPROACH, SEPARATION, IMPULSE, ENERGY, AMPLITUDE,
    TIME_ERROR, RATE_ERROR, IMPULSE_ERROR, AMPLITUDE_ERROR, ENERGY_ERROR,
) = range(14)  # fmt: skip
EVENT_COLUMNS = 14
# Columns of the stretches on which the clamping stop is closed. ENDED_BY is the kind of the event
# that ends one, REST where it goes on in the next chart; the errors are those of its ends [rad].
HOLD_TURN, HOLD_CHART, HOLD_BEGIN, HOLD_END, ENDED_BY, HOLD_BEGIN_ERROR, HOLD_END_ERROR = range(7)
HOLD_COLUMNS = 7
# Quantities of a turn; travels are counted from its start. For each stop a few more follow.
(
    CLOSED_AT, RESTS_AT, LOST_AT, OPENED_AT, CLAMPED, LEAST_FORCE, MOST_FORCE, FORCE_ERROR,
    LARGEST_GAP, GAP_ERROR, LOST_ENERGY, CLOSED_ERROR, RESTS_ERROR, LOST_ERROR, OPENED_ERROR,
    CLAMPED_ERROR, LOSS_ERROR, LEAST_ERROR, LARGEST_ERROR,
) = range(19)  # fmt: skip
TURN_NUMBERS = 19
COUNT, IMPULSE_SUM, IMPULSE_MOST, SUM_ERROR, MOST_ERROR = range(5)
PER_STOP = 5
# Ends of turns: chart and travel of the last rest's end (-1 without one), then chart, gap and its
# rate, and bounds on the errors of both.
END_COLUMNS = 7
Begin = tuple[int, float, float, bool, float, float]
"""How turns begin: chart, gap, its rate, whether its stop is closed, and errors of gap and rate."""


class Charts(NamedTuple):
    """Functions around every stretch of a turn along which a stop can be closed.

    A chart has the gap x of its stop as coordinate, and travels u from its begin; all charts have
    the same numbers of cells and coefficients, padded by zeros. C charts, K stops, S = K - 1.

    Attributes:
        equation: Functions in x'', shape (C, 4 + 2 springs, cells, Nu, Nx).
        gaps: Gaps of the other stops, shape (C, S, cells, Nu, Nx).
        slopes: Their derivatives by x, then by u, shape (C, 2 S, cells, Nu, Nx).
        inertia: Effective inertia at x = 0, shape (C, cells, Nu).
        residual: Bounds on the errors of the functions, shape (C, functions).
        largest: Their largest values, likewise.
        steepest_x: Their largest derivatives by x.
        steepest_u: Their largest derivatives by u.
        inertia_residual: Bound on the relative error of the inertia, shape (C,).
        gap_residual: Bounds on the errors of the gaps, shape (C, S).
        slope_residual: Those of the slopes, shape (C, 2 S).
        travel: Length [rad], shape (C,).
        span: Length of all cells, those of the padding included [rad].
        low: Least x.
        high: Largest x.
        on_rows: Largest x up to which springs are on the rows of their tables, negative where they
            leave them with the stop closed, by equal parts of ``span``, shape (C, parts); none of a
            machine without tables.
        begin: Travel from the start of the turn to u = 0 [rad].
        stop: Place of the stop among the stops, shape (C,).
        others: Those of the others, shape (C, S).
        after: The chart that follows where this one ends, shape (C,).
        arrive: Derivative by u of the gap of its stop there, negative; zero for the same stop.
        arrive_residual: Bound on its error.
        throw: Rate of x by that of the other gap there.
        corner_error: Bound on the error of the end itself [rad].
        lever: Rate of the normal gap by that of the coordinate, shape (K,) [m/rad or 1].
    """

    equation: FloatArray
    gaps: FloatArray
    slopes: FloatArray
    inertia: FloatArray
    residual: FloatArray
    largest: FloatArray
    steepest_x: FloatArray
    steepest_u: FloatArray
    inertia_residual: FloatArray
    gap_residual: FloatArray
    slope_residual: FloatArray
    travel: FloatArray
    span: FloatArray
    low: FloatArray
    high: FloatArray
    on_rows: FloatArray
    begin: FloatArray
    stop: NDArray[np.int64]
    others: NDArray[np.int64]
    after: NDArray[np.int64]
    arrive: FloatArray
    arrive_residual: FloatArray
    throw: FloatArray
    corner_error: FloatArray
    lever: FloatArray


class Records(NamedTuple):
    """What a run of turns writes.

    Attributes:
        events: Shape (most, EVENT_COLUMNS).
        holds: Stretches on which the clamping stop is closed, shape (most, HOLD_COLUMNS).
        ends: Of the start and of each turn, shape (turns + 1, END_COLUMNS).
    """

    events: FloatArray
    holds: FloatArray
    ends: FloatArray


class TurnWork(NamedTuple):
    """Scratch arrays of a case, combined for it when a chart is first visited.

    Attributes:
        case: Numbers of the case, shape (C, CASE_NUMBERS).
        mixed: Functions combined for the case, shape (C, cells, Nu, (3 + S) Nx).
        sizes: Bounds of the case as polynomials of the rate, shape (C, SIZES, 3).
        line: x'' along x = 0 at rest, shape (C, cells, Nu).
        ready: Whether a chart was visited, shape (C,).
        poly: As :class:`~.layout.Work`.
        nodes: Likewise.
        series: Times and rates of bounces, and scratch, shape (3, collisions).
    """

    case: FloatArray
    mixed: FloatArray
    sizes: FloatArray
    line: FloatArray
    ready: NDArray[np.bool_]
    poly: FloatArray
    nodes: FloatArray
    series: FloatArray
