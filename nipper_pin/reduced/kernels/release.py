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
def released(line: FloatArray, length: float, begin: float, end: float) -> float:
    """First place in [begin, end] from which on the force of a stop is zero or below.

    Returns:
        The place; ``end`` plus 1 if there is none; -1 if round-off hides the sign.
    """
    cells, count = line.shape
    width = length / cells
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
                return u if old == -np.inf else _crossing(line, length, u - step, u)
            if j == 0:
                # The end of the cell before.
                old = value if old == -np.inf else old
                continue
            # Between places it is higher by less than it falls beside them.
            fall = old - value if older == -np.inf else old - min(older, value)
            if old >= older and old >= value and old + fall > 0.0:
                top = _top(line, length, max(begin, u - 2.0 * step), u)
                highest = along(line, length, top)
                if abs(highest) <= beside:
                    return -1.0
                if highest > 0.0:
                    return _crossing(line, length, max(begin, u - 2.0 * step), top)
            older, old = old, value
    return -1.0 if old > -beside and old > -np.inf else end + 1.0


@part
def within(line: FloatArray, cell: int, width: float, u: float) -> float:
    """Value of a series of the travel at a place of a cell, or beside it."""
    return chebyshev(line, cell, 0, line.shape[1], 2.0 * (u - cell * width) / width - 1.0)


@part
def _top(line: FloatArray, length: float, low: float, high: float) -> float:
    """Place of the largest value between two places that hold one."""
    for _ in range(_ROOT_STEPS):
        third = (high - low) / 3.0
        left, right = low + third, high - third
        if along(line, length, left) < along(line, length, right):
            low = left
        else:
            high = right
    return 0.5 * (low + high)


@part
def _crossing(line: FloatArray, length: float, low: float, high: float) -> float:
    """Rising zero of a line, on its far side."""
    for _ in range(_ROOT_STEPS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if along(line, length, middle) > 0.0:
            high = middle
        else:
            low = middle
    return high


@part
def release_error(line: FloatArray, sizes: FloatArray, span: float, u: float) -> float:
    """Bound on the error of the travel at which the force of a stop has fallen to zero."""
    width = span / line.shape[0]
    cell, _ = cell_at(span, line.shape[0], u)
    step = 1e-3 * width
    later, before = within(line, cell, width, u + step), within(line, cell, width, u - step)
    slope = (later - before) / (2.0 * step)
    return float(size(sizes, rows.RESIDUAL, 0.0) / max(abs(slope), 1e-300))
