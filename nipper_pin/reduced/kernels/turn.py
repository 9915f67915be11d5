"""Motions of a machine from event to event, compiled: flights, bounces, rests and changes of stops.

A transition is a turn that begins with the collision at the touch and ends with the first rest.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import LIMIT_ERROR_SAFETY
from . import layout as rows
from .compiled import inlined, part
from .flight import describe, flight, full, keep_rest, kept
from .flight_errors import flight_errors
from .layout import Case, Charts, Motion, Records, Settings, Work, numbered
from .panel import acceleration, contract, reach
from .release import release_error, released
from .series import settles, surely_over
from .turn_charts import (
    chart_at,
    other_of,
    press,
    seen_by,
    source_of,
    surface,
)
from .turn_events import TURN, errors_after, mark, note, rebounded, repeats, strike

# What a machine does next: its stop is closed, is about to be struck, has just been struck, is
# open; or its chart has ended, with the stop closed or open.
RESTING, STRIKING, STRUCK, FLYING, ENDED_CLOSED, ENDED_OPEN = numbered(6)


@part
def follow(grids: FloatArray, charts: Charts, work: Work, one: Case, settings: Settings, turns: int,
           phase: int, at: Motion, clamp: int, records: Records) -> tuple[int, int]:  # fmt: skip
    """Follow a motion from event to event.

    Args:
        turns: Number of turns; zero: up to the first rest, with the rebound before it.
        clamp: Place of the clamping stop among the stops.

    Returns:
        Status, and the number of turns after which the last one repeats an earlier one; 0 if it
        does not.
    """
    work.pressed[:] = False
    records.counts[:] = 0
    work.memory[:] = 0.0
    work.memory[rows.LAST] = work.memory[rows.REST_CHART] = -1.0
    closed = float(at.chart) if phase == RESTING else -1.0
    mark(records.ends, rows.ZERO, (closed, np.inf), at)
    status, before = rows.GOES_ON, phase
    while status == rows.GOES_ON:
        if _no_room(work, records):
            return rows.TOO_MANY, rows.ZERO
        press(charts, work, at.chart, one)
        now = phase
        if phase == RESTING:
            status, phase, at = _rest(charts, work, one, clamp, records, at)
        elif phase == STRIKING:
            if turns == 0 and _settled(records):
                return rows.AT_REST, rows.ZERO
            phase, at = STRUCK, strike(charts, work, one, records, at)
        elif phase == STRUCK:
            status, phase, at = _bounce(charts, work, one, settings, turns == 0, records, at)
        elif phase == FLYING:
            bounced = before == STRUCK
            status, phase, at = _fly(grids, charts, work, one, settings, bounced, records, at)
        elif turns == 0:
            return rows.LEFT_TRAVEL, rows.ZERO
        else:
            closed = phase == ENDED_CLOSED
            status, phase, at = _take_over(charts, work, one, closed, turns, records, at)
        before = now
    again = repeats(charts, records.ends, records.counts[rows.TURNS])
    return status, again if status == rows.AT_REST else rows.ZERO


@part
def _no_room(work: Work, records: Records) -> bool:
    """Whether no event or stretch more can be written, or no panel kept."""
    events, stretches = records.counts[rows.EVENTS], records.counts[rows.STRETCHES]
    return events == len(records.events) or stretches == len(records.holds) or full(work.nodes)


@part
def _settled(records: Records) -> bool:
    """Whether the last event is a rest."""
    count = records.counts[rows.EVENTS]
    return bool(count > 0 and records.events[count - 1, rows.KIND] == rows.REST)


@part
def _rest(charts: Charts, work: Work, one: Case, clamp: int, records: Records,
          at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Stay closed up to the end of the chart, or to where the force of the stop falls to zero."""
    c, memory, line, number = at.chart, work.memory, work.line[at.chart], charts.numbers[at.chart]
    travel, per_rad, stop = (
        number[rows.TRAVEL_MOST],
        number[rows.PER_RAD],
        charts.stops[c, rows.OWN],
    )
    place = released(line, per_rad, at.u, travel)
    if place < 0.0:
        return rows.UNTOLD, RESTING, at
    at_end = place > travel
    u = travel if at_end else place
    for end in range(charts.beyond.shape[1]):
        if released(charts.beyond[c, end], per_rad, at.u, u) <= u:
            return rows.OFF_ROWS, RESTING, at
    freed = 0.0 if at_end else release_error(line, work.sizes[c], per_rad, u)
    if stop == clamp:
        _hold(charts, memory, records, at, u, at_end, freed)
    gone = TURN * records.counts[rows.TURNS] + number[rows.BEGIN] + u
    t = gone / one.speed
    dt = 4.0 * EPS * t + freed / one.speed
    bounced = memory[rows.SETTLED] > 0.0
    keep_rest(work.nodes, c, at.u, u, one.speed, max(at.dt, dt), bounced)
    memory[rows.SETTLED] = memory[rows.UNSURE] = 0.0
    ended = Motion(c, u, t, 0.0, 0.0, dt, 0.0, 0.0)
    if at_end:
        return rows.GOES_ON, ENDED_CLOSED, ended
    note(records, rows.RELEASE, stop, t, gone, dt)
    memory[rows.REST_CHART], memory[rows.REST_END] = float(c), u
    memory[rows.BOUNCES], memory[rows.LAST] = 0.0, -1.0
    return rows.GOES_ON, FLYING, ended


