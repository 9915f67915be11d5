"""Layout of the arrays that compiled code reads and writes, and its status codes.

Stretches on which the clamping stop is closed: ENDED_BY is the kind of the event that ends one,
REST where it goes on in the next chart; the errors are those of its ends [rad].

Ends of turns: chart and travel of the last rest's end (-1 without one), then chart, gap and its
rate, and bounds on the errors of both.

Operators: integrals at nodes (ONCE, TWICE) and at probes, Chebyshev coefficients (VALUE); REFINE
from the coarser grid; SIGMA holds the nodes, then the probes.

Scratch: values at the nodes, and the coefficients of the panel's motion; of a panel that is kept
its numbers, too: see the module that keeps them.

Numbers of a chart: SCALE takes x - low to [0, 2]; PER_RAD is the number of its cells in a radian;
BEGIN is the travel from the start of the turn to u = 0. Where another stop takes over at the end:
ARRIVE, the derivative by u of its gap there, negative, THROW, the rate of x by that of this gap,
and CORNER_ERROR, the bound on the error of the end itself [rad]; zeros where it is the same stop.

Places of a chart: its stop, the chart that follows where it ends, and from OTHERS on the other
stops.

Bounds of a case: sums that bound the error of x'' and its derivatives by x, travel and rate; then
what is multiplied by the rate, then by its square. Those of the functions of a chart, likewise:
their errors, largest derivatives by x and by u, and largest values.

Memory of a motion: number of bounces of a series, when it began, and its fastest rebound; the
collision whose rebound is under way (-1 without one), how high and long that has been, and the
errors of both; the error of the travel of the last rest, and the rate with which bounces begin that
are not computed before it; its chart and the travel of its end.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray


def numbered(count: int, first: int = 0) -> Any:
    """Numbers as NumPy has them: for each of Python's a function is compiled anew."""
    return np.arange(first, first + count)


ZERO: int = numbered(1)[0]
NO, YES = numbered(2) > ZERO
# What is asked of the cases of a call.
TRANSITIONS, ARRIVALS, TURNS = numbered(3)
# Status of a case; GOES_ON while it is followed.
(
    GOES_ON, AT_REST, LEFT_TRAVEL, LEFT_GAP, OTHER_STOP, NOT_PRESSED, TOO_MANY, UNRESOLVED, UNTOLD,
    JAM, OFF_ROWS,
) = numbered(11, -1)  # fmt: skip
# Kinds of events.
COLLISION, REST, RELEASE = numbered(3)
# Columns of the table of events. In that of a transition the travel is told as the angle psi.
(
    KIND, STOP, TIME, TRAVEL, APPROACH, SEPARATION, IMPULSE, ENERGY, AMPLITUDE, REBOUND,
    TIME_ERROR, RATE_ERROR, IMPULSE_ERROR, ENERGY_ERROR, AMPLITUDE_ERROR, REBOUND_ERROR,
) = numbered(16)  # fmt: skip
ANGLE = TRAVEL
COLUMNS = 16
# Rooms for events of a transition beyond its collisions: a rest, and a collision too many.
BESIDE = 2
# Stretches of a turn on which the clamping stop is closed, and their columns.
STRETCHES_OF_TURN = 64
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
# Columns of the ends of turns.
END_COLUMNS = 7

LEVELS = (4, 7, 13, 25)
# Operators on nodal values.
ONCE, TWICE, VALUE, REFINE, PROBE, PROBE_ONCE, PROBE_TWICE, SIGMA = numbered(8)
PROBES = 3
# Rows of the scratch array.
NODE_A, NODE_NEW, NODE_X, NODE_V, SERIES, SERIES_ONCE, SERIES_TWICE, GROWTH, KEPT = numbered(9)
SCRATCH_ROWS = 9
# Numbers of a chart.
(
    TRAVEL_MOST, LOW, HIGH, SCALE, PER_RAD, BEGIN, ARRIVE, ARRIVE_ERROR, THROW, CORNER_ERROR,
    INERTIA_ERROR,
) = numbered(11)  # fmt: skip
CHART_NUMBERS = 11
# Places of a chart.
OWN, AFTER, OTHERS = numbered(3)
# Whether the machine arrives in its initial phase at the touch.
NOT_ASKED, UNKNOWN, FAILS, HOLDS = numbered(4, -2)
# Bounds of a case, and of the functions of a chart.
RESIDUAL, BY_X, BY_U, BY_V = numbered(4)
SIZES = 4
# What is remembered of a motion.
(
    BOUNCES, ORIGIN, FASTEST, LAST, RISEN, RISEN_ERROR, FLOWN, FLOWN_ERROR, UNSURE, SETTLED,
    REST_CHART, REST_END,
) = numbered(12)  # fmt: skip
MEMORY = 12
# What was written of a motion.
EVENTS, STRETCHES, DONE, PANELS = numbered(4)
COUNTS = 4


# At the door of compiled code named tuples cost a microsecond, plain ones of the same a third.
Plain = tuple[Any, ...]


