"""Where a closed stop lets go, compiled: the first place at which its force falls to zero."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...tolerances.reduced import FORCE_SIGN
from . import layout as rows
from .closed import PLACES, Stretch, extreme, passage, series_at
from .compiled import part
from .flight_errors import size
from .layout import Solver
from .panel import cell_at, range_in


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
                top = extreme(at, u, new, False)
                highest = series_at(line, per_rad, top)[0]
                if abs(highest) <= beside:
                    return -1.0
            if highest > 0.0:
                return passage(at, u, top, False)
            u, slope = new, after
    return -1.0 if value > -beside else end + 1.0


@part
def release_error(line: FloatArray, sizes: FloatArray, per_rad: float, u: float) -> float:
    """Bound on the error of the travel at which the force of a stop has fallen to zero."""
    slope = series_at(line, per_rad, u)[1]
    return float(size(sizes, rows.RESIDUAL, 0.0) / max(abs(slope), 1e-300))
