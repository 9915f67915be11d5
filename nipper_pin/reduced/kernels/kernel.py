"""Transitions of the reduced model, compiled: collisions, flights, rest, and the errors of all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import ARRIVAL_SHARE, FINEST_TOLERANCE, LIMIT_ERROR_SAFETY
from .arrival_check import arrives, in_flight, landed, line, prepare, released
from .compiled import compiled
from .flight import flight
from .flight_errors import flight_errors
from .layout import (
    AMPLITUDE,
    AMPLITUDE_ERROR,
    ANGLE,
    APPROACH,
    AT_REST,
    CASE_NUMBERS,
    COLUMNS,
    ENERGY,
    FAILS,
    IMPULSE,
    IMPULSE_ERROR,
    LEVELS,
    NOT_PRESSED,
    RATE_ERROR,
    REBOUND,
    REBOUND_ERROR,
    SCRATCH_ROWS,
    SEPARATION,
    SIZES,
    TIME,
    TIME_ERROR,
    TOO_MANY,
    UNKNOWN,
    UNTOLD,
    Start,
    Tables,
    Turn,
    Work,
)
from .panel import acceleration, chebyshev, contract
from .series import settles


@compiled
def _inertia(tables: Tables, u: float) -> float:
    """Effective inertia at x = 0."""
    cells, count = tables.inertia.shape
    width = tables.travel / cells
    cell = min(max(int(u / width), 0), cells - 1)
    place = 2.0 * (u - cell * width) / width - 1.0
    return chebyshev(tables.inertia, cell, 0, count, place)


@compiled
def _transition(grids: FloatArray, tables: Tables, work: Work, speed: float, restitution: float,
                rest_rate: float, tolerance: float, start: Start,
                table: FloatArray) -> tuple[int, int, float, float]:  # fmt: skip
    """One transition into a table of shape (COLUMNS, collisions).

    The tables have been combined for the case.

    Returns:
        Status, number of collisions, time of rest, bound on its error.
    """
    case, mixed, poly, nodes, series = work.case, work.mixed, work.poly, work.nodes, work.series
    sizes = work.sizes
    degree = tables.equation.shape[3]
    smallest = tolerance ** (1.0 / 3.0)
    most = table.shape[1]
    t = dw = 0.0
    dt, before, dv = start.late, start.rate, start.rate_error
    fastest_rebound = 0.0
    rest, rest_error = np.nan, np.nan
    for n in range(most):
        u = start.travel + speed * t
        w = -restitution * before
        dw = restitution * dv
        C = _inertia(tables, u)
        table[TIME, n] = t
        table[ANGLE, n] = tables.touch_angle + tables.sense * u
        table[APPROACH, n] = before
        table[SEPARATION, n] = w
        table[IMPULSE, n] = C * (1.0 + restitution) * -before / tables.lever
        table[ENERGY, n] = 0.5 * C * (1.0 - restitution * restitution) * before * before
        table[TIME_ERROR, n] = dt
        table[RATE_ERROR, n] = dv
        # The inertia changes by less than itself over the whole domain.
        relative = tables.inertia_residual + speed * dt / tables.travel
        about_stop = C * (1.0 + restitution) * (dv + abs(before) * relative)
        table[IMPULSE_ERROR, n] = about_stop / tables.lever
        table[AMPLITUDE, n] = table[REBOUND, n] = 0.0
        table[AMPLITUDE_ERROR, n] = table[REBOUND_ERROR, n] = 0.0
        contract(mixed, poly, poly.shape[0] - 1, tables.travel, u)
        still = acceleration(case, poly, degree, 0.0, 0.0)
        if w <= 0.0:
            return (AT_REST if still < 0.0 else NOT_PRESSED), n + 1, t, dt
        fastest_rebound = max(fastest_rebound, w)
        series[0, n] = t
        series[1, n] = w
        found, ahead, uncertain = settles(
            case, poly, degree, sizes, series, n + 1, w <= smallest * fastest_rebound, w, speed,
            restitution, rest_rate, tolerance, still,
        )  # fmt: skip
        if found:
            rest = t + ahead
            # What is ahead is proportional to the rate that it starts with.
            rest_error = dt + LIMIT_ERROR_SAFETY * uncertain + abs(ahead) * (dw / w)
        ended, T, v, top, peak, a, fastest, changed, left, _, _ = flight(
            grids, case, mixed, poly, nodes, degree, u, 0.0, w, tolerance,
            n == 0 and start.travel == 0.0,
        )  # fmt: skip
        status = int(ended)
        if status != AT_REST:
            table[AMPLITUDE, n] = table[REBOUND, n] = np.nan
            table[AMPLITUDE_ERROR, n] = table[REBOUND_ERROR, n] = np.nan
            return (AT_REST if found else status), n + 1, rest, rest_error
        duration, dv, height = flight_errors(
            sizes, speed, T, v, a, peak, fastest, changed, left, dt, dw
        )
        table[AMPLITUDE, n] = top
        table[AMPLITUDE_ERROR, n] = height + 4.0 * EPS * top
        table[REBOUND, n] = T
        table[REBOUND_ERROR, n] = duration
        if found:
            return AT_REST, n + 1, rest, rest_error
        t += T
        dt += duration
        before = v
    return TOO_MANY, most, rest, rest_error


@compiled
def _solved(grids: FloatArray, tables: Tables, y: Tables, turn: Turn, work: Work, waiting: Work,
            speed: float, restitution: float, stiffness: FloatArray, preload: FloatArray,
            gravity: float, rest_rate: float, tolerance: float, assumed: bool, table: FloatArray,
            ) -> tuple[int, int, float, float, int]:  # fmt: skip
    """One transition, from where it starts; see :func:`run_batch`.

    Returns:
        What :func:`_transition` does, and whether the premise holds.
    """
    prepare(tables, work, speed, gravity, stiffness, preload)
    before = tables.approach * speed
    start = Start(0.0, 0.0, before, tables.approach_residual * speed)
    premise = UNKNOWN
    if turn.known > 0.0:
        prepare(y, waiting, speed, gravity, stiffness, preload)
        line(turn.waiting, speed, gravity, stiffness, preload, waiting.line)
        premise, u, w = arrives(grids, y, turn, waiting, speed, rest_rate)
        if premise == FAILS and not assumed:
            found, start = _flown(
                grids, tables, y, turn, work, waiting, speed, u, w, rest_rate, tolerance
            )
            premise = FAILS if found else UNKNOWN
    if premise == UNKNOWN and not assumed:
        return UNTOLD, 0, np.nan, np.nan, premise
    status, count, rest, error = _transition(
        grids, tables, work, speed, restitution, rest_rate, tolerance, start, table
    )
    if premise != UNKNOWN and not _clamps(
        turn, waiting, speed, gravity, stiffness, preload, status, start.travel + speed * rest
    ):
        premise = UNKNOWN
        if status == AT_REST and not assumed:
            table[:] = np.nan
            return UNTOLD, 0, np.nan, np.nan, premise
    return status, count, rest, error, premise


@compiled
def _flown(grids: FloatArray, tables: Tables, y: Tables, turn: Turn, work: Work, waiting: Work,
           speed: float, u: float, w: float, rest_rate: float, tolerance: float,
           ) -> tuple[bool, Start]:  # fmt: skip
    """First collision of a machine that arrives in flight."""
    none = Start(0.0, 0.0, 0.0, 0.0)
    finer = max(ARRIVAL_SHARE * tolerance, FINEST_TOLERANCE)
    known, x, rate, dx, dv = in_flight(grids, y, turn, waiting, speed, u, w, rest_rate, finer)
    if not known or not 0.0 < x < tables.high:
        return False, none
    ended, T, v, _, _, a, fastest, changed, left, _, _ = flight(
        grids, work.case, work.mixed, work.poly, work.nodes, tables.equation.shape[3], 0.0, x, rate,
        tolerance, False,
    )  # fmt: skip
    if int(ended) != AT_REST or v >= 0.0:
        return False, none
    late, wrong = landed(work.sizes, speed, T, v, a, fastest, changed, left, dx, dv)
    return True, Start(speed * T, late, v, wrong)


@compiled
def _clamps(turn: Turn, waiting: Work, speed: float, gravity: float, stiffness: FloatArray,
            preload: FloatArray, status: int, u: float) -> bool:  # fmt: skip
    """True if the transition stop is at rest at travel u and pressed shut until the opening."""
    if status != AT_REST or not u < turn.opening:
        return False
    line(turn.clamping, speed, gravity, stiffness, preload, waiting.line)
    cells, count = turn.clamping.shape[1], turn.clamping.shape[2]
    return released(waiting.line, cells, count, turn.opening, u, turn.opening) > turn.opening


@compiled
def _scratch(tables: Tables, turn: Turn, most: int) -> Work:
    """Scratch arrays."""
    _, cells, count_u, count_x = tables.equation.shape
    rows = (3 + tables.gaps.shape[0]) * count_x
    finest = LEVELS[-1]
    lines = max(turn.waiting.shape[1], turn.clamping.shape[1])
    longest = max(turn.waiting.shape[2], turn.clamping.shape[2])
    return Work(
        np.zeros(CASE_NUMBERS), np.zeros((cells, count_u, rows)), np.zeros((finest + 1, rows)),
        np.zeros((SCRATCH_ROWS, finest + 2)), np.zeros((3, most)),
        np.zeros((SIZES, 3)), np.zeros((lines, longest)),
    )  # fmt: skip


@compiled
def _summary(
    table: FloatArray, status: int, count: int, rest: float, error: float
) -> tuple[float, float, float, float]:
    """Duration, its error, share of the first two rebounds, worst relative error of four."""
    if status != AT_REST:
        return np.nan, np.nan, np.nan, np.nan
    share = table[TIME, 2] / rest if count > 2 and rest > 0.0 else np.nan
    bound = error / rest if rest > 0.0 else 0.0
    if table[AMPLITUDE, 0] > 0.0:
        bound = max(bound, table[AMPLITUDE_ERROR, 0] / table[AMPLITUDE, 0])
    for n in range(min(2, count)):
        if table[REBOUND, n] > 0.0:
            bound = max(bound, table[REBOUND_ERROR, n] / table[REBOUND, n])
    return rest, error, share, bound


@compiled
def run_one(grids: FloatArray, tables: Tables, y: Tables, turn: Turn, speed: float,
            restitution: float, stiffness: FloatArray, preload: FloatArray, gravity: float,
            rest_rate: float, tolerance: float, assumed: bool, most: int,
            ) -> tuple[int, tuple[float, float, float, float], int, FloatArray]:  # fmt: skip
    """One transition; see :func:`run_batch`.

    Returns:
        Status, what :func:`run_batch` writes to ``rest`` and to ``premise``, and the table, shape
        (COLUMNS, count).
    """
    table = np.empty((COLUMNS, most))
    status, count, rest, error, premise = _solved(
        grids, tables, y, turn, _scratch(tables, turn, most), _scratch(y, turn, 1), speed,
        restitution, stiffness, preload, gravity, rest_rate, tolerance, assumed, table,
    )  # fmt: skip
    return (
        status, _summary(table, status, count, rest, error), premise, table[:, :count].copy()
    )  # fmt: skip


@compiled
def run_batch(grids: FloatArray, tables: Tables, y: Tables, turn: Turn, speed: FloatArray,
              restitution: FloatArray, stiffness: FloatArray, preload: FloatArray,
              gravity: FloatArray, rest_rate: float, tolerance: float, assumed: bool,
              table: FloatArray, status: NDArray[np.int64], counts: NDArray[np.int64],
              premise: NDArray[np.int64], rest: FloatArray) -> None:  # fmt: skip
    """Transitions of a batch.

    Args:
        tables: The reduced model.
        y: Its functions between opening and touch.
        turn: The rest of the turn.
        speed: Cylinder speeds, shape (n,) [rad/s].
        restitution: Shape (n,).
        stiffness: Shape (n, springs).
        preload: Shape (n, springs).
        gravity: By the gravity of the model, shape (n,).
        rest_rate: Threshold of rest, or 0 for the limit of the series.
        tolerance: Relative accuracy of flights and of the limit.
        assumed: Whether a transition starts in the initial phase even if its premise fails.
        table: Written: collisions, shape (n, COLUMNS, most), filled with NaN beforehand.
        status: Written: shape (n,), integers.
        counts: Written: collisions, shape (n,), integers.
        premise: Written: HOLDS, FAILS or UNKNOWN, shape (n,), integers.
        rest: Written, shape (n, 4): time of rest and its error [s], share of the first two
            rebounds in it, bound on the worst relative error.
    """
    work, waiting = _scratch(tables, turn, table.shape[2]), _scratch(y, turn, 1)
    for i in range(len(speed)):
        status[i], counts[i], end, error, premise[i] = _solved(
            grids, tables, y, turn, work, waiting, speed[i], restitution[i], stiffness[i],
            preload[i], gravity[i], rest_rate, tolerance, assumed, table[i],
        )  # fmt: skip
        rest[i, 0], rest[i, 1], rest[i, 2], rest[i, 3] = _summary(
            table[i], status[i], counts[i], end, error
        )
