"""One panel of a flight, compiled: Picard iteration on nested Chebyshev grids.

The travel of a node does not change in the iteration, so the tables are contracted over the travel
once a node; a sweep then costs three short polynomials in x for each node.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ...arrays import FloatArray
from ...chebyshev import evaluate, nodes, prolonged
from ...tolerances.hybrid import ITERATION_FLOOR
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import COARSE_SWEEP, DEFECT_EFFECT
from . import layout as rows
from .compiled import inlined, part
from .layout import Case, Solver

# Panels end this much beyond the zero of x that is expected.
OVERSHOOT = 1.01
# Lengths that are tried to meet it.
_GUESSES = 4


@part
def reach(solver: Solver, c: int, u: float, until: float) -> None:
    """Combine the cells of a chart between two travels for the case, where that is not done yet."""
    ready, per_rad = solver.work.ready[c], solver.charts.numbers[c, rows.PER_RAD]
    first, last = cell_at(per_rad, len(ready), u)[0], cell_at(per_rad, len(ready), until)[0]
    for cell in range(first, last + 1):
        if not ready[cell]:
            _mix(solver, c, cell)
            ready[cell] = True


@part
def _mix(solver: Solver, c: int, cell: int) -> None:
    """Combine the functions of a cell for the parameters of the case."""
    gaps = solver.charts.gaps[c]
    _, _, count_u, count_x = gaps.shape
    for i in range(count_u):
        row = solver.work.mixed[c, cell, i]
        combine(solver.charts.equation[c, cell, i], solver.one, rows.NO, row)
        for stop in range(len(gaps) // 3):
            for m in range(count_x):
                row[(3 + stop) * count_x + m] = gaps[stop, cell, i, m]


@part
def combine(f: FloatArray, one: Case, bounds: bool, row: FloatArray) -> None:
    """Combine functions for a case: the terms of x'' without x', with it, and with its square.

    Args:
        f: Coefficients, values, or bounds, shape (functions, N).
        bounds: Whether they are bounds, so that all terms are positive.
        row: Written, the three one after the other; or only the first, shape (N,).
    """
    speed, stiffness, preload, count = one.speed, one.stiffness, one.preload, f.shape[1]
    first = 4 + 2 * len(stiffness)
    others = len(f) == first + 3
    for m in range(count):
        row[m] = speed * speed * f[0, m] + f[3, m]
    for k in range(len(stiffness)):
        unit = stiffness[k] * (abs(preload[k]) if bounds else preload[k])
        for m in range(count):
            row[m] += unit * f[4 + 2 * k, m] + stiffness[k] * f[5 + 2 * k, m]
    if others:
        for m in range(count):
            row[m] += f[first, m] + speed * f[first + 1, m]
    if len(row) == count:
        return
    for m in range(count):
        row[count + m], row[2 * count + m] = speed * f[1, m], f[2, m]
        if others:
            row[count + m] += f[first + 2, m]


@part
def cell_at(per_rad: float, cells: int, u: float) -> tuple[int, float]:
    """Cell of a travel, and its place in [-1, 1] there."""
    past = u * per_rad
    cell = min(max(int(past), 0), cells - 1)
    return cell, 2.0 * (past - cell) - 1.0


@part
def contract(solver: Solver, c: int, j: int, u: float) -> None:
    """Functions of a chart at one travel, as polynomials in x, into row j of the scratch array."""
    poly, mixed = solver.work.poly, solver.work.mixed[c]
    cells, count_u, size = mixed.shape
    cell, place = cell_at(solver.charts.numbers[c, rows.PER_RAD], cells, u)
    for m in range(size):
        poly[j, m] = mixed[cell, 0, m] + place * mixed[cell, 1, m]
    older, old, i = 1.0, place, 2
    # Four terms a pass: the polynomials are written less often.
    while i + 3 < count_u:
        first = 2.0 * place * old - older
        second = 2.0 * place * first - old
        older = 2.0 * place * second - first
        old = 2.0 * place * older - second
        for m in range(size):
            poly[j, m] += (
                first * mixed[cell, i, m] + second * mixed[cell, i + 1, m]
                + older * mixed[cell, i + 2, m] + old * mixed[cell, i + 3, m]
            )  # fmt: skip
        i += 4
    while i < count_u:
        older, old = old, 2.0 * place * old - older
        for m in range(size):
            poly[j, m] += old * mixed[cell, i, m]
        i += 1


@part
def chebyshev(table: FloatArray, row: int, first: int, count: int, place: float) -> float:
    """Chebyshev series in a row of a table at a place in [-1, 1]."""
    high = low = 0.0
    for i in range(first + count - 1, first, -1):
        # In this order a term waits for one product and one sum of those before.
        high, low = 2.0 * place * high + (table[row, i] - low), high
    return float(place * high + (table[row, first] - low))


@part
def along(line: FloatArray, per_rad: float, u: float) -> float:
    """Value of a series of the travel, one row a cell."""
    cell, place = cell_at(per_rad, line.shape[0], u)
    return chebyshev(line, cell, rows.ZERO, line.shape[1], place)


@part
def range_along(line: FloatArray, per_rad: float, u: float, until: float) -> tuple[float, float]:
    """Bounds on the least and the largest value of such a series between two travels."""
    cells = len(line)
    low, high = np.inf, -np.inf
    for cell in range(cell_at(per_rad, cells, u)[0], cell_at(per_rad, cells, until)[0] + 1):
        left, right = max(u * per_rad - cell, 0.0), min(until * per_rad - cell, 1.0)
        least, most = range_in(line, cell, left, right)
        low, high = min(low, least), max(high, most)
    return low, high


@part
def range_in(line: FloatArray, cell: int, left: float, right: float) -> tuple[float, float]:
    """The same between two places of one cell, by its length."""
    count = line.shape[1]
    middle, beside = chebyshev(line, cell, rows.ZERO, count, left + right - 1.0), 0.0
    for i in range(1, count):
        # T_i' is no larger than i^2, and T_i is between -1 and 1.
        beside += min((right - left) * i * i, 2.0) * abs(line[cell, i])
    return middle - beside, middle + beside


@part
def place_of(number: FloatArray, x: float) -> float:
    """Place of a coordinate in [-1, 1], by the numbers of a chart."""
    return float(number[rows.SCALE] * (x - number[rows.LOW]) - 1.0)


@part
def acceleration(solver: Solver, c: int, row: int, x: float, v: float) -> float:
    """Acceleration at the travel that was contracted into a row."""
    poly, degree = solver.work.poly, solver.charts.equation.shape[4]
    place = place_of(solver.charts.numbers[c], x)
    p0 = chebyshev(poly, row, rows.ZERO, degree, place)
    p1 = chebyshev(poly, row, degree, degree, place)
    p2 = chebyshev(poly, row, 2 * degree, degree, place)
    return p0 + v * (p1 + v * p2)


@part
def _spread(solver: Solver, level: int) -> None:
    """Move the nodes of the level below to their places in this one, and refine accelerations."""
    grids, poly, nodes = solver.grids, solver.work.poly, solver.work.nodes
    coarse, fine = rows.LEVELS[level - 1], rows.LEVELS[level]
    for j in range(coarse - 1, 0, -1):
        for m in range(poly.shape[1]):
            poly[2 * j, m] = poly[j, m]
    for j in range(fine):
        nodes[rows.NODE_NEW, j] = 0.0
    for i in range(coarse):
        value = nodes[rows.NODE_A, i]
        for j in range(fine):
            nodes[rows.NODE_NEW, j] += grids[rows.REFINE, level, i, j] * value
    for j in range(fine):
        nodes[rows.NODE_A, j] = nodes[rows.NODE_NEW, j]


@part
def _positions(solver: Solver, level: int, h: float, x0: float, v0: float) -> None:
    """Positions and rates at the nodes from the accelerations there."""
    grids, nodes, count = solver.grids, solver.work.nodes, rows.LEVELS[level]
    for j in range(count):
        nodes[rows.NODE_X, j] = x0 + h * grids[rows.SIGMA, level, 0, j] * v0
        nodes[rows.NODE_V, j] = v0
    for i in range(count):
        value = h * nodes[rows.NODE_A, i]
        twice = h * value
        for j in range(count):
            nodes[rows.NODE_V, j] += grids[rows.ONCE, level, i, j] * value
            nodes[rows.NODE_X, j] += grids[rows.TWICE, level, i, j] * twice


@inlined
def _sweep(solver: Solver, c: int, level: int, h: float, x0: float, v0: float) -> float:
    """One Picard sweep; returns the largest change of the accelerations."""
    _positions(solver, level, h, x0, v0)
    poly, nodes, degree = solver.work.poly, solver.work.nodes, solver.charts.equation.shape[4]
    number, change = solver.charts.numbers[c], 0.0
    for j in range(rows.LEVELS[level]):
        # Beyond the domain the answer is refused; until then it only has to stay finite.
        t = min(max(place_of(number, nodes[rows.NODE_X, j]), -1.3), 1.3)
        older, old = 1.0, t
        p0 = poly[j, 0] + t * poly[j, 1]
        p1 = poly[j, degree] + t * poly[j, degree + 1]
        p2 = poly[j, 2 * degree] + t * poly[j, 2 * degree + 1]
        for m in range(2, degree):
            older, old = old, 2.0 * t * old - older
            p0 += old * poly[j, m]
            p1 += old * poly[j, degree + m]
            p2 += old * poly[j, 2 * degree + m]
        v = nodes[rows.NODE_V, j]
        value = p0 + v * (p1 + v * p2)
        change = max(change, abs(value - nodes[rows.NODE_A, j]))
        nodes[rows.NODE_A, j] = value
    return change


@part
def _defect(solver: Solver, c: int, level: int, u: float, h: float, x0: float, v0: float) -> float:
    """By how much x'' of the panel misses the equation of motion between the nodes."""
    grids, nodes, speed = solver.grids, solver.work.nodes, solver.one.speed
    most, row = 0.0, len(solver.work.poly) - 1
    for probe in range(rows.PROBES):
        value = once = twice = 0.0
        for j in range(rows.LEVELS[level]):
            a = nodes[rows.NODE_A, j]
            value += grids[rows.PROBE, level, j, probe] * a
            once += grids[rows.PROBE_ONCE, level, j, probe] * a
            twice += grids[rows.PROBE_TWICE, level, j, probe] * a
        sigma = grids[rows.SIGMA, level, 1, probe]
        contract(solver, c, row, u + h * speed * sigma)
        x, v = x0 + h * (sigma * v0 + h * twice), v0 + h * once
        most = max(most, abs(acceleration(solver, c, row, x, v) - value))
    return most


@part
def _too_coarse(solver: Solver, level: int, allowed: float) -> bool:
    """Whether a grid will leave out more than is allowed, if coefficients go on to fall as they do.

    It only saves sweeps: whether a finer grid resolves the motion is asked there.
    """
    grids, nodes, count = solver.grids, solver.work.nodes, rows.LEVELS[level]
    last = before = 0.0
    for j in range(count):
        last += grids[rows.VALUE, level, j, count - 1] * nodes[rows.NODE_A, j]
        before += grids[rows.VALUE, level, j, count - 2] * nodes[rows.NODE_A, j]
    return DEFECT_EFFECT * last * last > count * count * max(abs(before), abs(last)) * allowed


@part
def solve_panel(solver: Solver, c: int, u: float, h: float, x0: float, v0: float, a0: float,
                estimate: bool, tolerance: float) -> tuple[int, float, float, float]:  # fmt: skip
    """Solve one panel; its length first meets the next zero of x, if ``estimate``.

    Its start has been contracted into the first row.

    Returns:
        Level of the grid (-1: not resolved), length, the last change of x'', and the steady error
        of x'' that does what the coefficients missing from the series and round-off do.
    """
    grids, nodes, speed = solver.grids, solver.work.nodes, solver.one.speed
    longest = (solver.charts.numbers[c, rows.TRAVEL_MOST] - u) / speed
    for j in range(rows.LEVELS[0]):
        nodes[rows.NODE_A, j] = a0
    for guess in range(_GUESSES + 1):
        h = min(h, longest)
        reach(solver, c, u, u + h * speed)
        for j in range(1, rows.LEVELS[0]):
            contract(solver, c, j, u + h * speed * grids[rows.SIGMA, 0, 0, j])
        if not estimate or guess == _GUESSES:
            break
        for _ in range(3):
            change = _sweep(solver, c, rows.ZERO, h, x0, v0)
            if change <= COARSE_SWEEP * abs(a0):
                break
        _positions(solver, rows.ZERO, h, x0, v0)
        end = rows.LEVELS[0] - 1
        end_x, end_v = nodes[rows.NODE_X, end], nodes[rows.NODE_V, end]
        # Nor does a motion that overflows tell where its zero is.
        if not -np.inf < end_v < 0.0 or not np.isfinite(end_x):
            break
        root = 1.0 - end_x / (h * end_v)
        if 0.95 <= root <= 0.999 or (root > 1.0 and h == longest):
            break
        h *= OVERSHOOT * min(max(root, 0.3), 3.0)
    last = len(rows.LEVELS) - 1
    for level in range(len(rows.LEVELS)):
        count = rows.LEVELS[level]
        if level > 0:
            _spread(solver, level)
            for j in range(1, count, 2):
                contract(solver, c, j, u + h * speed * grids[rows.SIGMA, level, 0, j])
        converged = False
        scale = 1.0
        change = np.inf
        for sweep in range(24 if level == last else 4):
            previous = change
            change = _sweep(solver, c, level, h, x0, v0)
            largest = 0.0
            for j in range(count):
                largest = max(largest, abs(nodes[rows.NODE_A, j]))
            scale = abs(v0) / h + largest
            if sweep == 0 and level < last and _too_coarse(solver, level, tolerance * scale):
                break
            # Infinity is within no tolerance of itself.
            if change <= tolerance * scale < np.inf:
                converged = True
                break
            if sweep > 4 and change > 0.5 * previous:
                converged = change <= ITERATION_FLOOR * scale < np.inf
                break
        if not converged:
            continue
        left = _defect(solver, c, level, u, h, x0, v0)
        left *= DEFECT_EFFECT / (count * count)
        if left <= tolerance * scale < np.inf:
            _positions(solver, level, h, x0, v0)
            return level, h, change, left + 8.0 * EPS * scale
    return -1, h, np.inf, np.inf


@part
def coefficients(solver: Solver, level: int) -> None:
    """Series of the accelerations and of their integrals from the start of the panel."""
    grids, nodes, count = solver.grids, solver.work.nodes, rows.LEVELS[level]
    for i in range(count):
        nodes[rows.SERIES, i] = 0.0
    for j in range(count):
        a = nodes[rows.NODE_A, j]
        for i in range(count):
            nodes[rows.SERIES, i] += grids[rows.VALUE, level, j, i] * a
    _integrate(nodes, rows.SERIES, rows.SERIES_ONCE, count)
    _integrate(nodes, rows.SERIES_ONCE, rows.SERIES_TWICE, count + 1)


@part
def _integrate(nodes: FloatArray, row: int, to: int, count: int) -> None:
    """Integrate a series of so many terms from the start of the panel, by the panel."""
    start, sign = 0.0, 1.0
    for i in range(1, count + 1):
        before = nodes[row, i - 1] if i > 1 else 2.0 * nodes[row, 0]
        value = 0.25 * (before - (nodes[row, i + 1] if i + 1 < count else 0.0)) / i
        nodes[to, i] = value
        start, sign = start + sign * value, -sign
    nodes[to, 0] = start


@part
def position(nodes: FloatArray, count: int, h: float, x0: float, v0: float, sigma: float) -> float:
    """Coordinate x at a place sigma of the panel."""
    twice = chebyshev(nodes, rows.SERIES_TWICE, rows.ZERO, count + 2, 2.0 * sigma - 1.0)
    return x0 + h * (sigma * v0 + h * twice)


@part
def rate_at(nodes: FloatArray, count: int, h: float, v0: float, sigma: float) -> float:
    """Rate x' at a place sigma of the panel."""
    return v0 + h * chebyshev(nodes, rows.SERIES_ONCE, rows.ZERO, count + 1, 2.0 * sigma - 1.0)


