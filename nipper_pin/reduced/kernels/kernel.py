"""Transitions of the reduced model, compiled: collisions, flights, rest, and the errors of all."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import ARRIVAL_SHARE, FINEST_TOLERANCE, LIMIT_ERROR_SAFETY
from . import layout as rows
from .arrival_check import arrives, in_flight, landed, line, prepare, released
from .compiled import compiled, part
from .flight import flight
from .flight_errors import flight_errors
from .layout import Cases, Settings, Start, Tables, Turn, Work
from .panel import acceleration, along, contract, grids
from .series import settles

# Where no first collision is given it is at the touch.
_AT_TOUCH, _NO_RESTS = np.empty((0, 4)), np.empty(0)


@part
def _transition(grids: FloatArray, tables: Tables, work: Work, speed: float, restitution: float,
                settings: Settings, start: Start,
                table: FloatArray) -> tuple[int, int, float, float]:  # fmt: skip
    """One transition into a table of shape (COLUMNS, collisions).

    The tables have been combined for the case.

    Returns:
        Status, number of collisions, time of rest, bound on its error.
    """
    case, mixed, poly, nodes, series = work.case, work.mixed, work.poly, work.nodes, work.series
    sizes, (rest_rate, tolerance) = work.sizes, settings
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
        C = along(tables.inertia, tables.travel, u)
        table[rows.TIME, n] = t
        table[rows.ANGLE, n] = tables.touch_angle + tables.sense * u
        table[rows.APPROACH, n] = before
        table[rows.SEPARATION, n] = w
        table[rows.IMPULSE, n] = C * (1.0 + restitution) * -before / tables.lever
        table[rows.ENERGY, n] = 0.5 * C * (1.0 - restitution * restitution) * before * before
        table[rows.TIME_ERROR, n] = dt
        table[rows.RATE_ERROR, n] = dv
        # The inertia changes by less than itself over the whole domain.
        relative = tables.inertia_residual + speed * dt / tables.travel
        about_stop = C * (1.0 + restitution) * (dv + abs(before) * relative)
        table[rows.IMPULSE_ERROR, n] = about_stop / tables.lever
        table[rows.AMPLITUDE, n] = table[rows.REBOUND, n] = 0.0
        table[rows.AMPLITUDE_ERROR, n] = table[rows.REBOUND_ERROR, n] = 0.0
        contract(mixed, poly, poly.shape[0] - 1, tables.travel, u)
        still = acceleration(case, poly, degree, 0.0, 0.0)
        if w <= 0.0:
            return (rows.AT_REST if still < 0.0 else rows.NOT_PRESSED), n + 1, t, dt
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
        if status != rows.AT_REST:
            table[rows.AMPLITUDE, n] = table[rows.REBOUND, n] = np.nan
            table[rows.AMPLITUDE_ERROR, n] = table[rows.REBOUND_ERROR, n] = np.nan
            return (rows.AT_REST if found else status), n + 1, rest, rest_error
        duration, dv, height = flight_errors(
            sizes, speed, T, v, a, peak, fastest, changed, left, dt, dw
        )
        table[rows.AMPLITUDE, n] = top
        table[rows.AMPLITUDE_ERROR, n] = height + 4.0 * EPS * top
        table[rows.REBOUND, n] = T
        table[rows.REBOUND_ERROR, n] = duration
        if found:
            return rows.AT_REST, n + 1, rest, rest_error
        t += T
        dt += duration
        before = v
    return rows.TOO_MANY, most, rest, rest_error


@part
def _flown(grids: FloatArray, tables: Tables, y: Tables, turn: Turn, work: Work, waiting: Work,
           speed: float, u: float, w: float, settings: Settings) -> tuple[bool, Start]:  # fmt: skip
    """First collision of a machine that arrives in flight."""
    none = Start(0.0, 0.0, 0.0, 0.0)
    finer = max(ARRIVAL_SHARE * settings.tolerance, FINEST_TOLERANCE)
    known, x, rate, dx, dv = in_flight(
        grids, y, turn, waiting, speed, u, w, settings.rest_rate, finer
    )
    if not known or not 0.0 < x < tables.high:
        return False, none
    ended, T, v, _, _, a, fastest, changed, left, _, _ = flight(
        grids, work.case, work.mixed, work.poly, work.nodes, tables.equation.shape[3], 0.0, x, rate,
        settings.tolerance, x < 0.0,
    )  # fmt: skip
    if int(ended) != rows.AT_REST or v >= 0.0:
        return False, none
    late, wrong = landed(work.sizes, speed, T, v, a, fastest, changed, left, dx, dv)
    return True, Start(speed * T, late, v, wrong)


@compiled
def _scratch(tables: Tables, series: FloatArray, line: FloatArray) -> Work:
    """Scratch arrays."""
    _, cells, count_u, count_x = tables.equation.shape
    size = (3 + tables.gaps.shape[0]) * count_x
    finest = rows.LEVELS[-1]
    return Work(
        np.zeros(rows.CASE_NUMBERS), np.zeros((cells, count_u, size)), np.zeros((finest + 1, size)),
        np.zeros((rows.SCRATCH_ROWS, finest + 2)), series, np.zeros((rows.SIZES, 3)), line,
    )  # fmt: skip


@part
def _summary(
    table: FloatArray, status: int, count: int, rest: float, error: float
) -> tuple[float, float, float, float]:
    """Duration, its error, share of the first two rebounds, worst relative error of four."""
    if status != rows.AT_REST:
        return np.nan, np.nan, np.nan, np.nan
    share = table[rows.TIME, 2] / rest if count > 2 and rest > 0.0 else np.nan
    bound = error / rest if rest > 0.0 else 0.0
    if table[rows.AMPLITUDE, 0] > 0.0:
        bound = max(bound, table[rows.AMPLITUDE_ERROR, 0] / table[rows.AMPLITUDE, 0])
    for n in range(min(2, count)):
        if table[rows.REBOUND, n] > 0.0:
            bound = max(bound, table[rows.REBOUND_ERROR, n] / table[rows.REBOUND, n])
    return rest, error, share, bound


@compiled
def run_batch(grids: FloatArray, tables: Tables, cases: Cases, settings: Settings,
              starts: FloatArray, table: FloatArray, status: NDArray[np.int64],
              counts: NDArray[np.int64], rest: FloatArray) -> None:  # fmt: skip
    """Transitions of a batch.

    Args:
        tables: The reduced model.
        starts: What :class:`Start` holds of each case, a rate of zero where that is not known,
            shape (n, 4); none for first collisions at the touch.
        table: Written: collisions, shape (n, COLUMNS, most); not beyond the last of a case.
        status: Written: shape (n,), integers.
        counts: Written: collisions, shape (n,), integers.
        rest: Written, shape (n, 4): time of rest and its error [s], share of the first two
            rebounds in it, bound on the worst relative error.
    """
    work = _scratch(tables, np.zeros((3, table.shape[2])), np.zeros((1, 1)))
    for i in range(len(cases.speed)):
        speed = cases.speed[i]
        start = Start(0.0, 0.0, tables.approach * speed, tables.approach_residual * speed)
        if len(starts) > 0:
            start = Start(starts[i, 0], starts[i, 1], starts[i, 2], starts[i, 3])
        status[i], counts[i], end, error = rows.UNTOLD, 0, np.nan, np.nan
        if start.rate < 0.0:
            prepare(tables, work, speed, cases.gravity[i], cases.stiffness[i], cases.preload[i])
            status[i], counts[i], end, error = _transition(
                grids, tables, work, speed, cases.restitution[i], settings, start, table[i]
            )
        rest[i, 0], rest[i, 1], rest[i, 2], rest[i, 3] = _summary(
            table[i], status[i], counts[i], end, error
        )


@compiled
def run_arrivals(grids: FloatArray, tables: Tables, y: Tables, turn: Turn, cases: Cases,
                 settings: Settings, premise: NDArray[np.int64], starts: FloatArray,
                 status: NDArray[np.int64], rests: FloatArray) -> None:  # fmt: skip
    """In which phase machines arrive at the touch, and where those in flight collide first.

    Args:
        tables: The reduced model.
        y: Its functions between opening and touch.
        turn: The rest of the turn.
        premise: Written where it is NOT_ASKED: HOLDS, FAILS or UNKNOWN, shape (n,), integers.
        starts: Written as ``run_batch`` reads it, if there is any.
        status: Of the transitions, shape (n,).
        rests: Travels of their rests, shape (n,) [rad], if these are known: the premise becomes
            UNKNOWN where a stop does not stay at rest until the opening.
    """
    work = _scratch(tables, np.zeros((3, 1)), np.zeros(turn.clamping.shape[1:]))
    waiting = _scratch(y, np.zeros((3, 1)), np.zeros(turn.waiting.shape[1:]))
    for i in range(len(cases.speed)):
        speed, gravity = cases.speed[i], cases.gravity[i]
        stiffness, preload = cases.stiffness[i], cases.preload[i]
        u = w = 0.0
        if premise[i] == rows.NOT_ASKED:
            prepare(y, waiting, speed, gravity, stiffness, preload)
            line(turn.waiting, speed, gravity, stiffness, preload, waiting.line)
            premise[i], u, w = arrives(grids, y, turn, waiting, speed, settings.rest_rate)
        if len(starts) > 0:
            start = Start(0.0, 0.0, tables.approach * speed, tables.approach_residual * speed)
            if premise[i] == rows.FAILS:
                prepare(tables, work, speed, gravity, stiffness, preload)
                found, start = _flown(grids, tables, y, turn, work, waiting, speed, u, w, settings)
                premise[i] = rows.FAILS if found else rows.UNKNOWN
            if premise[i] == rows.UNKNOWN:
                start = Start(0.0, 0.0, 0.0, 0.0)
            starts[i, 0], starts[i, 1], starts[i, 2], starts[i, 3] = start
        if len(rests) > 0 and premise[i] != rows.UNKNOWN:
            line(turn.clamping, speed, gravity, stiffness, preload, work.line)
            if not _clamps(turn, work.line, status[i], rests[i]):
                premise[i] = rows.UNKNOWN


@part
def _clamps(turn: Turn, line: FloatArray, status: int, rest: float) -> bool:
    """True if the transition stop is at rest at a travel and pressed shut until the opening."""
    if status != rows.AT_REST or not rest < turn.opening:
        return False
    return released(line, turn.opening, rest, turn.opening) > turn.opening


def premise_of(tables: Tables, y: Tables | None, turn: Turn | None, cases: Cases,
               settings: Settings, status: NDArray[np.int64],
               rests: FloatArray) -> NDArray[np.int64]:  # fmt: skip
    """Whether the machine arrives as a transition from the touch assumes: HOLDS, FAILS or UNKNOWN.

    Args:
        rests: Travels of the rests, shape (n,) [rad].
    """
    if y is None or turn is None:
        return np.full(len(rests), rows.UNKNOWN)
    premise = np.full(len(rests), rows.NOT_ASKED)
    run_arrivals(
        grids(), tables, y, turn, cases, settings, premise, _AT_TOUCH, status, rests
    )  # fmt: skip
    return premise


class Solved(NamedTuple):
    """What :func:`run_batch` writes, and the premise if that decided where transitions begin."""

    status: NDArray[np.int64]
    counts: NDArray[np.int64]
    rest: FloatArray
    premise: NDArray[np.int64] | None


def solve(tables: Tables, y: Tables | None, turn: Turn | None, cases: Cases, settings: Settings,
          assumed: bool, table: FloatArray) -> Solved:  # fmt: skip
    """Transitions from the touch, or as the turn brings the machine there where not ``assumed``.

    Args:
        table: Written: collisions, shape (n, COLUMNS, most); not beyond the last of a case.
    """
    n = len(cases.speed)
    status, counts = np.zeros((2, n), dtype=np.int64)
    rest, premise, starts = np.empty((n, 4)), None, _AT_TOUCH
    if not assumed:
        premise, starts = np.full(n, rows.UNKNOWN), np.zeros((n, 4))
        if y is not None and turn is not None:
            premise[:] = rows.NOT_ASKED
            run_arrivals(
                grids(), tables, y, turn, cases, settings, premise, starts, status, _NO_RESTS
            )
    run_batch(grids(), tables, cases, settings, starts, table, status, counts, rest)
    if premise is not None:
        rests = starts[:, 0] + cases.speed * rest[:, 0]
        if y is not None and turn is not None:
            run_arrivals(
                grids(), tables, y, turn, cases, settings, premise, _AT_TOUCH, status, rests
            )
        lost = (premise == rows.UNKNOWN) & (status == rows.AT_REST)
        status[lost], counts[lost], table[lost], rest[lost] = rows.UNTOLD, 0, np.nan, np.nan
    return Solved(status, counts, rest, premise)
