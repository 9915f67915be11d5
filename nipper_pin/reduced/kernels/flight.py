"""One flight of the reduced model, compiled: from a collision to the next one.

Where there is room for the panels of a motion, they are kept: rows of the scratch array with their
series, as ``position`` and ``rate_at`` read them, and in the row KEPT their numbers. A stretch at
rest is a panel without nodes.

The numbers of a panel: its chart, travel at its begin, length [s], part of it that is covered, x
and x' at its begin, nodes (0: at rest), bounds on the errors of time, x and x' and on what the
solver adds to that of x'', and the rate with which bounces begin that are not computed before it.
"""

from __future__ import annotations

from math import sqrt

from ...tolerances.reduced import NEWTON_STEP, TRAVEL_END, ZERO_RESOLUTION
from . import layout as rows
from .compiled import inlined, part
from .flight_errors import grow
from .hits import SolvedPanel, first_hit
from .layout import Flown, Motion, Records, Solver
from .panel import (
    OVERSHOOT,
    acceleration,
    chebyshev,
    coefficients,
    contract,
    position,
    rate_at,
    reach,
    solve_panel,
)

(
    CHART, FROM, LENGTH, COVERED, X_BEGIN, V_BEGIN, NODES, T_WRONG, X_WRONG, V_WRONG, A_WRONG,
    BOUNCED,
) = range(12)  # fmt: skip


@part
def keep(solved: SolvedPanel, order: int, covered: float) -> None:
    """Keep a panel of so many nodes up to a part of it, if there is room for one more."""
    records, work = solved.solver.records, solved.solver.work
    number = records.counts[rows.PANELS]
    if number == len(records.panels):
        return
    block = records.panels[number]
    for row in (rows.SERIES, rows.SERIES_ONCE, rows.SERIES_TWICE):
        for i in range(order + 2):
            block[row, i] = work.nodes[row, i]
    numbers = block[rows.KEPT]
    numbers[CHART], numbers[FROM], numbers[LENGTH] = solved.c, solved.u, solved.h
    numbers[COVERED], numbers[X_BEGIN], numbers[V_BEGIN] = covered, solved.x0, solved.v0
    numbers[NODES], numbers[BOUNCED] = order, work.memory[rows.SETTLED]
    records.counts[rows.PANELS] += 1


@part
def describe(records: Records, first: int, late: float, dx: float, dv: float, da: float) -> None:
    """Give the panels from the first one on bounds on the errors along them."""
    for number in range(first, records.counts[rows.PANELS]):
        numbers = records.panels[number, rows.KEPT]
        numbers[T_WRONG], numbers[X_WRONG], numbers[V_WRONG], numbers[A_WRONG] = late, dx, dv, da


# Travel in which accelerations hardly change, so that a first guess needs no better one [rad].
_STEADY = 0.1
_MOST_PANELS = 64
_MOST_HALVINGS = 12
# Number of the other stop where there is none.
_NONE: int = rows.numbered(1, -1)[0]


@part
def _zero(solved: SolvedPanel, of_rate: bool, low: float, high: float, start: float) -> float:
    """Zero in (low, high], to round-off, of what falls through it: x or its rate.

    Of x that begins at zero it is that of x / sigma.
    """
    nodes, h, x0, v0 = solved.solver.work.nodes, solved.h, solved.x0, solved.v0
    sigma, count = start, rows.LEVELS[solved.level]
    for _ in range(60):
        f = v = rate_at(nodes, count, h, v0, sigma)
        if of_rate:
            slope = h * chebyshev(nodes, rows.SERIES, rows.ZERO, count, 2.0 * sigma - 1.0)
        else:
            f, slope = position(nodes, count, h, x0, v0, sigma), h * v
            if x0 == 0.0:
                f /= sigma
                slope = (slope - f) / sigma
        if f > 0.0:
            low = sigma
        else:
            high = sigma
        step = abs(f / slope)
        new = sigma - f / slope
        if not (low <= new <= high):
            if step <= ZERO_RESOLUTION * sigma:
                return sigma
            new = 0.5 * (low + high)
        elif step <= NEWTON_STEP * sigma:
            return new
        sigma = new
    return sigma


@part
def _first_zero(solved: SolvedPanel) -> float:
    """First passage of x from positive to not positive on a panel, or -1."""
    grids, nodes, level = solved.solver.grids, solved.solver.work.nodes, solved.level
    count, h, x0, v0 = rows.LEVELS[level], solved.h, solved.x0, solved.v0
    for j in range(1, count):
        x, before = nodes[rows.NODE_X, j], grids[rows.SIGMA, level, 0, j - 1]
        if x <= 0.0:
            high = grids[rows.SIGMA, level, 0, j]
            start, v = high, nodes[rows.NODE_V, j]
            if v < 0.0:
                start = max(high - x / (h * v), 0.5 * (before + high))
            return _zero(solved, rows.NO, before, high, start)
        if nodes[rows.NODE_V, j - 1] < 0.0 <= nodes[rows.NODE_V, j]:
            # A minimum between two positive nodes may be below zero.
            low, high = before, grids[rows.SIGMA, level, 0, j]
            for _ in range(60):
                middle = 0.5 * (low + high)
                if rate_at(nodes, count, h, v0, middle) < 0.0:
                    low = middle
                else:
                    high = middle
            if position(nodes, count, h, x0, v0, high) <= 0.0:
                return _zero(solved, rows.NO, before, high, high)
    return -1.0


