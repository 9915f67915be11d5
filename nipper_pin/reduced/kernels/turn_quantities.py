"""Quantities of a turn, compiled: how a stop is held shut, and sums over its collisions."""

from __future__ import annotations

from math import inf, pi

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .arrival_check import along
from .compiled import compiled
from .flight_errors import size
from .layout import AT_REST, RESIDUAL
from .panel import chebyshev
from .turn import follow
from .turn_layout import (
    AMPLITUDE,
    AMPLITUDE_ERROR,
    CLAMPED,
    CLOSED_AT,
    COLLISION,
    COUNT,
    ENDED_BY,
    ENERGY,
    FORCE_ERROR,
    GAP_ERROR,
    HOLD_BEGIN,
    HOLD_CHART,
    HOLD_END,
    HOLD_TURN,
    IMPULSE,
    IMPULSE_ERROR,
    IMPULSE_MOST,
    IMPULSE_SUM,
    KIND,
    LARGEST_GAP,
    LEAST_FORCE,
    LOST_AT,
    LOST_ENERGY,
    MOST_FORCE,
    OPENED_AT,
    PER_STOP,
    RELEASE,
    REST,
    RESTS_AT,
    STOP,
    SUM_ERROR,
    TRAVEL,
    TURN_NUMBERS,
    Charts,
    TurnWork,
)

_TURN = 2.0 * pi
_PLACES = 24
_SEARCH_STEPS = 60


@compiled
def force_at(charts: Charts, work: TurnWork, c: int, u: float) -> float:
    """Normal force of a closed stop at its contact point [N]; along the joint without one."""
    cells, count = charts.inertia.shape[1], charts.inertia.shape[2]
    width = charts.span[c] / cells
    cell = min(max(int(u / width), 0), cells - 1)
    C = chebyshev(charts.inertia[c], cell, 0, count, 2.0 * (u - cell * width) / width - 1.0)
    a = along(work.line[c], cell, count, width, u)
    return float(-C * a / charts.lever[charts.stop[c]])


@compiled
def _peak(charts: Charts, work: TurnWork, c: int, low: float, high: float, sign: float) -> float:
    """Largest value of sign times the force between two places that hold one."""
    for _ in range(_SEARCH_STEPS):
        third = (high - low) / 3.0
        left, right = low + third, high - third
        if sign * force_at(charts, work, c, left) < sign * force_at(charts, work, c, right):
            low = left
        else:
            high = right
    return force_at(charts, work, c, 0.5 * (low + high))