@part
def _hold(charts: Charts, memory: FloatArray, records: Records, at: Motion, u: float, at_end: bool,
          freed: float) -> None:  # fmt: skip
    """Write a stretch on which the clamping stop was closed, up to a travel in the chart."""
    c, counts = at.chart, records.counts
    hold = records.holds[counts[rows.STRETCHES]]
    same = charts.stops[charts.stops[c, rows.AFTER], rows.OWN] == charts.stops[c, rows.OWN]
    hold[rows.HOLD_TURN], hold[rows.HOLD_CHART] = counts[rows.TURNS], c
    hold[rows.HOLD_BEGIN], hold[rows.HOLD_END] = at.u, u
    hold[rows.HOLD_BEGIN_ERROR] = memory[rows.UNSURE]
    if at_end:
        hold[rows.ENDED_BY] = rows.REST if same else rows.COLLISION
        hold[rows.HOLD_END_ERROR] = 0.0 if same else charts.numbers[c, rows.CORNER_ERROR]
    else:
        hold[rows.ENDED_BY], hold[rows.HOLD_END_ERROR] = rows.RELEASE, freed
    counts[rows.STRETCHES] += 1


@inlined
def _bounce(charts: Charts, work: Work, one: Case, settings: Settings, to_rest: bool,
            records: Records, at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Count a bounce, and come to rest where what is left of its series is known."""
    c, memory, case, sizes = at.chart, work.memory, work.case[at.chart], work.sizes[at.chart]
    degree, most, stop = charts.equation.shape[4], work.series.shape[1], charts.stops[c, rows.OWN]
    source, per_rad = source_of(charts, work, c, one), case[rows.PER_RAD]
    reach(source, per_rad, at.u, at.u)
    contract(source.mixed, work.poly, rows.ZERO, per_rad, at.u)
    still = acceleration(case, work.poly, rows.ZERO, degree, 0.0, 0.0)
    found, ahead, uncertain = at.v <= 0.0 and still < 0.0, 0.0, 0.0
    if at.v > 0.0:
        bounces = int(memory[rows.BOUNCES])
        if bounces >= most:
            return rows.TOO_MANY, STRUCK, at
        if bounces == 0:
            memory[rows.ORIGIN], memory[rows.FASTEST] = at.t, 0.0
        fastest = max(memory[rows.FASTEST], at.v)
        work.series[0, bounces], work.series[1, bounces] = at.t - memory[rows.ORIGIN], at.v
        memory[rows.BOUNCES], memory[rows.FASTEST] = bounces + 1.0, fastest
        late = at.v**3 <= settings.tolerance * fastest**3
        found, ahead, uncertain = settles(
            case, work.poly, degree, sizes, work.series, bounces + 1, late, at.v, one.speed,
            one.restitution[stop], settings.rest_rate, settings.tolerance, still,
        )  # fmt: skip
        if settings.rough and settings.rest_rate == 0.0 and not found:
            found, ahead = surely_over(charts, work, c, at.u, at.v, one.restitution[stop], still)
            uncertain = 0.0
    elif to_rest and not found:
        return rows.NOT_PRESSED, STRUCK, at
    u, travel = at.u + one.speed * ahead, case[rows.TRAVEL_MOST]
    if not found or not (to_rest or u < travel):
        return rows.GOES_ON, FLYING, at
    dt = at.dt + LIMIT_ERROR_SAFETY * uncertain
    # What is ahead is proportional to the rate that it starts with.
    dt += abs(ahead) * (at.dv / at.v) if at.v > 0.0 else 0.0
    if not to_rest and u + one.speed * dt >= travel:
        return rows.UNTOLD, STRUCK, at
    t, gone = at.t + ahead, TURN * records.counts[rows.TURNS] + charts.numbers[c, rows.BEGIN] + u
    note(records, rows.REST, stop, t, gone, dt)
    if to_rest:
        # The rebound of the last collision is flown all the same.
        return rows.GOES_ON if at.v > 0.0 else rows.AT_REST, FLYING, at
    memory[rows.SETTLED], memory[rows.UNSURE] = 1.0, one.speed * dt + 4.0 * EPS * TURN
    return rows.GOES_ON, RESTING, Motion(c, u, t, 0.0, 0.0, dt, 0.0, 0.0)


@inlined
def _fly(grids: FloatArray, charts: Charts, work: Work, one: Case, settings: Settings,
         bounced: bool, records: Records, at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Fly to the next collision, with the own stop or another one, or to the end of the chart."""
    c, speed, memory, before = at.chart, one.speed, work.memory, kept(work.nodes)
    case, sizes, nodes, source = (
        work.case[c],
        work.sizes[c],
        work.nodes,
        source_of(charts, work, c, one),
    )
    if not bounced:
        reach(source, case[rows.PER_RAD], at.u, at.u)
        contract(source.mixed, work.poly, rows.ZERO, case[rows.PER_RAD], at.u)
    end, T, rate, top, peak, a, fastest, changed, left, gap, hit = flight(
        grids, case, source, work.poly, nodes, charts.equation.shape[4], at.u, at.x, at.v,
        settings.tolerance, at.u == 0.0 and at.x == 0.0,
    )  # fmt: skip
    status, u, t = int(end), at.u + speed * T, at.t + T
    if status == rows.OTHER_STOP and hit >= charts.stops.shape[1] - rows.OTHERS:
        return rows.OFF_ROWS, FLYING, at
    motion = speed, T, fastest, changed, left, at.dt
    if status == rows.AT_REST:
        late, dv, wrong = flight_errors(
            sizes, speed, T, rate, a, peak, fastest, changed, left, at.dt, at.dv
        )
        if not np.isnan(nodes[rows.GROWTH, 0]):
            wrong, dv = errors_after(
                nodes, sizes, speed, T, fastest, changed, left, at.dt, at.dx, at.dv, a / rate
            )
            late = wrong / abs(rate) + 4.0 * EPS * T
        dx_most, dv_most = max(at.dx, wrong, abs(rate) * late), max(at.dv, dv + abs(a) * late)
        describe(nodes, before, c, sizes, motion, (max(at.dt, late), dx_most, dv_most))
        rebounded(records.events, memory, T, top, late, wrong)
        return rows.GOES_ON, STRIKING, Motion(c, u, t, 0.0, rate, at.dt + late, 0.0, dv)
    if status != rows.OTHER_STOP and status != rows.LEFT_TRAVEL:
        return status, FLYING, at
    dx, dv = errors_after(nodes, sizes, speed, T, fastest, changed, left, at.dt, at.dx, at.dv, 0.0)
    describe(nodes, before, c, sizes, motion, (at.dt, max(at.dx, dx), max(at.dv, dv)))
    if status == rows.OTHER_STOP:
        ended = Motion(c, u, t, gap, rate, at.dt, dx, dv)
        return _meet(charts, work, one, int(hit), fastest, a, ended)
    memory[rows.RISEN] = max(memory[rows.RISEN], top)
    memory[rows.RISEN_ERROR] = max(memory[rows.RISEN_ERROR], dx, at.dx)
    memory[rows.FLOWN] += T
    memory[rows.FLOWN_ERROR] += at.dt
    ended = Motion(c, u, t, gap, rate, 0.0, dx + fastest * at.dt, dv + abs(a) * at.dt)
    return rows.GOES_ON, ENDED_OPEN, ended


@part
def _meet(charts: Charts, work: Work, one: Case, s: int, fastest: float, a: float,
          at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Go over to the chart of another stop that closes in a flight."""
    c, gaps, case, begin = at.chart, charts.gaps[at.chart], work.case[at.chart], charts.numbers
    _, closing, d_gap, d_rate = seen_by(
        charts, work, c, s, one.speed, at.u, at.x, at.v, at.dx, at.dv
    )
    to = chart_at(charts, charts.stops[c, rows.OTHERS + s], begin[c, rows.BEGIN] + at.u)
    if to < 0 or closing >= 0.0:
        return rows.OTHER_STOP, FLYING, at
    by_x = surface(gaps, len(gaps) // 3 + s, case, at.u, at.x)
    late = d_gap / -closing
    dv = d_rate + 2.0 * (abs(by_x * a) + one.speed * fastest) * late
    u = at.u + (begin[c, rows.BEGIN] - begin[to, rows.BEGIN])
    work.memory[rows.BOUNCES] = 0.0
    return rows.GOES_ON, STRIKING, Motion(to, u, at.t, 0.0, closing, at.dt + late, 0.0, dv)


@part
def _take_over(charts: Charts, work: Work, one: Case, closed: bool, turns: int, records: Records,
               at: Motion) -> tuple[int, int, Motion]:  # fmt: skip
    """Go on in the chart that follows, where another stop may throw the closed one open."""
    c, memory, counts, number = at.chart, work.memory, records.counts, charts.numbers[at.chart]
    to = charts.stops[c, rows.AFTER]
    same = charts.stops[to, rows.OWN] == charts.stops[c, rows.OWN]
    x, v, dx, dv = at.x, at.v, at.dx, at.dv
    if not closed and not same:
        s = other_of(charts, c, charts.stops[to, rows.OWN])
        x, v, dx, dv = seen_by(charts, work, c, s, one.speed, at.u, x, v, dx, dv)
        memory[rows.BOUNCES], memory[rows.LAST] = 0.0, -1.0
        if x <= 0.0:
            return rows.UNRESOLVED, FLYING, at
    if closed and not same:
        memory[rows.REST_CHART], memory[rows.REST_END] = float(c), at.u
    begin = charts.numbers[to, rows.BEGIN]
    counts[rows.TURNS] += 1 if begin == 0.0 else 0
    t = (TURN * counts[rows.TURNS] + begin) / one.speed
    over = Motion(to, 0.0, t, x, v, at.dt, dx, dv)
    if begin == 0.0:
        if closed and same:
            memory[rows.REST_CHART], memory[rows.REST_END] = float(to), np.inf
        rest = memory[rows.REST_CHART], memory[rows.REST_END]
        mark(records.ends, counts[rows.TURNS], rest, over)
        memory[rows.REST_CHART] = -1.0
        done = counts[rows.TURNS]
        if done == turns or repeats(charts, records.ends, done) > 0:
            return rows.AT_REST, FLYING, over
    if closed and not same:
        if number[rows.THROW] <= 0.0:
            return rows.JAM, FLYING, over
        memory[rows.BOUNCES] = 0.0
        dt = 4.0 * EPS * t + number[rows.CORNER_ERROR] / one.speed
        v, dv = number[rows.ARRIVE] * one.speed, number[rows.ARRIVE_ERROR] * one.speed
        return rows.GOES_ON, STRIKING, Motion(to, 0.0, t, 0.0, v, dt, 0.0, dv)
    return rows.GOES_ON, RESTING if closed else FLYING, over
