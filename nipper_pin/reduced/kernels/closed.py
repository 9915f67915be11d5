"""Force of a closed stop along a stretch, compiled: its extremes, and where it passes a level."""

from __future__ import annotations

from typing import NamedTuple

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from . import layout as rows
from .compiled import part
from .layout import Solver

# Places of a cell between which a force has at most one extreme.
PLACES = 16
_STEPS = 60


class Stretch(NamedTuple):
    """A stretch on which a stop is closed, and a level of its force.

    Attributes:
        c: The chart.
        line: x'' along x = 0 at rest, or another function with its sign, shape (cells, Nu).
        begin: Travel in the chart [rad].
        end: Likewise.
        level: Force [N].
        wrong: Bound on the error of the force there [N].
    """

    solver: Solver
    c: int
    line: FloatArray
    begin: float
    end: float
    level: float
    wrong: float


@part
def series_at(table: FloatArray, per_rad: float, u: float) -> tuple[float, float]:
    """A Chebyshev series of the travel, one row a cell; at the end of a cell that of this cell."""
    # Beyond the last cell functions are constant.
    cell = min(max(int(u * per_rad * (1.0 - 8.0 * EPS)), 0), len(table) - 1)
    place = 2.0 * (u * per_rad - cell) - 1.0
    high = low = rise = fall = 0.0
    for i in range(table.shape[1] - 1, 0, -1):
        rise, fall = 2.0 * (high + place * rise) - fall, rise
        high, low = table[cell, i] + 2.0 * place * high - low, high
    value, slope = table[cell, 0] + place * high - low, high + place * rise - fall
    return value, 2.0 * per_rad * slope


@part
def force_at(at: Stretch, u: float) -> tuple[float, float]:
    """Normal force of a closed stop [N], along the joint without a contact point, and its slope."""
    charts, c = at.solver.charts, at.c
    per_rad, lever = charts.numbers[c, rows.PER_RAD], charts.lever[charts.stops[c, rows.OWN]]
    C, C_u = series_at(charts.inertia[c], per_rad, u)
    a, a_u = series_at(at.line, per_rad, u)
    return -C * a / lever, -(C_u * a + C * a_u) / lever


@part
def extreme(at: Stretch, low: float, high: float, rises: bool) -> float:
    """Place between two others where the slope of the force changes its sign."""
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (force_at(at, middle)[1] > 0.0) == rises:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@part
def passage(at: Stretch, low: float, high: float, rises: bool) -> float:
    """Place where the force passes the level between two places on either side of it."""
    u = 0.5 * (low + high)
    for _ in range(_STEPS):
        force, slope = force_at(at, u)
        if (force >= at.level) == rises:
            high = u
        else:
            low = u
        new = u - (force - at.level) / slope if slope != 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - u) <= 2.0 * EPS * high:
            return new
        u = new
    return u