@cache
def grids() -> FloatArray:
    """Nested collocation grids with the operators of the direct engine, padded to the finest one.

    Returns:
        Shape (operators, levels, N, N + 2); see the names in the kernel.
    """
    finest = rows.LEVELS[-1]
    found = np.zeros((rows.SIGMA + 1, len(rows.LEVELS), finest, finest + 2))
    for level, count in enumerate(rows.LEVELS):
        grid = nodes(count)
        # In the middle between two nodes, as the zeros of what an interpolant misses are spaced.
        # Polynomials of three degrees that cancel at one of the probes do not at all of them.
        first, middle = (np.pi * (int((count - 1) / part) + 0.5) / (count - 1) for part in (4, 2))
        probes = 0.5 * (1.0 - np.cos([first, middle, np.pi - first]))
        found[rows.SIGMA, level, 0, :count] = grid.sigma
        found[rows.SIGMA, level, 1, : rows.PROBES] = probes
        operators = [
            (rows.ONCE, grid.once), (rows.TWICE, grid.twice), (rows.VALUE, grid.integrals[0]),
        ]  # fmt: skip
        operators += [
            (kind, evaluate(np.eye(count), probes, integrations))
            for integrations, kind in enumerate((rows.PROBE, rows.PROBE_ONCE, rows.PROBE_TWICE))
        ]
        if level:
            operators.append((rows.REFINE, prolonged(np.eye(rows.LEVELS[level - 1]), count)))
        for kind, operator in operators:
            to, start = operator.shape
            found[kind, level, :start, :to] = operator.T
    return found