class Charts(NamedTuple):
    """Functions around the stretches of a turn along which a stop can be closed.

    A chart has the gap x of its stop as coordinate, and travels u from its begin; all charts have
    the same numbers of cells and coefficients, padded by zeros. The domain of a transition is one
    chart. C charts, K stops, R ends of tables of springs, S = K - 1 + R.

    Attributes:
        equation: Functions in x'', shape (C, cells, Nu, 4 + 2 springs, Nx).
        along: The same along the closed stop, x = 0, shape (C, cells, functions, Nu).
        gaps: Gaps of the other stops and up to those ends, then their derivatives by x, then those
            by u, shape (C, 3 S, cells, Nu, Nx).
        inertia: Effective inertia at x = 0, shape (C, cells, Nu).
        bounds: Of the functions: of their errors, largest derivatives by x and by u, and largest
            values, shape (C, functions, SIZES).
        gap_bounds: Of the errors of the gaps and their derivatives, shape (C, 3 S).
        numbers: Shape (C, CHART_NUMBERS).
        beyond: How far springs are beyond those ends where x = 0, shape (C, R, cells, Nu).
        stops: Places of a chart, shape (C, 1 + K).
        lever: Rate of the normal gap by that of the coordinate, shape (K,) [m/rad or 1].
    """

    equation: FloatArray
    along: FloatArray
    gaps: FloatArray
    inertia: FloatArray
    bounds: FloatArray
    gap_bounds: FloatArray
    numbers: FloatArray
    beyond: FloatArray
    stops: NDArray[np.int64]
    lever: FloatArray


class Case(NamedTuple):
    """Numbers of a case. Of many cases they are rows of one array, in this order.

    Attributes:
        speed: Cylinder speed [rad/s].
        restitution: e_N of all stops, shape (K,).
        stiffness: Spring rates, shape (springs,).
        preload: Deflections in the springs at zero, likewise.
    """

    speed: float
    restitution: FloatArray
    stiffness: FloatArray
    preload: FloatArray


class Settings(NamedTuple):
    """What all cases of a call share.

    Attributes:
        rest_rate: Threshold of rest, 0 for the limit.
        tolerance: Relative accuracy.
        rough: Whether a stop may rest later than it does, where that is sure to change nothing.
    """

    rest_rate: float
    tolerance: float
    rough: bool = False


class Job(NamedTuple):
    """What is asked of them.

    Attributes:
        task: TRANSITIONS, ARRIVALS at the touch, or TURNS.
        bounces: Largest number of collisions of a series.
        turns: Largest number of turns; fewer are followed where they repeat.
        begin: Where turns start: chart, gap, its rate by time and by the cylinder, and whether its
            stop is closed.
        clamp: Place of the clamping stop among the stops.
        level: Force above which it clamps [N].
        touch: Angle psi of the touch [rad].
        sense: Sign of its rate.
    """

    task: int
    bounces: int
    turns: int = 0
    begin: tuple[int, float, float, float, bool] = (0, 0.0, 0.0, 0.0, False)
    clamp: int = 0
    level: float = 0.0
    touch: float = 0.0
    sense: float = 1.0


class Motion(NamedTuple):
    """State of a machine of one degree of freedom.

    Attributes:
        chart: The chart.
        u: Travel in it [rad].
        t: Time [s].
        x: Gap of its stop.
        v: Its rate.
        dt: Bound on the error of the time [s].
        dx: Bound on the error of the gap.
        dv: Bound on that of the rate.
    """

    chart: int
    u: float
    t: float
    x: float
    v: float
    dt: float
    dx: float
    dv: float


class Flown(NamedTuple):
    """How a flight ended.

    Attributes:
        status: AT_REST at its own stop, LEFT_TRAVEL at the end of the chart, OTHER_STOP where
            another stop closes; others if it cannot be followed.
        T: Its time [s].
        v: Rate at its end.
        top: Largest gap.
        peak: Time of that [s].
        a: x'' at its end.
        fastest: Largest rate.
        changed: Largest last change of x'' of a panel.
        left: Largest steady error of x'' of a panel.
        x: Gap at its end.
        hit: Number of the other stop, -1 without one.
        traced: Whether the growth of errors along it is known.
    """

    status: int
    T: float
    v: float
    top: float
    peak: float
    a: float
    fastest: float
    changed: float
    left: float
    x: float
    hit: int
    traced: bool


class Records(NamedTuple):
    """What a run writes.

    Attributes:
        events: Shape (most, COLUMNS).
        holds: Stretches on which the clamping stop is closed, shape (most, HOLD_COLUMNS).
        ends: Of the start and of each turn, shape (turns + 1, END_COLUMNS).
        counts: Events, stretches, turns and panels that were written, shape (COUNTS,).
        panels: Panels of the motion, shape (panels, SCRATCH_ROWS, N + 2); none: they are not kept.
    """

    events: FloatArray
    holds: FloatArray
    ends: FloatArray
    counts: NDArray[np.int64]
    panels: FloatArray


class Work(NamedTuple):
    """Scratch arrays of a call, made in it: no two threads share them.

    Attributes:
        mixed: Functions combined for the case, shape (C, cells, Nu, (3 + S) Nx): terms of x''
            without x', with it, with its square, then the gaps.
        sizes: Bounds of the case as polynomials of the rate, shape (C, 3 SIZES).
        line: x'' along x = 0 at rest, shape (C, cells, Nu).
        ready: Whether cells of the charts were combined, shape (C, cells).
        poly: A chart as polynomials in x at the nodes, shape (N + 1, (3 + S) Nx); the last row is
            for single points.
        nodes: Shape (SCRATCH_ROWS, N + 2).
        series: Times and rates of the bounces, and scratch, shape (3, collisions).
        memory: What is remembered of the motion, shape (MEMORY,).
    """

    mixed: FloatArray
    sizes: FloatArray
    line: FloatArray
    ready: NDArray[np.bool_]
    poly: FloatArray
    nodes: FloatArray
    series: FloatArray
    memory: FloatArray


class Solver(NamedTuple):
    """What the motion of a case is computed with.

    Attributes:
        grids: Collocation grids, shape (operators, levels, N, N + 2).
        charts: Those of the machine.
        work: Scratch arrays for them.
        one: The case.
        records: What is written of its motion.
    """

    grids: FloatArray
    charts: Charts
    work: Work
    one: Case
    records: Records
