"""What is asked of many cases, compiled: transitions, how machines arrive at them, and turns."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...tolerances.reduced import (
    ARRIVAL_SHARE,
    BEFORE_TOUCH,
    FINEST_TOLERANCE,
    FLIGHT_UNRESOLVED,
    PHASE_TOLERANCE,
)
from . import layout as rows
from .closed import released
from .compiled import compiled, part
from .in_memory import in_memory
from .layout import Charts, Job, Motion, Plain, Records, Settings, Solver, Work
from .turn import FLYING, STRIKING, follow
from .turn_charts import case_of, prepare, records_in, scratch
from .turn_quantities import turns_of

# Charts of the rest of a turn: of the clamping stop up to its opening, of the waiting one from
# there to the touch.
_CLAMPING, _WAITING = rows.numbered(2)
_ONE_TURN: int = rows.numbered(1, 1)[0]


@part
def _met(solver: Solver, c: int, to: int) -> Motion:
    """Just before the collision of the stop that takes over at the end of a chart."""
    number, speed = solver.charts.numbers[c], solver.one.speed
    rate, wrong = number[rows.ARRIVE] * speed, number[rows.ARRIVE_ERROR] * speed
    return Motion(to, 0.0, 0.0, 0.0, rate, 0.0, 0.0, wrong)


@part
def _arrival(solver: Solver, settings: Settings, vague: float) -> tuple[int, Motion]:
    """In which phase a machine arrives at the touch: HOLDS, FAILS or UNKNOWN, and its state.

    Motion after a rest is independent of the motion before it.

    Args:
        solver: With the charts of the rest of the turn.
        settings: Of these flights.
        vague: Error of the gap at the touch, by the gap, from which on a flight is not known.
    """
    records, numbers = solver.records, solver.charts.numbers
    opening = _met(solver, _CLAMPING, _WAITING)
    status, _ = follow(solver, settings, _ONE_TURN, STRIKING, opening, _CLAMPING)
    end, last = records.ends[1], records.events[records.counts[rows.EVENTS] - 1]
    at = Motion(_CLAMPING, 0.0, 0.0, end[3], end[4], 0.0, end[5], end[6])
    near = BEFORE_TOUCH + solver.one.speed * last[rows.TIME_ERROR]
    if status != rows.AT_REST or last[rows.TRAVEL] > 2.0 * pi - near:
        return rows.UNKNOWN, at
    if end[1] >= numbers[_WAITING, rows.TRAVEL_MOST]:
        return rows.HOLDS, at
    known = at.x < numbers[_CLAMPING, rows.HIGH] and at.dx < vague * at.x
    return rows.FAILS if known else rows.UNKNOWN, at


@part
def _transition(solver: Solver, settings: Settings, job: Job, told: NDArray[np.int64]) -> None:
    """One transition: from the touch, from the flight over it, or from what is not known."""
    events = solver.records.events
    most, end = len(events) - rows.BESIDE, len(events) - 1
    phase, at = STRIKING, _met(solver, _CLAMPING, _CLAMPING)
    if told[2] == rows.FAILS:
        x, v, dx, dv = events[0, 0], events[0, 1], events[0, 2], events[0, 3]
        phase, at = FLYING, Motion(_CLAMPING, 0.0, 0.0, x, v, 0.0, dx, dv)
    status, count = rows.UNTOLD, rows.ZERO
    if told[2] != rows.UNKNOWN:
        status, _ = follow(solver, settings, rows.ZERO, phase, at, _CLAMPING)
        count = solver.records.counts[rows.EVENTS]
    rests = count > 0 and events[count - 1, rows.KIND] == rows.REST
    if rests:
        status, count = rows.AT_REST, count - 1
    first = events[0, rows.TIME]
    for column in range(rows.COLUMNS):
        events[end, column] = events[count, column] if rests else np.nan
    events[end, rows.TIME] -= first
    told[0], told[1] = status, min(count, most)
    events[told[1] : end] = np.nan
    for n in range(told[1]):
        events[n, rows.TIME] -= first
        events[n, rows.ANGLE] = job.touch + job.sense * events[n, rows.TRAVEL]
    last = events[told[1] - 1]
    if told[1] > 0 and last[rows.SEPARATION] <= 0.0:
        # It has no rebound.
        last[rows.AMPLITUDE] = last[rows.AMPLITUDE_ERROR] = 0.0
        last[rows.REBOUND] = last[rows.REBOUND_ERROR] = 0.0


@part
def _premise(solver: Solver, settings: Settings, found: FloatArray,
             told: NDArray[np.int64]) -> None:  # fmt: skip
    """Find how one machine arrives, and how its transition begins, or whether that ends so."""
    opening = solver.charts.numbers[_CLAMPING, rows.TRAVEL_MOST]
    if told[2] == rows.NOT_ASKED:
        rough = Settings(settings.rest_rate, PHASE_TOLERANCE, True)
        told[2], _ = _arrival(solver, rough, 1.0)
        if told[0] == rows.GOES_ON and told[2] == rows.FAILS:
            finer = max(ARRIVAL_SHARE * settings.tolerance, FINEST_TOLERANCE)
            fine = Settings(settings.rest_rate, finer, False)
            told[2], at = _arrival(solver, fine, FLIGHT_UNRESOLVED)
            found[0, 0], found[0, 1], found[0, 2], found[0, 3] = at.x, at.v, at.dx, at.dv
    if told[0] != rows.GOES_ON:
        # Whether the clamping stop rests and is pressed shut from there up to its opening.
        rest, line = found[len(found) - 1, rows.TRAVEL], solver.work.line[_CLAMPING]
        rests = told[0] == rows.AT_REST and rest < opening
        if not rests or released(solver, _CLAMPING, line, rest, opening) <= opening:
            told[2] = rows.UNKNOWN


@compiled
def run(grids: FloatArray, charts: Plain, cases: FloatArray, settings: Plain, job: Plain,
        events: FloatArray, told: NDArray[np.int64], found: FloatArray) -> None:  # fmt: skip
    """Do for each case of a batch what is asked.

    One function for all, since what they have in common takes seconds to compile.

    Args:
        charts: Of transitions the domain of the reduced model, of arrivals those of the rest of
            the turn, of turns those of the machine.
        cases: A row a case, as of :class:`~.layout.Case`.
        job: As of :class:`~.layout.Job`.
        events: Written: of each transition, shape (n, most + BESIDE, COLUMNS), NaN beyond the last
            collision, but the last row is its rest, whose travel is told; of all others scratch,
            which then has the last case, shape (1, most, COLUMNS).
        told: Written. Of transitions and arrivals status (GOES_ON before), number of collisions,
            and premise: HOLDS or NOT_ASKED, where transitions begin at the touch, FAILS, where they
            begin in flight over it, or UNKNOWN; shape (n, 3). Arrivals find it where it is
            NOT_ASKED; where transitions are known it becomes UNKNOWN for one that does not rest up
            to the opening. Of turns status, turns, after how many the last repeats, and events,
            shape (n, 4).
        found: Those events of transitions; arrivals write the first numbers of those in flight
            over the touch: gap, rate, and bounds on the errors of both. Or, written, quantities of
            turns, the last one first, NaN before the first one, shape (n, last, quantities).
    """
    machine, shared, asked = Charts(*charts), Settings(*settings), Job(*job)
    work, room = scratch(machine, asked.bounces), records_in(events[0], asked.turns, 0)
    _all(grids, machine, work, cases, shared, asked, room, events, told, found)


@part
def _all(grids: FloatArray, machine: Charts, scratches: Work, cases: FloatArray, settings: Settings,
         job: Job, room: Records, events: FloatArray, told: NDArray[np.int64], found: FloatArray,
         ) -> None:  # fmt: skip
    """All cases, one after the other."""
    charts, work = in_memory(machine), in_memory(scratches)
    for i in range(len(cases)):
        own = events[min(i, len(events) - 1)]
        records = in_memory(Records(own, room.holds, room.ends, room.counts, room.panels))
        one = in_memory(case_of(machine, cases[i]))
        solver = in_memory(Solver(grids, charts, work, one, records))
        prepare(solver, job.task != rows.TRANSITIONS)
        if job.task == rows.TRANSITIONS:
            _transition(solver, settings, job, told[i])
        elif job.task == rows.ARRIVALS:
            _premise(solver, settings, found[i], told[i])
        else:
            turns_of(solver, settings, job, told[i], found[i])
