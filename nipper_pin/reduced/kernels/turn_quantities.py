"""Quantities of a turn, compiled: how a stop is held shut, and sums over its collisions."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from . import layout as rows
from .closed import PLACES, Stretch, extreme, force_at, passage
from .compiled import part
from .flight_errors import drift, size
from .layout import Job, Motion, Settings, Solver
from .panel import along
from .turn import FLYING, RESTING, STRUCK, follow
from .turn_charts import chart_at


@part
def wrong_by(solver: Solver, c: int) -> tuple[float, float]:
    """Bound on the error of the force of a closed stop: absolute [N], and by the force."""
    charts, sizes, C = solver.charts, solver.work.sizes[c], 0.0
    for cell in range(charts.inertia.shape[1]):
        C = max(C, 2.0 * abs(charts.inertia[c, cell, 0]))
    wrong = size(sizes, rows.RESIDUAL, 0.0) * C / charts.lever[charts.stops[c, rows.OWN]]
    return wrong, charts.numbers[c, rows.INERTIA_ERROR] + 16.0 * EPS


@part
def _unsure(at: Stretch, u: float) -> float:
    """Travel to either side of a place beyond which the force is surely off the level."""
    slope = abs(force_at(at, u)[1])
    beside, most = 8.0 * EPS * at.solver.charts.numbers[at.c, rows.TRAVEL_MOST], at.end - at.begin
    if slope > 0.0:
        beside += min(2.0 * at.wrong / slope, most)
    while beside < most:
        low, high = max(u - beside, at.begin), min(u + beside, at.end)
        before = abs(force_at(at, low)[0] - at.level)
        after = abs(force_at(at, high)[0] - at.level)
        if (low == at.begin or before >= at.wrong) and (high == at.end or after >= at.wrong):
            break
        beside *= 2.0
    return float(beside)


@part
def _part(at: Stretch, left: float, old: float, right: float,
          force: float) -> tuple[float, float]:  # fmt: skip
    """Travel with a force above the level, of a part where it rises or falls, and its error."""
    if (old >= at.level) == (force >= at.level):
        return (right - left if force >= at.level else 0.0), 0.0
    place = passage(at, left, right, force >= at.level)
    return (place - left if old >= at.level else right - place), _unsure(at, place)


@part
def held(solver: Solver, hold: FloatArray,
         level: float) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Forces of a closed stop on a stretch.

    Returns:
        Least force, largest force and travel with a force above the level, each before the bound on
        its error.
    """
    c, begin, end = int(hold[rows.HOLD_CHART]), hold[rows.HOLD_BEGIN], hold[rows.HOLD_END]
    absolute, relative = wrong_by(solver, c)
    near = absolute + relative * abs(level)
    at = Stretch(solver, c, solver.work.line[c], begin, end, level, near)
    step = 1.0 / (solver.charts.numbers[c, rows.PER_RAD] * PLACES)
    u = begin
    old, old_slope = force_at(at, u)
    least = most = old
    # The stretch may begin and end a little earlier or later.
    ends = 2.0 * abs(old_slope) * hold[rows.HOLD_BEGIN_ERROR]
    low, high = old - ends, old + ends
    above = beside = 0.0
    if old >= level - near - ends:
        beside += hold[rows.HOLD_BEGIN_ERROR]
    while True:
        new = min(step * (np.floor(u / step * (1.0 + 8.0 * EPS)) + 1.0), end)
        force, slope = force_at(at, new)
        if (old_slope > 0.0) != (slope > 0.0):
            middle = extreme(at, u, new, old_slope > 0.0)
            top, _ = force_at(at, middle)
            share, wide = _part(at, u, old, middle, top)
            above, beside = above + share, beside + wide
            if abs(top - level) <= near:
                beside += 2.0 * _unsure(at, middle)
            least, most = min(least, top), max(most, top)
            u, old = middle, top
        share, wide = _part(at, u, old, new, force)
        above, beside = above + share, beside + wide
        least, most = min(least, force), max(most, force)
        u, old, old_slope = new, force, slope
        if new >= end:
            break
    ends = 2.0 * abs(old_slope) * hold[rows.HOLD_END_ERROR]
    low, high = min(low, old - ends), max(high, old + ends)
    if old >= level - near - ends:
        beside += hold[rows.HOLD_END_ERROR]
    least_wrong = absolute + relative * abs(least) + max(least - low, 0.0)
    most_wrong = absolute + relative * abs(most) + max(high - most, 0.0)
    beside += 8.0 * EPS * (end - begin)
    return least, least_wrong, most, most_wrong, above, beside


