"""Transitions of many cases, compiled: their collisions and rests, and how machines arrive."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...tolerances.reduced import ARRIVAL_SHARE, FINEST_TOLERANCE
from . import layout as rows
from .arrival_check import arrives, in_flight, landed, line, released
from .compiled import compiled, part
from .flight import flight
from .layout import Case, Cases, Charts, Motion, Records, Settings, Turn, Work
from .panel import grids
from .turn import STRIKING, follow
from .turn_charts import case_of, scratch, visit

# Where no first collision is given it is at the touch.
_AT_TOUCH, _NO_RESTS = np.empty((0, 4)), np.empty(0)
# Rooms for events beyond the collisions: a rest, and the collision that is one too many.
BESIDE = 2


@part
def _touch(charts: Charts, speed: float) -> Motion:
    """The touch in the initial phase, just before the collision."""
    number = charts.numbers[0]
    rate, wrong = number[rows.ARRIVE] * speed, number[rows.ARRIVE_ERROR] * speed
    return Motion(rows.ZERO, 0.0, 0.0, 0.0, rate, 0.0, 0.0, wrong)


@part
def _flown(grids: FloatArray, charts: Charts, y: Charts, turn: Turn, work: Work, waiting: Work,
           one: Case, u: float, w: float, settings: Settings) -> tuple[bool, Motion]:  # fmt: skip
    """First collision of a machine that arrives in flight."""
    none = Motion(rows.ZERO, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    finer = max(ARRIVAL_SHARE * settings.tolerance, FINEST_TOLERANCE)
    known, x, rate, dx, dv = in_flight(
        grids, y, turn, waiting, one.speed, u, w, settings.rest_rate, finer
    )
    if not known or not 0.0 < x < charts.numbers[0, rows.HIGH]:
        return False, none
    work.ready[:] = False
    visit(charts, work, rows.ZERO, one)
    ended, T, v, _, _, a, fastest, changed, left, _, _ = flight(
        grids, work.case[0], work.mixed[0], work.poly, work.nodes, charts.equation.shape[4], 0.0, x,
        rate, settings.tolerance, x < 0.0,
    )  # fmt: skip
    if int(ended) != rows.AT_REST or v >= 0.0:
        return False, none
    late, wrong = landed(work.sizes[0], one.speed, T, v, a, fastest, changed, left, dx, dv)
    return True, Motion(rows.ZERO, one.speed * T, 0.0, 0.0, v, late, 0.0, wrong)


@part
def _told(events: FloatArray, count: int, angle: tuple[float, float]) -> None:
    """Tell angles in the place of travels, and the rebound of a collision without one."""
    touch, sense = angle
    for n in range(count):
        events[n, rows.ANGLE] = touch + sense * events[n, rows.TRAVEL]
    last = events[count - 1]
    if last[rows.SEPARATION] <= 0.0:
        last[rows.AMPLITUDE] = last[rows.AMPLITUDE_ERROR] = 0.0
        last[rows.REBOUND] = last[rows.REBOUND_ERROR] = 0.0


@part
def summary(events: FloatArray, status: int, count: int, rest: FloatArray) -> None:
    """Write duration, its error, share of the first two rebounds, worst relative error of four."""
    rest[:] = np.nan
    if status != rows.AT_REST:
        return
    duration, error = events[count, rows.TIME], events[count, rows.TIME_ERROR]
    rest[0], rest[1] = duration, error
    if count > 2 and duration > 0.0:
        rest[2] = events[2, rows.TIME] / duration
    rest[3] = error / duration if duration > 0.0 else 0.0
    if events[0, rows.AMPLITUDE] > 0.0:
        rest[3] = max(rest[3], events[0, rows.AMPLITUDE_ERROR] / events[0, rows.AMPLITUDE])
    for n in range(min(2, count)):
        if events[n, rows.REBOUND] > 0.0:
            rest[3] = max(rest[3], events[n, rows.REBOUND_ERROR] / events[n, rows.REBOUND])


@part
def _transition(grids: FloatArray, charts: Charts, work: Work, cases: Cases, i: int,
                settings: Settings, starts: FloatArray, angle: tuple[float, float],
                records: Records, told: NDArray[np.int64], rest: FloatArray) -> None:  # fmt: skip
    """One transition of a batch."""
    one, events, most = case_of(cases, i), records.events, len(records.events) - BESIDE
    begin = _touch(charts, one.speed)
    if len(starts) > 0:
        u, late, rate, wrong = starts[i, 0], starts[i, 1], starts[i, 2], starts[i, 3]
        begin = Motion(rows.ZERO, u, 0.0, 0.0, rate, late, 0.0, wrong)
    status, count = rows.UNTOLD, rows.ZERO
    if begin.v < 0.0:
        status, _ = follow(
            grids, charts, work, one, settings, rows.ZERO, STRIKING, begin, rows.ZERO, records
        )
        count = records.counts[rows.EVENTS]
        if events[count - 1, rows.KIND] == rows.REST:
            status, count = rows.AT_REST, count - 1
        count = min(count, most)
        _told(events, count, angle)
    told[i, 0], told[i, 1] = status, count
    summary(events, status, count, rest[i])
    events[count:] = np.nan


@compiled
def run_batch(grids: FloatArray, charts: Charts, cases: Cases, settings: Settings,
              starts: FloatArray, angle: tuple[float, float], table: FloatArray,
              told: NDArray[np.int64], rest: FloatArray) -> None:  # fmt: skip
    """Transitions of a batch.

    Args:
        charts: The domain of the reduced model.
        starts: First collisions: travel, error of its time, rate, zero where that is not known, and
            its error, shape (n, 4); none for first collisions at the touch.
        angle: Angle psi of the touch, and sign of its rate.
        table: Written: collisions, shape (n, most + BESIDE, COLUMNS); not beyond the last of a
            case.
        told: Written: status and number of collisions, shape (n, 2).
        rest: Written, shape (n, 4): time of rest and its error [s], share of the first two
            rebounds in it, bound on the worst relative error.
    """
    work = scratch(charts, table.shape[1] - BESIDE, 0)
    holds, ends = np.empty((1, rows.HOLD_COLUMNS)), np.empty((1, rows.END_COLUMNS))
    counts = np.zeros(rows.COUNTS, dtype=np.int64)
    for i in range(len(cases.speed)):
        records = Records(table[i], holds, ends, counts)
        _transition(grids, charts, work, cases, i, settings, starts, angle, records, told, rest)


@compiled
def run_arrivals(grids: FloatArray, charts: Charts, y: Charts, turn: Turn, cases: Cases,
                 settings: Settings, premise: NDArray[np.int64], starts: FloatArray,
                 told: NDArray[np.int64], rests: FloatArray) -> None:  # fmt: skip
    """In which phase machines arrive at the touch, and where those in flight collide first.

    Args:
        charts: The domain of the reduced model.
        y: Its functions between opening and touch.
        turn: The rest of the turn.
        premise: Written where it is NOT_ASKED: HOLDS, FAILS or UNKNOWN, shape (n,), integers.
        starts: Written as ``run_batch`` reads it, if there is any.
        told: Of the transitions, as ``run_batch`` writes it.
        rests: Travels of their rests, shape (n,) [rad], if these are known: the premise becomes
            UNKNOWN where a stop does not stay at rest until the opening.
    """
    work, waiting = scratch(charts, rows.ZERO, 0), scratch(y, rows.ZERO, 0)
    clamping = np.zeros(turn.clamping.shape[1:])
    for i in range(len(cases.speed)):
        _arrive(grids, charts, y, turn, work, waiting, clamping, cases, i, settings, premise,
                starts, told, rests)  # fmt: skip


@part
def _arrive(grids: FloatArray, charts: Charts, y: Charts, turn: Turn, work: Work, waiting: Work,
            clamping: FloatArray, cases: Cases, i: int, settings: Settings,
            premise: NDArray[np.int64], starts: FloatArray, told: NDArray[np.int64],
            rests: FloatArray) -> None:  # fmt: skip
    """One of the cases of ``run_arrivals``."""
    one, u, w = case_of(cases, i), 0.0, 0.0
    if premise[i] == rows.NOT_ASKED:
        waiting.ready[:] = False
        visit(y, waiting, rows.ZERO, one)
        line(turn.waiting, one, waiting.line[0])
        premise[i], u, w = arrives(grids, y, turn, waiting, one.speed, settings.rest_rate)
    if len(starts) > 0:
        start = _touch(charts, one.speed)
        if premise[i] == rows.FAILS:
            found, start = _flown(grids, charts, y, turn, work, waiting, one, u, w, settings)
            premise[i] = rows.FAILS if found else rows.UNKNOWN
        known = premise[i] != rows.UNKNOWN
        starts[i, 0], starts[i, 1] = start.u, start.dt
        starts[i, 2], starts[i, 3] = start.v if known else 0.0, start.dv
    if len(rests) > 0 and premise[i] != rows.UNKNOWN:
        line(turn.clamping, one, clamping)
        if not _clamps(turn, clamping, told[i, 0], rests[i]):
            premise[i] = rows.UNKNOWN


@part
def _clamps(turn: Turn, line: FloatArray, status: int, rest: float) -> bool:
    """True if the transition stop is at rest at a travel and pressed shut until the opening."""
    if status != rows.AT_REST or not rest < turn.opening:
        return False
    return released(line, turn.opening, rest, turn.opening) > turn.opening


class Machine(NamedTuple):
    """What compiled code reads of a reduced model.

    Attributes:
        charts: The domain.
        y: Its functions between opening and touch, or None.
        turn: The rest of the turn, or None.
        angle: Angle psi of the touch, and sign of its rate.
    """

    charts: Charts
    y: Charts | None
    turn: Turn | None
    angle: tuple[float, float]


def premise_of(machine: Machine, cases: Cases, settings: Settings, told: NDArray[np.int64],
               rests: FloatArray) -> NDArray[np.int64]:  # fmt: skip
    """Whether the machine arrives as a transition from the touch assumes: HOLDS, FAILS or UNKNOWN.

    Args:
        told: As ``run_batch`` writes it.
        rests: Travels of the rests, shape (n,) [rad].
    """
    charts, y, turn, _ = machine
    if y is None or turn is None:
        return np.full(len(rests), rows.UNKNOWN)
    premise = np.full(len(rests), rows.NOT_ASKED)
    run_arrivals(grids(), charts, y, turn, cases, settings, premise, _AT_TOUCH, told, rests)
    return premise


class Solved(NamedTuple):
    """What :func:`run_batch` writes, and the premise if that decided where transitions begin."""

    table: FloatArray
    told: NDArray[np.int64]
    rest: FloatArray
    premise: NDArray[np.int64] | None


def solve(machine: Machine, cases: Cases, settings: Settings, most: int,
          assumed: bool) -> Solved:  # fmt: skip
    """Transitions from the touch, or as the turn brings the machine there where not ``assumed``.

    Args:
        most: Largest number of collisions.
    """
    n, (charts, y, turn, angle) = len(cases.speed), machine
    table, rest = np.empty((n, most + BESIDE, rows.COLUMNS)), np.empty((n, 4))
    told = np.empty((n, 2), dtype=np.int64)
    premise, starts = None, _AT_TOUCH
    if not assumed:
        premise, starts = np.full(n, rows.UNKNOWN), np.zeros((n, 4))
        if y is not None and turn is not None:
            premise[:] = rows.NOT_ASKED
            run_arrivals(
                grids(), charts, y, turn, cases, settings, premise, starts, told, _NO_RESTS
            )
    run_batch(grids(), charts, cases, settings, starts, angle, table, told, rest)
    if premise is not None:
        if y is not None and turn is not None:
            rests = starts[:, 0] + cases.speed * rest[:, 0]
            run_arrivals(grids(), charts, y, turn, cases, settings, premise, _AT_TOUCH, told, rests)
        lost = (premise == rows.UNKNOWN) & (told[:, 0] == rows.AT_REST)
        told[lost], table[lost], rest[lost] = (rows.UNTOLD, 0), np.nan, np.nan
    return Solved(table, told, rest, premise)