@compiled
def _passes(charts: Charts, work: TurnWork, c: int, low: float, high: float,
            level: float) -> float:  # fmt: skip
    """Place where the force passes a level between two places on either side of it."""
    rising = force_at(charts, work, c, high) >= level
    for _ in range(_SEARCH_STEPS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (force_at(charts, work, c, middle) >= level) == rising:
            high = middle
        else:
            low = middle
    return high


@compiled
def held(charts: Charts, work: TurnWork, c: int, begin: float, end: float,
         level: float) -> tuple[float, float, float]:  # fmt: skip
    """Least and largest force of a closed stop on a stretch, and the travel with a force above.

    Args:
        charts: The charts.
        work: Combined for the case.
        c: The chart.
        begin: Travel in the chart [rad].
        end: Likewise.
        level: Force [N].
    """
    cells = charts.inertia.shape[1]
    count = max(4, int((end - begin) / charts.span[c] * cells * _PLACES) + 1)
    step = (end - begin) / count
    least = most = older = old = force_at(charts, work, c, begin)
    above = 0.0
    for j in range(1, count + 1):
        u = end if j == count else begin + step * j
        force = force_at(charts, work, c, u)
        if (old >= level) != (force >= level):
            place = _passes(charts, work, c, u - step, u, level)
            above += place - (u - step) if old >= level else u - place
        elif force >= level:
            above += step
        least, most = min(least, force), max(most, force)
        if j > 1 and old > older and old >= force:
            most = max(most, _peak(charts, work, c, u - 2.0 * step, u, 1.0))
        if j > 1 and old < older and old <= force:
            least = min(least, _peak(charts, work, c, u - 2.0 * step, u, -1.0))
        older, old = old, force
    return least, most, above


@compiled
def summed(charts: Charts, work: TurnWork, events: FloatArray, count: int, holds: FloatArray,
           hold_count: int, turn: int, clamp: int, level: float,
           found: FloatArray) -> None:  # fmt: skip
    """Quantities of one turn.

    Args:
        charts: The charts.
        work: Combined for the case.
        events: The events, shape (events, columns).
        count: Number of events.
        holds: Stretches on which the clamping stop was closed, shape (holds, columns).
        hold_count: Number of those.
        turn: Number of the turn, from 0.
        clamp: Place of the clamping stop among the stops.
        level: Force above which it clamps [N].
        found: Written, shape (TURN_NUMBERS + PER_STOP stops,).
    """
    found[:] = np.nan
    found[CLAMPED] = found[LOST_ENERGY] = 0.0
    found[TURN_NUMBERS:] = 0.0
    for i in range(count):
        row = events[i]
        if not _TURN * turn <= row[TRAVEL] < _TURN * (turn + 1):
            continue
        at = row[TRAVEL] - _TURN * turn
        if row[KIND] == COLLISION:
            _add_collision(found, row, at, int(row[STOP]) == clamp)
        elif int(row[STOP]) == clamp and row[KIND] == REST and np.isnan(found[RESTS_AT]):
            found[RESTS_AT] = at
    for i in range(hold_count):
        if int(holds[i, HOLD_TURN]) == turn:
            _add_hold(charts, work, found, holds[i], level)


@compiled
def _add_collision(found: FloatArray, row: FloatArray, at: float, clamps: bool) -> None:
    """Count a collision, its impulse and its loss; the closing and the gaps of the clamping one."""
    place = TURN_NUMBERS + PER_STOP * int(row[STOP])
    found[place + COUNT] += 1.0
    found[place + IMPULSE_SUM] += row[IMPULSE]
    found[place + SUM_ERROR] += row[IMPULSE_ERROR]
    found[place + IMPULSE_MOST] = max(found[place + IMPULSE_MOST], row[IMPULSE])
    found[LOST_ENERGY] += row[ENERGY]
    if not clamps:
        return
    if np.isnan(found[CLOSED_AT]):
        found[CLOSED_AT] = at
    if row[AMPLITUDE] > found[LARGEST_GAP] or np.isnan(found[LARGEST_GAP]):
        found[LARGEST_GAP], found[GAP_ERROR] = row[AMPLITUDE], row[AMPLITUDE_ERROR]


@compiled
def _add_hold(charts: Charts, work: TurnWork, found: FloatArray, hold: FloatArray,
              level: float) -> None:  # fmt: skip
    """Add a stretch on which the clamping stop was closed."""
    c, begin, end = int(hold[HOLD_CHART]), hold[HOLD_BEGIN], hold[HOLD_END]
    least, most, above = held(charts, work, c, begin, end, level)
    found[CLAMPED] += above
    found[LEAST_FORCE] = least if np.isnan(found[LEAST_FORCE]) else min(found[LEAST_FORCE], least)
    found[MOST_FORCE] = most if np.isnan(found[MOST_FORCE]) else max(found[MOST_FORCE], most)
    lever, C = charts.lever[charts.stop[c]], np.abs(charts.inertia[c, :, 0]).max()
    wrong = size(work.sizes[c], RESIDUAL, 0.0) * 2.0 * C / lever
    wrong += charts.inertia_residual[c] * max(abs(least), abs(most))
    before = -inf if np.isnan(found[FORCE_ERROR]) else found[FORCE_ERROR]
    found[FORCE_ERROR] = max(before, wrong)
    ended = int(hold[ENDED_BY])
    if ended == RELEASE and np.isnan(found[LOST_AT]):
        found[LOST_AT] = charts.begin[c] + end
    if ended == COLLISION and np.isnan(found[OPENED_AT]):
        found[OPENED_AT] = charts.begin[c] + end


@compiled
def run_turns(grids: FloatArray, charts: Charts, work: TurnWork, speed: FloatArray,
              restitution: FloatArray, stiffness: FloatArray, preload: FloatArray,
              gravity: FloatArray, rest_rate: float, tolerance: float, turns: int,
              begin: tuple[int, float, float, float, bool], clamp: int, level: float,
              events: FloatArray, holds: FloatArray, ends: FloatArray, told: NDArray[np.int64],
              found: FloatArray) -> None:  # fmt: skip
    """Quantities of the last turns of many cases.

    Args:
        grids: Collocation grids.
        charts: The functions of the machine.
        work: Scratch arrays.
        speed: Cylinder speeds, shape (n,) [rad/s].
        restitution: e_N of the stops, shape (n, K).
        stiffness: Spring rates, shape (n, springs).
        preload: Deflections in the springs at zero, likewise.
        gravity: By the gravity of the model, shape (n,).
        rest_rate: Threshold of rest, or 0 for the limit of series.
        tolerance: Relative accuracy.
        turns: Largest number of turns; fewer are followed where they repeat.
        begin: Chart, gap, its rate by time and by the cylinder, and whether its stop is closed.
        clamp: Place of the clamping stop.
        level: Force above which it clamps [N].
        events: Scratch, shape (most, EVENT_COLUMNS).
        holds: Scratch, shape (most, HOLD_COLUMNS).
        ends: Scratch, shape (turns + 1, END_COLUMNS).
        told: Written: status, turns, and after how many the last repeats, shape (n, 3).
        found: Written, shape (n, last, quantities): the last turn first; NaN before the first one.
    """
    for i in range(len(speed)):
        start = begin[0], begin[1], begin[2] + begin[3] * speed[i], begin[4], 0.0, 0.0
        status, count, hold, done, again = follow(
            grids, charts, work, speed[i], restitution[i], stiffness[i], preload[i], gravity[i],
            rest_rate, tolerance, turns, start, clamp, events, holds, ends,
        )  # fmt: skip
        told[i, 0], told[i, 1], told[i, 2] = status, done, again
        found[i] = np.nan
        if status == AT_REST:
            for j in range(min(found.shape[1], done)):
                summed(
                    charts, work, events, count, holds, hold, done - 1 - j, clamp, level,
                    found[i, j],
                )  # fmt: skip