_TURN = 2.0 * pi


@part
def summed(solver: Solver, turn: int, job: Job, limits: bool, found: FloatArray) -> None:
    """Quantities of one turn.

    Args:
        turn: Its number, from 0.
        limits: Whether series of bounces end at their limit.
        found: Written, shape (TURN_NUMBERS + PER_STOP stops,).
    """
    events, holds, counts = solver.records.events, solver.records.holds, solver.records.counts
    found[:] = np.nan
    found[rows.CLAMPED] = found[rows.LOST_ENERGY] = found[rows.CLAMPED_ERROR] = found[
        rows.LOSS_ERROR
    ] = 0.0
    found[rows.TURN_NUMBERS :] = 0.0
    before = -1
    for i in range(counts[rows.EVENTS]):
        row = events[i]
        clamps, last = int(row[rows.STOP]) == job.clamp, before
        if clamps and row[rows.KIND] == rows.COLLISION:
            before = i
        if not _TURN * turn <= row[rows.TRAVEL] < _TURN * (turn + 1):
            continue
        at = row[rows.TRAVEL] - _TURN * turn
        wrong = solver.one.speed * row[rows.TIME_ERROR] + 4.0 * EPS * row[rows.TRAVEL]
        if row[rows.KIND] == rows.COLLISION:
            _add_collision(found, row)
            # A rebound counts in the turn in which it ends.
            if clamps and last >= 0 and not np.isnan(events[last, rows.AMPLITUDE]):
                _raise_gap(found, events[last, rows.AMPLITUDE], events[last, rows.AMPLITUDE_ERROR])
            if clamps and np.isnan(found[rows.CLOSED_AT]):
                found[rows.CLOSED_AT], found[rows.CLOSED_ERROR] = at, wrong
        elif row[rows.KIND] == rows.REST:
            if limits and i > 0 and events[i - 1, rows.KIND] == rows.COLLISION:
                _add_rest_of_series(solver, found, events[i - 1], row, clamps)
            if clamps and np.isnan(found[rows.RESTS_AT]):
                found[rows.RESTS_AT], found[rows.RESTS_ERROR] = at, wrong
    for i in range(counts[rows.STRETCHES]):
        if int(holds[i, rows.HOLD_TURN]) == turn:
            _add_hold(solver, found, holds[i], job.level)
    # Bounds on the least and the largest values become bounds on their errors.
    found[rows.LEAST_ERROR] = found[rows.LEAST_FORCE] - found[rows.LEAST_ERROR]
    found[rows.LARGEST_ERROR] -= found[rows.MOST_FORCE]
    found[rows.FORCE_ERROR] = max(found[rows.LEAST_ERROR], found[rows.LARGEST_ERROR])
    found[rows.GAP_ERROR] -= found[rows.LARGEST_GAP]
    for place in range(rows.TURN_NUMBERS, len(found), rows.PER_STOP):
        most = found[place + rows.IMPULSE_MOST]
        found[place + rows.MOST_ERROR] += 4.0 * EPS * most - most


@part
def _add_collision(found: FloatArray, row: FloatArray) -> None:
    """Count a collision, its impulse and its loss."""
    place = rows.TURN_NUMBERS + rows.PER_STOP * int(row[rows.STOP])
    impulse, wrong = row[rows.IMPULSE], row[rows.IMPULSE_ERROR]
    found[place + rows.COUNT] += 1.0
    found[place + rows.IMPULSE_SUM] += impulse
    found[place + rows.SUM_ERROR] += wrong + 4.0 * EPS * impulse
    found[place + rows.IMPULSE_MOST] = max(found[place + rows.IMPULSE_MOST], impulse)
    found[place + rows.MOST_ERROR] = max(found[place + rows.MOST_ERROR], impulse + wrong)
    found[rows.LOST_ENERGY] += row[rows.ENERGY]
    found[rows.LOSS_ERROR] += row[rows.ENERGY_ERROR] + 4.0 * EPS * row[rows.ENERGY]


@part
def _raise_gap(found: FloatArray, gap: float, wrong: float) -> None:
    """The largest gap so far, and the largest that it can be in truth."""
    if np.isnan(found[rows.LARGEST_GAP]):
        found[rows.LARGEST_GAP] = found[rows.GAP_ERROR] = 0.0
    found[rows.LARGEST_GAP] = max(found[rows.LARGEST_GAP], gap)
    found[rows.GAP_ERROR] = max(found[rows.GAP_ERROR], gap + wrong)


