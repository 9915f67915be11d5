"""Where a closed stop lets go, compiled: the first place at which its force falls to zero."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...tolerances.reduced import FORCE_SIGN
from . import layout as rows
from .compiled import part
from .flight_errors import size
from .panel import along, cell_at, chebyshev

_PLACES = 24
_ROOT_STEPS = 60


@part
def released(line: FloatArray, per_rad: float, begin: float, end: float) -> float:
    """First place in [begin, end] from which on the force of a stop is zero or below.

    Returns:
        The place; ``end`` plus 1 if there is none; -1 if round-off hides the sign.
    """
    cells, count = line.shape
    width = 1.0 / per_rad
    scale = 0.0
    for cell in range(cells):
        scale = max(scale, abs(line[cell, 0]))
    beside = FORCE_SIGN * scale
    older = old = -np.inf
    for cell in range(min(max(int(begin / width), 0), cells - 1), cells):
        left, right = max(begin, cell * width), min(end, (cell + 1) * width)
        if left >= right:
            break
        bound = line[cell, 0]
        for i in range(1, count):
            bound += abs(line[cell, i])
        if bound < -beside:
            older = old = -np.inf
            continue
        step = (right - left) / _PLACES
        for j in range(_PLACES + 1):
            u = left + step * j
            value = within(line, cell, width, u)
            if value > 0.0:
                return u if old == -np.inf else _crossing(line, per_rad, u - step, u)
            if j == 0:
                # The end of the cell before.
                old = value if old == -np.inf else old
                continue
            # Between places it is higher by less than it falls beside them.
            fall = old - value if older == -np.inf else old - min(older, value)
            if old >= older and old >= value and old + fall > 0.0:
                top = _top(line, per_rad, max(begin, u - 2.0 * step), u)
                highest = along(line, per_rad, top)
                if abs(highest) <= beside:
                    return -1.0
                if highest > 0.0:
                    return _crossing(line, per_rad, max(begin, u - 2.0 * step), top)
            older, old = old, value
    return -1.0 if old > -beside and old > -np.inf else end + 1.0


@part
def within(line: FloatArray, cell: int, width: float, u: float) -> float:
    """Value of a series of the travel at a place of a cell, or beside it."""
    return chebyshev(line, cell, 0, line.shape[1], 2.0 * (u - cell * width) / width - 1.0)


@part
def _top(line: FloatArray, per_rad: float, low: float, high: float) -> float:
    """Place of the largest value between two places that hold one."""
    for _ in range(_ROOT_STEPS):
        third = (high - low) / 3.0
        left, right = low + third, high - third
        if along(line, per_rad, left) < along(line, per_rad, right):
            low = left
        else:
            high = right
    return 0.5 * (low + high)


@part
def _crossing(line: FloatArray, per_rad: float, low: float, high: float) -> float:
    """Rising zero of a line, on its far side (regula falsi, the Illinois way)."""
    below, above, side = along(line, per_rad, low), along(line, per_rad, high), 0
    for _ in range(_ROOT_STEPS):
        middle = high - above * (high - low) / (above - below)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        value = along(line, per_rad, middle)
        # An end that stays counts half, so that the other side is met, too.
        if value > 0.0:
            high, above, below, side = middle, value, (0.5 * below if side > 0 else below), 1
        else:
            low, below, above, side = middle, value, (0.5 * above if side < 0 else above), -1
    return high


@part
def release_error(line: FloatArray, sizes: FloatArray, per_rad: float, u: float) -> float:
    """Bound on the error of the travel at which the force of a stop has fallen to zero."""
    width = 1.0 / per_rad
    cell, _ = cell_at(per_rad, line.shape[0], u)
    step = 1e-3 * width
    later, before = within(line, cell, width, u + step), within(line, cell, width, u - step)
    slope = (later - before) / (2.0 * step)
    return float(size(sizes, rows.RESIDUAL, 0.0) / max(abs(slope), 1e-300))
