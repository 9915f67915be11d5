"""Layout of the arrays that compiled code reads and writes, and its status codes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...arrays import FloatArray


def numbered(count: int, first: int = 0) -> Any:
    """Numbers as NumPy has them: for each of Python's a function is compiled anew."""
    return np.arange(first, first + count)


ZERO: int = numbered(1)[0]
NO: Any = np.bool_(False)
# Status of a case.
(
    AT_REST, LEFT_TRAVEL, LEFT_GAP, OTHER_STOP, NOT_PRESSED, TOO_MANY, UNRESOLVED, UNTOLD, JAM,
    OFF_ROWS,
) = numbered(10)  # fmt: skip
# Rows of the table of collisions.
(
    TIME, ANGLE, APPROACH, SEPARATION, IMPULSE, ENERGY, AMPLITUDE, REBOUND,
    TIME_ERROR, RATE_ERROR, IMPULSE_ERROR, AMPLITUDE_ERROR, REBOUND_ERROR,
) = numbered(13)  # fmt: skip
COLUMNS = 13
LEVELS = (4, 7, 13, 25)

# Operators on nodal values: integrals at nodes (ONCE, TWICE) and probes, Chebyshev coefficients
# (VALUE, INTEGRAL, DOUBLE); REFINE from the coarser grid; SIGMA holds the nodes, then the probes.
(
    ONCE, TWICE, VALUE, INTEGRAL, DOUBLE, REFINE, PROBE, PROBE_ONCE, PROBE_TWICE, SIGMA,
) = numbered(10)  # fmt: skip
PROBES = 3
# Rows of the scratch array: values at the nodes, and the coefficients of the panel's motion. A
# block of the same rows follows for every panel that is kept; see the module that keeps them.
NODE_A, NODE_NEW, NODE_X, NODE_V, SERIES, SERIES_ONCE, SERIES_TWICE, GROWTH, KEPT = numbered(9)
SCRATCH_ROWS = 9
# Numbers of a case and its domain. `SCALE` takes x - low to [0, 2]; `SPAN` is the length of all
# cells, also beyond the end; `TRACED` is 1 where long flights tell how errors grow along them.
SPEED, TRAVEL_MOST, LOW, HIGH, SCALE, SPAN, TRACED = numbered(7)
CASE_NUMBERS = 7
# Whether the machine arrives in its initial phase at the touch.
NOT_ASKED, UNKNOWN, FAILS, HOLDS = numbered(4, -2)
# Rows of the sums that bound the error of x'' and its derivatives by x, travel and rate; columns
# are the powers of the rate.
RESIDUAL, BY_X, BY_U, BY_V = numbered(4)
SIZES = 4


class Tables(NamedTuple):
    """Arrays of a reduced model; see :class:`nipper_pin.reduced.model.ReducedModel`."""

    equation: FloatArray
    gaps: FloatArray
    inertia: FloatArray
    residual: FloatArray
    largest: FloatArray
    steepest_x: FloatArray
    steepest_u: FloatArray
    travel: float
    low: float
    high: float
    inertia_residual: float
    approach: float = 0.0
    approach_residual: float = 0.0
    touch_angle: float = 0.0
    sense: float = 1.0
    lever: float = 1.0


class Cases(NamedTuple):
    """Numbers of n cases.

    Attributes:
        speed: Cylinder speeds, shape (n,) [rad/s].
        restitution: e_N of the transition stop, shape (n,); of turns those of all stops, (n, K).
        stiffness: Spring rates, shape (n, springs).
        preload: Deflections in the springs at zero, likewise.
        gravity: By the gravity of the model, shape (n,).
    """

    speed: FloatArray
    restitution: FloatArray
    stiffness: FloatArray
    preload: FloatArray
    gravity: FloatArray


class Settings(NamedTuple):
    """What all cases of a call share: threshold of rest, 0 for the limit, and relative accuracy."""

    rest_rate: float
    tolerance: float


class Start(NamedTuple):
    """First collision of a transition.

    Attributes:
        travel: Travel of the cylinder from the touch configuration [rad].
        late: Bound on the error of its time [s].
        rate: Rate of x before it, negative.
        rate_error: Bound on the error of that.
    """

    travel: float
    late: float
    rate: float
    rate_error: float


class Turn(NamedTuple):
    """What a turn does from its opening to the touch; y is the coordinate of the waiting stop.

    The waiting stop is the one that is closed in the initial phase. It is reached where the
    transition stop opens, bounces, rests, may be left again, and should be closed at the touch.

    Attributes:
        opening: Travel from the touch to the opening [rad].
        restitution: e_N of the waiting stop.
        clamping: Functions in x'' along x = 0 from the touch to the opening,
            shape (functions, cells, N).
        waiting: Functions in y'' along y = 0 from the opening to the touch, likewise.
        residual: Bounds on the errors of the functions in ``clamping``, shape (functions,).
        touch: Series in y at the touch of x and its derivatives by y and by u, shape (3, N).
        touch_errors: Bounds on their errors, shape (3,).
    """

    opening: float
    restitution: float
    clamping: FloatArray
    waiting: FloatArray
    residual: FloatArray
    touch: FloatArray
    touch_errors: FloatArray


class Work(NamedTuple):
    """Scratch arrays of one call, made in it: no two threads share them.

    Attributes:
        case: Numbers of the case, shape (CASE_NUMBERS,).
        mixed: Functions combined for the case, shape (cells, Nu, (3 + other stops) Nx): terms of
            x'' without x', with it, with its square, then the gaps.
        poly: The same as polynomials in x at the nodes, shape (N + 1, (3 + other stops) Nx); the
            last row is for single points.
        nodes: Shape (SCRATCH_ROWS, N + 2).
        series: Times and rates of the bounces, and scratch, shape (3, collisions).
        sizes: Bounds of the case as polynomials of the rate, shape (SIZES, 3).
        line: A function along a stop, combined for the case, shape (cells, N).
    """

    case: FloatArray
    mixed: FloatArray
    poly: FloatArray
    nodes: FloatArray
    series: FloatArray
    sizes: FloatArray
    line: FloatArray