@part
def _highest(solved: SolvedPanel, end: float) -> tuple[float, float]:
    """Largest x on [0, end] and its place."""
    grids, nodes, level = solved.solver.grids, solved.solver.work.nodes, solved.level
    count, h, x0, v0 = rows.LEVELS[level], solved.h, solved.x0, solved.v0
    best, place, number = x0, 0.0, 0
    for j in range(1, count):
        if grids[rows.SIGMA, level, 0, j] < end and nodes[rows.NODE_X, j] > best:
            best, place, number = nodes[rows.NODE_X, j], grids[rows.SIGMA, level, 0, j], j
    before = max(number - 1, 0)
    low, rising = grids[rows.SIGMA, level, 0, before], nodes[rows.NODE_V, before]
    high = min(grids[rows.SIGMA, level, 0, min(number + 1, count - 1)], end)
    falling = rate_at(nodes, count, h, v0, high)
    if rising <= 0.0 or falling >= 0.0:
        return best, place
    peak = _zero(solved, rows.YES, low, high, low + (high - low) * rising / (rising - falling))
    return max(best, position(nodes, count, h, x0, v0, peak)), peak


@part
def _ballistic(solver: Solver, c: int, u: float, x: float, v: float, a0: float) -> float:
    """Time to the next zero of x, for an acceleration a0 < 0 that changes linearly with time."""
    h = (v + sqrt(max(v * v - 2.0 * a0 * x, 0.0))) / -a0
    until, row = u + h * solver.one.speed, len(solver.work.poly) - 1
    if x > 0.0 or until > solver.charts.numbers[c, rows.TRAVEL_MOST] or until - u < _STEADY:
        return h
    reach(solver, c, until, until)
    contract(solver, c, row, until)
    mean = (2.0 * a0 + acceleration(solver, c, row, 0.0, -v)) / 3.0
    return 2.0 * v / -mean if mean < 0.5 * a0 else h


@part
def _lost(status: int) -> Flown:
    """A flight that cannot be followed."""
    return Flown(status, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, _NONE, False)


@inlined
def flight(solver: Solver, at: Motion, tolerance: float) -> Flown:
    """Flight to the next zero of x; from x = 0 with a rate above zero, or at a release.

    Its start has been contracted into the first row.
    """
    c, work, speed, u0, x0 = at.chart, solver.work, solver.one.speed, at.u, at.x
    nodes, number = work.nodes, solver.charts.numbers[c]
    travel, high = number[rows.TRAVEL_MOST], number[rows.HIGH]
    t, x, v, a = 0.0, x0, at.v, 0.0
    top = peak = fastest = changed = left = 0.0
    g, traced = nodes[rows.GROWTH], False
    g[0], g[1], g[2], g[3], g[4], g[5] = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    for panel in range(_MOST_PANELS):
        u = u0 + speed * t
        longest = (travel - u) / speed
        if longest <= TRAVEL_END * travel / speed:
            status = rows.LEFT_TRAVEL
            return Flown(status, t, v, top, peak, a, fastest, changed, left, x, _NONE, True)
        if panel > 0:
            reach(solver, c, u, u)
            contract(solver, c, rows.ZERO, u)
        a0 = acceleration(solver, c, rows.ZERO, x, v)
        h = longest
        # At a release a0 is round-off.
        if a0 < 0.0 and (x > 0.0 or v > 0.0):
            h = OVERSHOOT * _ballistic(solver, c, u, x, v, a0)
        level = -1
        change = missing = 0.0
        for halving in range(_MOST_HALVINGS):
            level, h, change, missing = solve_panel(
                solver, c, u, h, x, v, a0, halving == 0, tolerance
            )
            if level >= 0:
                break
            h *= 0.5
        if level < 0:
            # Outside the domain the tables do not hold, and the iteration does not converge.
            highest = 0.0
            for j in range(rows.LEVELS[-1]):
                highest = max(highest, nodes[rows.NODE_X, j])
            return _lost(rows.LEFT_GAP if highest > high else rows.UNRESOLVED)
        changed, left = max(changed, change), max(left, missing)
        count = rows.LEVELS[level]
        coefficients(solver, level)
        solved = SolvedPanel(solver, c, level, u, h, x, v)
        end = _first_zero(solved)
        until = end if end >= 0.0 else 1.0
        # A stop that is thrown open at the begin of a chart touches another one there.
        first = 1 if panel == 0 and u0 == 0.0 and x0 == 0.0 else 0
        for j in range(count):
            fastest = max(fastest, abs(nodes[rows.NODE_V, j]))
        place, hit = first_hit(solved, until, first)
        if hit >= 0:
            until = place
        # The usual bounce ends on its first panel, and its errors are known by a formula.
        traced = panel > 0 or end < 0.0 or x0 > 0.0 or hit >= 0
        if traced:
            grow(solved, until)
        keep(solved, count, until)
        highest, place = _highest(solved, until)
        if not highest <= high:
            return _lost(rows.LEFT_GAP)
        if highest > top:
            top, peak = highest, t + h * place
        if hit >= 0 or end >= 0.0:
            rate = rate_at(nodes, count, h, v, until)
            a = chebyshev(nodes, rows.SERIES, rows.ZERO, count, 2.0 * until - 1.0)
            gap = position(nodes, count, h, x, v, until) if hit >= 0 else 0.0
            status = rows.OTHER_STOP if hit >= 0 else rows.AT_REST
            t += h * until
            return Flown(status, t, rate, max(top, gap), peak, a, fastest, changed, left, gap, hit,
                         traced)  # fmt: skip
        t += h
        x, v = nodes[rows.NODE_X, count - 1], nodes[rows.NODE_V, count - 1]
        a = nodes[rows.NODE_A, count - 1]
    return _lost(rows.UNRESOLVED)
