"""Motions of a machine from event to event, compiled: flights, bounces, rests and changes of stops.

A transition is a turn that begins with the collision at the touch and ends with the first rest.
"""

from __future__ import annotations

import numpy as np

from ...tolerances.mechanics import EPS
from ...tolerances.reduced import LIMIT_ERROR_SAFETY
from . import layout as rows
from .closed import release_error, released
from .compiled import inlined, part
from .flight import describe, flight, keep
from .flight_errors import flight_errors, of_solver
from .hits import SolvedPanel
from .layout import Flown, Motion, Settings, Solver, numbered
from .panel import acceleration, contract, reach
from .series import settles, surely_over
from .turn_charts import chart_at, other_of, seen_by, surface
from .turn_events import TURN, errors_after, mark, note, rebounded, repeats, strike

# What a machine does next: its stop is closed, is about to be struck, has just been struck, is
# open; or its chart has ended, with the stop closed or open.
RESTING, STRIKING, STRUCK, FLYING, ENDED_CLOSED, ENDED_OPEN = numbered(6)


@part
def follow(solver: Solver, settings: Settings, turns: int, phase: int, at: Motion,
           clamp: int) -> tuple[int, int]:  # fmt: skip
    """Follow a motion from event to event.

    Args:
        turns: Number of turns; zero: up to the first rest, with the rebound before it.
        clamp: Place of the clamping stop among the stops.

    Returns:
        Status, and the number of turns after which the last one repeats an earlier one; 0 if it
        does not.
    """
    work, records = solver.work, solver.records
    records.counts[:] = 0
    work.memory[:] = 0.0
    work.memory[rows.LAST] = work.memory[rows.REST_CHART] = -1.0
    closed = float(at.chart) if phase == RESTING else -1.0
    mark(records.ends, rows.ZERO, (closed, np.inf), at)
    status, before = rows.GOES_ON, phase
    while status == rows.GOES_ON:
        if _no_room(solver):
            return rows.TOO_MANY, rows.ZERO
        now = phase
        if phase == RESTING:
            status, phase, at = _rest(solver, clamp, at)
        elif phase == STRIKING:
            if turns == 0 and _settled(solver):
                return rows.AT_REST, rows.ZERO
            phase, at = STRUCK, strike(solver, at)
        elif phase == STRUCK:
            status, phase, at = _bounce(solver, settings, turns == 0, at)
        elif phase == FLYING:
            status, phase, at = _fly(solver, settings, before == STRUCK, at)
        elif turns == 0:
            return rows.LEFT_TRAVEL, rows.ZERO
        else:
            status, phase, at = _take_over(solver, phase == ENDED_CLOSED, turns, at)
        before = now
    again = repeats(solver.charts, records.ends, records.counts[rows.DONE])
    return status, again if status == rows.AT_REST else rows.ZERO


@part
def _no_room(solver: Solver) -> bool:
    """Whether no event or stretch more can be written, or no panel kept."""
    records, counts = solver.records, solver.records.counts
    full = 0 < len(records.panels) < counts[rows.PANELS] + 2
    written = counts[rows.EVENTS] == len(records.events)
    return bool(written or full or counts[rows.STRETCHES] == len(records.holds))


@part
def _settled(solver: Solver) -> bool:
    """Whether the last event is a rest."""
    records = solver.records
    count = records.counts[rows.EVENTS]
    return bool(count > 0 and records.events[count - 1, rows.KIND] == rows.REST)


@part
def _rest(solver: Solver, clamp: int, at: Motion) -> tuple[int, int, Motion]:
    """Stay closed up to the end of the chart, or to where the force of the stop falls to zero."""
    charts, work, records, speed = solver.charts, solver.work, solver.records, solver.one.speed
    c, memory, line, number = at.chart, work.memory, work.line[at.chart], charts.numbers[at.chart]
    travel, per_rad = number[rows.TRAVEL_MOST], number[rows.PER_RAD]
    stop = charts.stops[c, rows.OWN]
    place = released(solver, c, line, at.u, travel)
    if place < 0.0:
        return rows.UNTOLD, RESTING, at
    at_end = place > travel
    u = travel if at_end else place
    for end in range(charts.beyond.shape[1]):
        if released(solver, c, charts.beyond[c, end], at.u, u) <= u:
            return rows.OFF_ROWS, RESTING, at
    freed = 0.0 if at_end else release_error(line, work.sizes[c], per_rad, u)
    if stop == clamp:
        _hold(solver, at, u, at_end, freed)
    gone = TURN * records.counts[rows.DONE] + number[rows.BEGIN] + u
    t = gone / speed
    dt = 4.0 * EPS * t + freed / speed
    panels = records.counts[rows.PANELS]
    keep(SolvedPanel(solver, c, rows.ZERO, at.u, (u - at.u) / speed, 0.0, 0.0), rows.ZERO, 1.0)
    describe(records, panels, max(at.dt, dt), 0.0, 0.0, 0.0)
    memory[rows.SETTLED] = memory[rows.UNSURE] = 0.0
    ended = Motion(c, u, t, 0.0, 0.0, dt, 0.0, 0.0)
    if at_end:
        return rows.GOES_ON, ENDED_CLOSED, ended
    note(records, rows.RELEASE, stop, t, gone, dt)
    memory[rows.REST_CHART], memory[rows.REST_END] = float(c), u
    memory[rows.BOUNCES], memory[rows.LAST] = 0.0, -1.0
    return rows.GOES_ON, FLYING, ended


