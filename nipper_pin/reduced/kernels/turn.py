"""Whole turns of the reduced model, compiled: phases, flights, collisions, rests and releases."""

from __future__ import annotations

from math import pi

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import LIMIT_ERROR_SAFETY
from . import layout as rows
from . import turn_layout as columns
from .arrival_check import released
from .compiled import part
from .flight import describe, flight, full, keep_rest, kept
from .flight_errors import flight_errors
from .layout import Cases, Settings
from .panel import acceleration, contract
from .repeats import mark, repeats
from .series import settles
from .turn_charts import chart_at, off_rows, off_rows_at, other_of, seen_by, surface, visit
from .turn_events import collide, errors_after, note, release_error
from .turn_layout import Begin, Charts, Records, TurnWork

_TURN = 2.0 * pi


@part
def follow(grids: FloatArray, charts: Charts, work: TurnWork, cases: Cases, case_number: int,
           settings: Settings, turns: int, begin: Begin, clamp: int, records: Records,
           ) -> tuple[int, int, int, int, int]:  # fmt: skip
    """Follow whole turns of one case from event to event.

    Args:
        charts: The functions of the machine.
        turns: Number of turns.
        begin: Chart, gap, its rate, whether its stop is closed, and errors of gap and rate.
        clamp: Place of the clamping stop among the stops.
        records: Written.

    Returns:
        Status, numbers of events, stretches and turns, and the number of turns after which the last
        one repeats an earlier one; 0 if it does not.
    """
    speed, restitution = cases.speed[case_number], cases.restitution[case_number]
    stiffness, preload = cases.stiffness[case_number], cases.preload[case_number]
    gravity, (rest_rate, tolerance) = cases.gravity[case_number], settings
    events, holds, ends = records
    work.ready[:] = False
    row = work.poly.shape[0] - 1
    degree = charts.equation.shape[4]
    smallest = tolerance ** (1.0 / 3.0)
    most = work.series.shape[1]
    c, x, v, resting, dx, dw = begin
    u = t = dt = origin = fastest_rebound = unsure = 0.0
    risen = unsure_top = 0.0
    n = turn = bounces = hold = rows.ZERO
    last = -1
    touching = free = settled = rows.NO
    rest_chart, rest_end = -1.0, 0.0
    mark(ends, rows.ZERO, (float(c) if resting else -1.0, np.inf), (c, x, v, dx, dw))
    while True:
        visit(charts, work, c, speed, gravity, stiffness, preload)
        case, sizes = work.case[c], work.sizes[c]
        travel, span, stop = charts.travel[c], charts.span[c], charts.stop[c]
        at_end = False
        # A release and the collision after it are written in one pass.
        if n + 2 > len(events) or hold == len(holds) or full(work.nodes):
            return rows.TOO_MANY, n, hold, turn, 0
        if resting:
            place = released(work.line[c], span, u, travel)
            if place < 0.0:
                return rows.UNTOLD, n, hold, turn, 0
            at_end = place > travel
            if off_rows(charts, c, u, min(place, travel), (0.0, 0.0), 0.0, 0.0):
                return rows.OFF_ROWS, n, hold, turn, 0
            if stop == clamp:
                holds[hold, columns.HOLD_TURN], holds[hold, columns.HOLD_CHART] = turn, c
                holds[hold, columns.HOLD_BEGIN] = u
                holds[hold, columns.HOLD_END] = min(place, travel)
                same = charts.stop[charts.after[c]] == stop
                ended = columns.REST if same else columns.COLLISION
                holds[hold, columns.ENDED_BY] = ended if at_end else columns.RELEASE
                holds[hold, columns.HOLD_BEGIN_ERROR] = unsure
                holds[hold, columns.HOLD_END_ERROR] = 0.0 if same else charts.corner_error[c]
                if not at_end:
                    freed = release_error(work.line[c], sizes, span, place)
                    holds[hold, columns.HOLD_END_ERROR] = freed
                hold += 1
            late, since, unsure = dt, u, 0.0
            u = travel if at_end else place
            t = (_TURN * turn + charts.begin[c] + u) / speed
            x = v = dx = dw = 0.0
            dt = 4.0 * EPS * t
            if not at_end:
                dt += release_error(work.line[c], sizes, span, u) / speed
            if work.nodes.shape[0] > rows.SCRATCH_ROWS:
                keep_rest(work.nodes, c, since, u, speed, max(late, dt), settled)
            settled = False
            if not at_end:
                note(events, n, columns.RELEASE, stop, t, _TURN * turn + charts.begin[c] + u, dt)
                n += 1
                rest_chart, rest_end = float(c), u
                resting, free, touching, bounces, last = False, True, False, rows.ZERO, -1
        elif x == 0.0 and not free:
            contract(work.mixed[c], work.poly, row, span, u)
            still = acceleration(case, work.poly, degree, 0.0, 0.0)
            found, ahead, uncertain = v <= 0.0 and still < 0.0, 0.0, 0.0
            if v > 0.0:
                if bounces == 0:
                    origin, fastest_rebound = t, 0.0
                if bounces >= most:
                    return rows.TOO_MANY, n, hold, turn, 0
                fastest_rebound = max(fastest_rebound, v)
                work.series[0, bounces], work.series[1, bounces] = t - origin, v
                bounces += 1
                found, ahead, uncertain = settles(
                    case, work.poly, degree, sizes, work.series, bounces,
                    v <= smallest * fastest_rebound, v, speed, restitution[stop], rest_rate,
                    tolerance, still,
                )  # fmt: skip
            if found and u + speed * ahead < travel:
                late = dt + LIMIT_ERROR_SAFETY * uncertain
                late += abs(ahead) * (dw / v) if v > 0.0 else 0.0
                if u + speed * (ahead + late) >= travel:
                    return rows.UNTOLD, n, hold, turn, 0
                t += ahead
                u += speed * ahead
                note(events, n, columns.REST, stop, t, _TURN * turn + charts.begin[c] + u, late)
                n += 1
                resting = settled = True
                dt, unsure = late, speed * late + 4.0 * EPS * _TURN
                continue
        if not resting:
            before = kept(work.nodes)
            end, T, rate, top, peak, a, fastest, changed, left, gap, hit = flight(
                grids, case, work.mixed[c], work.poly, work.nodes, degree, u, x, v, tolerance,
                touching,
            )  # fmt: skip
            status = int(end)
            touching = free = False
            if off_rows(charts, c, u, u + speed * T, (x, gap), top, fastest / speed):
                return rows.OFF_ROWS, n, hold, turn, 0
            if status == rows.AT_REST:
                duration, dv, height = flight_errors(
                    sizes, speed, T, rate, a, peak, fastest, changed, left, dt, dw
                )
                if not np.isnan(work.nodes[rows.GROWTH, 0]):
                    height, dv = errors_after(
                        work.nodes, sizes, speed, T, fastest, changed, left, dt, dx, dw, a / rate
                    )
                    duration = height / abs(rate) + 4.0 * EPS * T
                dx_most = max(dx, height, abs(rate) * duration)
                dv_most = max(dw, dv + abs(a) * duration)
                motion = speed, T, fastest, changed, left, dt
                describe(
                    work.nodes, before, c, sizes, motion, (max(dt, duration), dx_most, dv_most)
                )
                dt += duration
                if last >= 0:
                    risen, unsure_top = max(risen, top), max(unsure_top, height)
                    events[last, columns.AMPLITUDE] = risen
                    events[last, columns.AMPLITUDE_ERROR] = unsure_top + 4.0 * EPS * risen
                risen = unsure_top = 0.0
                t += T
                u += speed * T
                e_N = restitution[stop]
                collide(charts, events, n, c, speed, e_N, turn, t, u, rate, dt, dv)
                last = n
                n += 1
                x, v, dx, dw = 0.0, -e_N * rate, 0.0, e_N * dv
                continue
            if status == rows.OTHER_STOP:
                x_before, v_before = dx, dw
                dx, dv = errors_after(
                    work.nodes, sizes, speed, T, fastest, changed, left, dt, dx, dw, 0.0
                )
                dx_most, dv_most = max(dx, x_before), max(dv, v_before)
                motion = speed, T, fastest, changed, left, dt
                describe(work.nodes, before, c, sizes, motion, (dt, dx_most, dv_most))
                u += speed * T
                t += T
                s = int(hit)
                _, closing, d_gap, d_rate = seen_by(charts, work, c, s, speed, u, gap, rate, dx, dv)
                stop = charts.others[c, s]
                to = chart_at(charts, stop, charts.begin[c] + u)
                if to < 0 or closing >= 0.0:
                    return rows.OTHER_STOP, n, hold, turn, 0
                by_x = surface(charts.slopes[c], s, span, case, u, gap)
                late = d_gap / -closing
                dt += late
                dv = d_rate + 2.0 * (abs(by_x * a) + speed * fastest) * late
                u += charts.begin[c] - charts.begin[to]
                c = to
                visit(charts, work, c, speed, gravity, stiffness, preload)
                e_N = restitution[stop]
                collide(charts, events, n, c, speed, e_N, turn, t, u, closing, dt, dv)
                last = n
                n += 1
                x, v, dx, dw, bounces = 0.0, -e_N * closing, 0.0, e_N * dv, 0
                risen = unsure_top = 0.0
                continue
            if status == rows.LEFT_GAP and off_rows_at(charts, c, charts.high[c]):
                return rows.OFF_ROWS, n, hold, turn, 0
            if status != rows.LEFT_TRAVEL:
                return status, n, hold, turn, 0
            x_before, v_before = dx, dw
            dx, dw = errors_after(
                work.nodes, sizes, speed, T, fastest, changed, left, dt, dx, dw, 0.0
            )
            dx_most, dv_most = max(dx, x_before), max(dw, v_before)
            motion = speed, T, fastest, changed, left, dt
            describe(work.nodes, before, c, sizes, motion, (dt, dx_most, dv_most))
            risen, unsure_top = max(risen, top), max(unsure_top, dx_most)
            dx, dw = dx + fastest * dt, dw + abs(a) * dt
            x, v, u, dt = gap, rate, travel, 0.0
        # The end of the arc.
        to = charts.after[c]
        ahead_of = charts.stop[to]
        throw, approach, wrong = charts.throw[c], charts.arrive[c], charts.arrive_residual[c]
        if not resting and ahead_of != stop:
            s = other_of(charts, c, ahead_of)
            x, v, dx, dw = seen_by(charts, work, c, s, speed, u, x, v, dx, dw)
            bounces, last = 0, -1
            if x <= 0.0:
                return rows.UNRESOLVED, n, hold, turn, 0
        if resting and ahead_of != stop:
            rest_chart, rest_end = float(c), u
        if charts.begin[to] == 0.0:
            turn += 1
            if resting and ahead_of == stop:
                rest_chart, rest_end = float(to), np.inf
            mark(ends, turn, (rest_chart, rest_end), (to, x, v, dx, dw))
            rest_chart = -1.0
            again = repeats(charts, ends, turn)
            if turn == turns or again > 0:
                return rows.AT_REST, n, hold, turn, again
        if resting and ahead_of != stop:
            if throw <= 0.0:
                return rows.JAM, n, hold, turn, 0
            e_N = restitution[ahead_of]
            t = (_TURN * turn + charts.begin[to]) / speed
            v = approach * speed
            visit(charts, work, to, speed, gravity, stiffness, preload)
            dt = 4.0 * EPS * t + charts.corner_error[c] / speed
            collide(charts, events, n, to, speed, e_N, turn, t, 0.0, v, dt, wrong * speed)
            last = n
            n += 1
            x, v, dx, dw = 0.0, -e_N * v, 0.0, e_N * wrong * speed
            resting, touching, bounces = False, True, 0
            risen = unsure_top = 0.0
        if not resting:
            t = (_TURN * turn + charts.begin[to]) / speed
        c, u = to, 0.0
