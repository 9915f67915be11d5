"""The force of a stop that is held shut, along a stretch of a turn, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from .compiled import compiled
from .flight_errors import size
from .layout import RESIDUAL
from .turn_layout import HOLD_BEGIN, HOLD_BEGIN_ERROR, HOLD_CHART, HOLD_END, HOLD_END_ERROR, Charts
from .turn_layout import TurnWork as Work

# Places of a cell between which a force has at most one extreme.
_PLACES = 16
_SEARCH_STEPS = 60


@compiled
def _series(table: FloatArray, cell: int, count: int, place: float) -> tuple[float, float]:
    """Chebyshev series of a cell and its derivative at a place in [-1, 1]."""
    high = low = rise = fall = 0.0
    for i in range(count - 1, 0, -1):
        rise, fall = 2.0 * (high + place * rise) - fall, rise
        high, low = table[cell, i] + 2.0 * place * high - low, high
    return table[cell, 0] + place * high - low, high + place * rise - fall


@compiled
def force_at(charts: Charts, work: Work, c: int, u: float) -> tuple[float, float]:
    """Normal force of a closed stop [N], along the joint without a contact point, and its slope.

    Args:
        work: Combined for the case.
        c: The chart.
        u: Travel in it [rad].
    """
    cells, count = charts.inertia.shape[1], charts.inertia.shape[2]
    width = charts.span[c] / cells
    # The end of a cell belongs to it: beyond the last one functions are constant.
    cell = min(max(int(u / width * (1.0 - 8.0 * EPS)), 0), cells - 1)
    place = 2.0 * (u - cell * width) / width - 1.0
    C, C_u = _series(charts.inertia[c], cell, count, place)
    a, a_u = _series(work.line[c], cell, count, place)
    lever = charts.lever[charts.stop[c]]
    return -C * a / lever, -(C_u * a + C * a_u) * 2.0 / (width * lever)


@compiled
def wrong_by(charts: Charts, work: Work, c: int) -> tuple[float, float]:
    """Bound on the error of the force of a closed stop: absolute [N], and by the force."""
    C = 2.0 * np.abs(charts.inertia[c, :, 0]).max()
    wrong = size(work.sizes[c], RESIDUAL, 0.0) * C / charts.lever[charts.stop[c]]
    return wrong, charts.inertia_residual[c] + 16.0 * EPS


@compiled
def _extreme(charts: Charts, work: Work, c: int, low: float, high: float, rises: bool) -> float:
    """Place between two others where the slope of the force changes its sign."""
    for _ in range(_SEARCH_STEPS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (force_at(charts, work, c, middle)[1] > 0.0) == rises:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


class _Stretch(NamedTuple):
    """A stretch on which a stop is closed, and a level of its force.

    Attributes:
        work: Combined for the case.
        c: The chart.
        begin: Travel in the chart [rad].
        end: Likewise.
        level: Force [N].
        wrong: Bound on the error of the force there [N].
    """

    charts: Charts
    work: Work
    c: int
    begin: float
    end: float
    level: float
    wrong: float


@compiled
def _passes(at: _Stretch, low: float, high: float, rises: bool) -> float:
    """Place where the force passes the level between two places on either side of it."""
    u = 0.5 * (low + high)
    for _ in range(_SEARCH_STEPS):
        force, slope = force_at(at.charts, at.work, at.c, u)
        if (force >= at.level) == rises:
            high = u
        else:
            low = u
        new = u - (force - at.level) / slope if slope != 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - u) <= 2.0 * EPS * at.charts.span[at.c]:
            return new
        u = new
    return u


@compiled
def _unsure(at: _Stretch, u: float) -> float:
    """Travel to either side of a place beyond which the force is surely off the level."""
    slope = abs(force_at(at.charts, at.work, at.c, u)[1])
    beside, most = 8.0 * EPS * at.charts.span[at.c], at.end - at.begin
    if slope > 0.0:
        beside += min(2.0 * at.wrong / slope, most)
    while beside < most:
        low, high = max(u - beside, at.begin), min(u + beside, at.end)
        before = abs(force_at(at.charts, at.work, at.c, low)[0] - at.level)
        after = abs(force_at(at.charts, at.work, at.c, high)[0] - at.level)
        if (low == at.begin or before >= at.wrong) and (high == at.end or after >= at.wrong):
            break
        beside *= 2.0
    return float(beside)


@compiled
def _part(at: _Stretch, left: float, old: float, right: float,
          force: float) -> tuple[float, float]:  # fmt: skip
    """Travel with a force above the level, of a part where it rises or falls, and its error."""
    if (old >= at.level) == (force >= at.level):
        return (right - left if force >= at.level else 0.0), 0.0
    place = _passes(at, left, right, force >= at.level)
    return (place - left if old >= at.level else right - place), _unsure(at, place)


@compiled
def held(charts: Charts, work: Work, hold: FloatArray,
         level: float) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Forces of a closed stop on a stretch.

    Args:
        work: Combined for the case.
        hold: The stretch, shape (HOLD_COLUMNS,).
        level: Force [N].

    Returns:
        Least force, largest force and travel with a force above the level, each before the bound on
        its error.
    """
    c, begin, end = int(hold[HOLD_CHART]), hold[HOLD_BEGIN], hold[HOLD_END]
    absolute, relative = wrong_by(charts, work, c)
    near = absolute + relative * abs(level)
    at = _Stretch(charts, work, c, begin, end, level, near)
    step = charts.span[c] / (charts.inertia.shape[1] * _PLACES)
    u = begin
    old, old_slope = force_at(charts, work, c, u)
    least = most = old
    # The stretch may begin and end a little earlier or later.
    ends = 2.0 * abs(old_slope) * hold[HOLD_BEGIN_ERROR]
    low, high = old - ends, old + ends
    above = beside = 0.0
    if old >= level - near - ends:
        beside += hold[HOLD_BEGIN_ERROR]
    while True:
        new = min(step * (np.floor(u / step * (1.0 + 8.0 * EPS)) + 1.0), end)
        force, slope = force_at(charts, work, c, new)
        if (old_slope > 0.0) != (slope > 0.0):
            middle = _extreme(charts, work, c, u, new, old_slope > 0.0)
            top, _ = force_at(charts, work, c, middle)
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
    ends = 2.0 * abs(old_slope) * hold[HOLD_END_ERROR]
    low, high = min(low, old - ends), max(high, old + ends)
    if old >= level - near - ends:
        beside += hold[HOLD_END_ERROR]
    least_wrong = absolute + relative * abs(least) + max(least - low, 0.0)
    most_wrong = absolute + relative * abs(most) + max(high - most, 0.0)
    beside += 8.0 * EPS * (end - begin)
    return least, least_wrong, most, most_wrong, above, beside
