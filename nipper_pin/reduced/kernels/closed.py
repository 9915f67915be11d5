"""Force of a closed stop, compiled: its extremes, where it passes a level, and where it lets go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import FORCE_SIGN
from . import layout as rows
from .compiled import part
from .flight_errors import size
from .layout import Solver
from .panel import cell_at, range_in

# Places of a cell between which a force has at most one extreme.
PLACES = 16
_STEPS = 60
# A force is flat at its extreme: half of the digits of the place give all of its value.
_HALVINGS = 27


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
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
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
        new = u - (force - at.level) / slope if slope != 0.0 else np.nan
        if abs(new - u) <= 2.0 * EPS * high:
            return new
        u = new if low < new < high else 0.5 * (low + high)
    return u


@part
def released(solver: Solver, c: int, line: FloatArray, begin: float, end: float) -> float:
    """First place in [begin, end] from which on the force of a stop is zero or below.

    Args:
        line: x'' along x = 0 at rest, or another function that is not above zero until then.

    Returns:
        The place; ``end`` plus 1 if there is none; -1 if round-off hides the sign.
    """
    at = Stretch(solver, c, line, begin, end, 0.0, 0.0)
    cells, per_rad = len(line), solver.charts.numbers[c, rows.PER_RAD]
    scale, value = 0.0, -np.inf
    for cell in range(cells):
        scale = max(scale, abs(line[cell, 0]))
    beside = FORCE_SIGN * scale
    for cell in range(cell_at(per_rad, cells, begin)[0], cells):
        u, right = max(begin, cell / per_rad), min(end, (cell + 1) / per_rad)
        if u >= right:
            break
        step, value = (right - u) / PLACES, -np.inf
        if range_in(line, cell, u * per_rad - cell, right * per_rad - cell)[1] < -beside:
            continue
        value, slope = series_at(line, per_rad, u)
        if value > 0.0:
            return float(u)
        for _ in range(PLACES):
            new = min(u + step, right)
            value, after = series_at(line, per_rad, new)
            top, highest = new, value
            if slope > 0.0 >= after:
                top = extreme(at, u, new, rows.NO)
                highest = series_at(line, per_rad, top)[0]
                if abs(highest) <= beside:
                    return -1.0
            if highest > 0.0:
                return passage(at, u, top, rows.NO)
            u, slope = new, after
    return -1.0 if value > -beside else end + 1.0


@part
def release_error(line: FloatArray, sizes: FloatArray, per_rad: float, u: float) -> float:
    """Bound on the error of the travel at which the force of a stop has fallen to zero."""
    slope = series_at(line, per_rad, u)[1]
    return float(size(sizes, rows.RESIDUAL, 0.0) / max(abs(slope), 1e-300))
