"""Where another stop closes in a flight, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import layout as rows
from .compiled import part
from .layout import Solver
from .panel import chebyshev, contract, place_of, position

# Halvings of a bracket from a panel to round-off.
_SEARCH_STEPS = 60


class SolvedPanel(NamedTuple):
    """A panel that has been solved.

    Attributes:
        c: The chart.
        level: The grid.
        u: Travel at the start of the panel [rad].
        h: Its length [s].
        x0: Coordinate at its start.
        v0: Rate there.
    """

    solver: Solver
    c: int
    level: int
    u: float
    h: float
    x0: float
    v0: float


@part
def first_hit(solved: SolvedPanel, end: float, first: int) -> tuple[float, int]:
    """First place before ``end`` where another stop closes, and its number; -1 without one.

    Nodes before ``first`` do not count: there a stop has just been thrown open.
    """
    place, hit, level, solver = end, -1, solved.level, solved.solver
    grids, poly, nodes = solver.grids, solver.work.poly, solver.work.nodes
    number, degree = solver.charts.numbers[solved.c], solver.charts.equation.shape[4]
    for column in range(3 * degree, poly.shape[1], degree):
        older = old = -np.inf
        for j in range(rows.LEVELS[level]):
            sigma = grids[rows.SIGMA, level, 0, j]
            at = place_of(number, nodes[rows.NODE_X, j])
            gap = chebyshev(poly, j, column, degree, at)
            low = grids[rows.SIGMA, level, 0, max(j - 1, 0)]
            high = sigma if gap <= 0.0 and j >= first else -1.0
            # Between nodes a minimum is lower by less than half the difference of its neighbours.
            drop = 0.5 * max(older - old, gap - old)
            if j >= 2 and gap > 0.0 and old < older and old <= gap and old <= drop:
                low = grids[rows.SIGMA, level, 0, max(j - 2, 0)]
                high = _dip(solved, column, low, sigma)
            if high >= 0.0:
                root = _closing(solved, column, low, high)
                if root < place:
                    place, hit = root, column // degree - 3
                break
            older, old = old, gap
            if sigma >= end:
                break
    return place, hit


@part
def _gap_at(solved: SolvedPanel, column: int, sigma: float) -> float:
    """Gap of another stop at a place sigma of the panel."""
    solver, c = solved.solver, solved.c
    poly, nodes, order = solver.work.poly, solver.work.nodes, rows.LEVELS[solved.level]
    row = len(poly) - 1
    contract(solver, c, row, solved.u + solved.h * solver.one.speed * sigma)
    x = position(nodes, order, solved.h, solved.x0, solved.v0, sigma)
    place = place_of(solver.charts.numbers[c], x)
    return chebyshev(poly, row, column, solver.charts.equation.shape[4], place)


@part
def _dip(solved: SolvedPanel, column: int, low: float, high: float) -> float:
    """A place between two others where a gap with one minimum is zero or below; -1 without one."""
    for _ in range(_SEARCH_STEPS):
        third = (high - low) / 3.0
        left, right = low + third, high - third
        before, after = _gap_at(solved, column, left), _gap_at(solved, column, right)
        if before <= 0.0:
            return left
        if after <= 0.0:
            return right
        if before < after:
            high = right
        else:
            low = left
    return -1.0


@part
def _closing(solved: SolvedPanel, column: int, low: float, high: float) -> float:
    """Zero of a gap that is positive at ``low`` and not at ``high``."""
    for _ in range(_SEARCH_STEPS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if _gap_at(solved, column, middle) > 0.0:
            low = middle
        else:
            high = middle
    return high