@part
def _add_rest_of_series(solver: Solver, found: FloatArray, row: FloatArray, rest: FloatArray,
                        clamps: bool) -> None:  # fmt: skip
    """Add impulses, losses and the gap of the bounces beyond the last one that was computed.

    Each is slower than the one before by the restitution, as far as x'' stays as it is.
    """
    charts, work, speed = solver.charts, solver.work, solver.one.speed
    stop, w = int(row[rows.STOP]), row[rows.SEPARATION]
    ahead = rest[rows.TIME] - row[rows.TIME]
    travel = row[rows.TRAVEL] % _TURN
    c = chart_at(charts, stop, travel)
    if w <= 0.0 or c < 0:
        return
    place, e_N = rows.TURN_NUMBERS + rows.PER_STOP * stop, w / -row[rows.APPROACH]
    a = along(work.line[c], charts.numbers[c, rows.PER_RAD], travel - charts.numbers[c, rows.BEGIN])
    uneven = 1.0
    if a < 0.0:
        uneven = drift(work.sizes[c], speed, w, a, ahead)
        uneven += speed * ahead / charts.numbers[c, rows.TRAVEL_MOST]
    further = row[rows.IMPULSE] * e_N / (1.0 - e_N)
    lost = row[rows.ENERGY] * e_N * e_N / (1.0 - e_N * e_N)
    by_rate = row[rows.IMPULSE_ERROR] / row[rows.IMPULSE]
    found[place + rows.IMPULSE_SUM] += further
    found[place + rows.SUM_ERROR] += further * (uneven + by_rate)
    found[rows.LOST_ENERGY] += lost
    found[rows.LOSS_ERROR] += 2.0 * lost * (uneven + by_rate)
    if clamps and a < 0.0:
        _raise_gap(found, 0.5 * w * w / -a, w * w / -a * (uneven + by_rate))


@part
def _add_hold(solver: Solver, found: FloatArray, hold: FloatArray, level: float) -> None:
    """Add a stretch on which the clamping stop was closed."""
    least, low, most, high, above, beside = held(solver, hold, level)
    if np.isnan(found[rows.LEAST_FORCE]):
        found[rows.LEAST_FORCE] = found[rows.LEAST_ERROR] = least
        found[rows.MOST_FORCE] = found[rows.LARGEST_ERROR] = most
    found[rows.LEAST_FORCE] = min(found[rows.LEAST_FORCE], least)
    found[rows.MOST_FORCE] = max(found[rows.MOST_FORCE], most)
    found[rows.LEAST_ERROR] = min(found[rows.LEAST_ERROR], least - low)
    found[rows.LARGEST_ERROR] = max(found[rows.LARGEST_ERROR], most + high)
    found[rows.CLAMPED] += above
    found[rows.CLAMPED_ERROR] += beside
    c, ended = int(hold[rows.HOLD_CHART]), int(hold[rows.ENDED_BY])
    end = solver.charts.numbers[c, rows.BEGIN] + hold[rows.HOLD_END]
    wrong = hold[rows.HOLD_END_ERROR] + 4.0 * EPS * _TURN
    if ended == rows.RELEASE and np.isnan(found[rows.LOST_AT]):
        found[rows.LOST_AT], found[rows.LOST_ERROR] = end, wrong
    if ended == rows.COLLISION and np.isnan(found[rows.OPENED_AT]):
        found[rows.OPENED_AT], found[rows.OPENED_ERROR] = end, wrong


@part
def begun(begin: tuple[int, float, float, float, bool], speed: float) -> tuple[int, Motion]:
    """What a machine does at the start of its turns, ``begin`` of a job, and its state."""
    c, x, slow, fast, closed = begin
    phase = RESTING if closed else FLYING
    if x == 0.0 and not closed:
        phase = STRUCK
    return phase, Motion(c, 0.0, 0.0, x, slow + fast * speed, 0.0, 0.0, 0.0)


@part
def turns_of(solver: Solver, settings: Settings, job: Job, told: NDArray[np.int64],
             found: FloatArray) -> None:  # fmt: skip
    """Follow the turns of a case, and write the quantities of the last ones."""
    counts, (phase, at) = solver.records.counts, begun(job.begin, solver.one.speed)
    status, again = follow(solver, settings, job.turns, phase, at, job.clamp)
    done = counts[rows.DONE]
    told[0], told[1], told[2], told[3] = status, done, again, counts[rows.EVENTS]
    found[:] = np.nan
    for j in range(min(len(found), done) if status == rows.AT_REST else 0):
        summed(solver, done - 1 - j, job, settings.rest_rate == 0.0, found[j])