@part
def _hold(solver: Solver, at: Motion, u: float, at_end: bool, freed: float) -> None:
    """Write a stretch on which the clamping stop was closed, up to a travel in the chart."""
    c, charts, counts = at.chart, solver.charts, solver.records.counts
    hold = solver.records.holds[counts[rows.STRETCHES]]
    same = charts.stops[charts.stops[c, rows.AFTER], rows.OWN] == charts.stops[c, rows.OWN]
    hold[rows.HOLD_TURN], hold[rows.HOLD_CHART] = counts[rows.DONE], c
    hold[rows.HOLD_BEGIN], hold[rows.HOLD_END] = at.u, u
    hold[rows.HOLD_BEGIN_ERROR] = solver.work.memory[rows.UNSURE]
    if at_end:
        hold[rows.ENDED_BY] = rows.REST if same else rows.COLLISION
        hold[rows.HOLD_END_ERROR] = 0.0 if same else charts.numbers[c, rows.CORNER_ERROR]
    else:
        hold[rows.ENDED_BY], hold[rows.HOLD_END_ERROR] = rows.RELEASE, freed
    counts[rows.STRETCHES] += 1


@inlined
def _bounce(solver: Solver, settings: Settings, to_rest: bool,
            at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Count a bounce, and come to rest where what is left of its series is known."""
    c, charts, records, speed = at.chart, solver.charts, solver.records, solver.one.speed
    memory, series = solver.work.memory, solver.work.series
    travel = charts.numbers[c, rows.TRAVEL_MOST]
    reach(solver, c, at.u, at.u)
    contract(solver, c, rows.ZERO, at.u)
    still = acceleration(solver, c, rows.ZERO, 0.0, 0.0)
    found, ahead, uncertain = at.v <= 0.0 and still < 0.0, 0.0, 0.0
    if at.v > 0.0:
        bounces = int(memory[rows.BOUNCES])
        if bounces >= series.shape[1]:
            return rows.TOO_MANY, STRUCK, at
        if bounces == 0:
            memory[rows.ORIGIN], memory[rows.FASTEST] = at.t, 0.0
        fastest = max(memory[rows.FASTEST], at.v)
        series[0, bounces], series[1, bounces] = at.t - memory[rows.ORIGIN], at.v
        memory[rows.BOUNCES], memory[rows.FASTEST] = bounces + 1.0, fastest
        late = at.v**3 <= settings.tolerance * fastest**3
        found, ahead, uncertain = settles(solver, settings, at, bounces + 1, late, still)
        if settings.rough and settings.rest_rate == 0.0 and not found:
            found, ahead = surely_over(solver, at, still)
            uncertain = 0.0
    elif to_rest and not found:
        return rows.NOT_PRESSED, STRUCK, at
    u = at.u + speed * ahead
    if not found or not (to_rest or u < travel):
        return rows.GOES_ON, FLYING, at
    dt = at.dt + LIMIT_ERROR_SAFETY * uncertain
    # What is ahead is proportional to the rate that it starts with.
    dt += abs(ahead) * (at.dv / at.v) if at.v > 0.0 else 0.0
    if not to_rest and u + speed * dt >= travel:
        return rows.UNTOLD, STRUCK, at
    t, gone = at.t + ahead, TURN * records.counts[rows.DONE] + charts.numbers[c, rows.BEGIN] + u
    note(records, rows.REST, charts.stops[c, rows.OWN], t, gone, dt)
    if to_rest:
        # The rebound of the last collision is flown all the same.
        return rows.GOES_ON if at.v > 0.0 else rows.AT_REST, FLYING, at
    memory[rows.SETTLED], memory[rows.UNSURE] = max(at.v, 0.0), speed * dt + 4.0 * EPS * TURN
    return rows.GOES_ON, RESTING, Motion(c, u, t, 0.0, 0.0, dt, 0.0, 0.0)


@inlined
def _fly(solver: Solver, settings: Settings, bounced: bool,
         at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Fly to the next collision, with the own stop or another one, or to the end of the chart."""
    c, charts, work, speed = at.chart, solver.charts, solver.work, solver.one.speed
    memory, nodes, sizes, records = work.memory, work.nodes, work.sizes[c], solver.records
    panels = records.counts[rows.PANELS]
    if not bounced:
        reach(solver, c, at.u, at.u)
        contract(solver, c, rows.ZERO, at.u)
    flown = flight(solver, at, settings.tolerance)
    status, T, rate, a, da = flown.status, flown.T, flown.v, flown.a, of_solver(sizes, flown)
    u, t = at.u + speed * T, at.t + T
    if status == rows.OTHER_STOP and flown.hit >= charts.stops.shape[1] - rows.OTHERS:
        return rows.OFF_ROWS, FLYING, at
    if status == rows.AT_REST:
        late, dv, wrong = flight_errors(sizes, speed, flown, at.dt, at.dv)
        if flown.traced:
            wrong, dv = errors_after(nodes, sizes, speed, flown, at, a / rate)
            late = wrong / abs(rate) + 4.0 * EPS * T
        dx_most, dv_most = max(at.dx, wrong, abs(rate) * late), max(at.dv, dv + abs(a) * late)
        describe(records, panels, max(at.dt, late), dx_most, dv_most, da)
        rebounded(solver, T, flown.top, late, wrong)
        return rows.GOES_ON, STRIKING, Motion(c, u, t, 0.0, rate, at.dt + late, 0.0, dv)
    if status != rows.OTHER_STOP and status != rows.LEFT_TRAVEL:
        return status, FLYING, at
    dx, dv = errors_after(nodes, sizes, speed, flown, at, 0.0)
    describe(records, panels, at.dt, max(at.dx, dx), max(at.dv, dv), da)
    if status == rows.OTHER_STOP:
        return _meet(solver, flown, Motion(c, u, t, flown.x, rate, at.dt, dx, dv))
    memory[rows.RISEN] = max(memory[rows.RISEN], flown.top)
    memory[rows.RISEN_ERROR] = max(memory[rows.RISEN_ERROR], dx, at.dx)
    memory[rows.FLOWN] += T
    memory[rows.FLOWN_ERROR] += at.dt
    dx, dv = dx + flown.fastest * at.dt, dv + abs(a) * at.dt
    return rows.GOES_ON, ENDED_OPEN, Motion(c, u, t, flown.x, rate, 0.0, dx, dv)


@part
def _meet(solver: Solver, flown: Flown, at: Motion) -> tuple[int, int, Motion]:
    """Go over to the chart of another stop that closes at the end of a flight."""
    c, charts, work, speed = at.chart, solver.charts, solver.work, solver.one.speed
    gaps, begin, s = charts.gaps[c], charts.numbers, flown.hit
    _, closing, d_gap, d_rate = seen_by(solver, s, at)
    to = chart_at(charts, charts.stops[c, rows.OTHERS + s], begin[c, rows.BEGIN] + at.u)
    if to < 0 or closing >= 0.0:
        return rows.OTHER_STOP, FLYING, at
    by_x = surface(gaps, len(gaps) // 3 + s, begin[c], at.u, at.x)
    late = d_gap / -closing
    dv = d_rate + 2.0 * (abs(by_x * flown.a) + speed * flown.fastest) * late
    u = at.u + (begin[c, rows.BEGIN] - begin[to, rows.BEGIN])
    work.memory[rows.BOUNCES] = 0.0
    return rows.GOES_ON, STRIKING, Motion(to, u, at.t, 0.0, closing, at.dt + late, 0.0, dv)


@part
def _take_over(solver: Solver, closed: bool, turns: int,
               at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Go on in the chart that follows, where another stop may throw the closed one open."""
    c, charts, records, speed = at.chart, solver.charts, solver.records, solver.one.speed
    memory, counts, number = solver.work.memory, records.counts, charts.numbers[c]
    to = charts.stops[c, rows.AFTER]
    same = charts.stops[to, rows.OWN] == charts.stops[c, rows.OWN]
    x, v, dx, dv = at.x, at.v, at.dx, at.dv
    if not closed and not same:
        s = other_of(charts, c, charts.stops[to, rows.OWN])
        x, v, dx, dv = seen_by(solver, s, at)
        memory[rows.BOUNCES], memory[rows.LAST] = 0.0, -1.0
        if x <= 0.0:
            return rows.UNRESOLVED, FLYING, at
    if closed and not same:
        memory[rows.REST_CHART], memory[rows.REST_END] = float(c), at.u
    begin = charts.numbers[to, rows.BEGIN]
    counts[rows.DONE] += 1 if begin == 0.0 else 0
    t = (TURN * counts[rows.DONE] + begin) / speed
    over = Motion(to, 0.0, t, x, v, at.dt, dx, dv)
    if begin == 0.0:
        if closed and same:
            memory[rows.REST_CHART], memory[rows.REST_END] = float(to), np.inf
        rest = memory[rows.REST_CHART], memory[rows.REST_END]
        mark(records.ends, counts[rows.DONE], rest, over)
        memory[rows.REST_CHART] = -1.0
        done = counts[rows.DONE]
        if done == turns or repeats(charts, records.ends, done) > 0:
            return rows.AT_REST, FLYING, over
    if closed and not same:
        if number[rows.THROW] <= 0.0:
            return rows.JAM, FLYING, over
        memory[rows.BOUNCES] = 0.0
        dt = 4.0 * EPS * t + number[rows.CORNER_ERROR] / speed
        v, dv = number[rows.ARRIVE] * speed, number[rows.ARRIVE_ERROR] * speed
        return rows.GOES_ON, STRIKING, Motion(to, 0.0, t, 0.0, v, dt, 0.0, dv)
    return rows.GOES_ON, RESTING if closed else FLYING, over
