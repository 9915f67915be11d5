"""Charts of a machine, combined for a case and evaluated, compiled."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from . import layout as rows
from .compiled import allocating, part
from .flight_errors import sizes_of
from .layout import Case, Charts, Motion, Records, Solver, Work
from .panel import cell_at, combine, place_of


@allocating
def scratch(charts: Charts, most: int) -> Work:
    """Scratch arrays for series of so many collisions."""
    count, cells, count_u, _, count_x = charts.equation.shape
    size = (3 + charts.gaps.shape[1] // 3) * count_x
    finest = rows.LEVELS[-1]
    return Work(
        np.empty((count, cells, count_u, size)), np.empty((count, 3 * rows.SIZES)),
        np.empty((count, cells, count_u)), np.empty((count, cells), dtype=np.bool_),
        np.empty((finest + 1, size)), np.empty((rows.SCRATCH_ROWS, finest + 2)),
        np.empty((3, most)), np.empty(rows.MEMORY),
    )  # fmt: skip


@allocating
def records_in(events: FloatArray, turns: int, panels: int) -> Records:
    """Room for what turns do, with that for their events; what is not written is never touched."""
    count = max(turns, 1)
    return Records(
        events, np.empty((count * rows.STRETCHES_OF_TURN, rows.HOLD_COLUMNS)),
        np.empty((count + 1, rows.END_COLUMNS)), np.zeros(rows.COUNTS, dtype=np.int64),
        np.empty((panels, rows.SCRATCH_ROWS, rows.LEVELS[-1] + 2)),
    )  # fmt: skip


@part
def case_of(charts: Charts, numbers: FloatArray) -> Case:
    """A case by its numbers."""
    first = charts.stops.shape[1]
    preload = (first + len(numbers)) // 2
    return Case(numbers[0], numbers[1:first], numbers[first:preload], numbers[preload:])


@part
def prepare(solver: Solver, rests: bool) -> None:
    """Combine for a case what is known of its charts before their cells: see ``reach``.

    Args:
        rests: Whether stops stay closed, so that x'' along them is asked for.
    """
    charts, work = solver.charts, solver.work
    work.ready[:] = False
    for c in range(len(charts.along)):
        sizes_of(charts.bounds[c], work.sizes[c], solver.one)
        for cell in range(charts.along.shape[1] if rests else 0):
            combine(charts.along[c, cell], solver.one, rows.NO, work.line[c, cell])


@part
def surface(table: FloatArray, row: int, number: FloatArray, u: float, x: float) -> float:
    """Value of one function of (u, x), shape of ``table`` (functions, cells, Nu, Nx)."""
    _, cells, count_u, count_x = table.shape
    cell, place_u = cell_at(number[rows.PER_RAD], cells, u)
    place_x = place_of(number, x)
    total, older, old = 0.0, 0.0, 1.0
    for i in range(count_u):
        high = low = 0.0
        for m in range(count_x - 1, 0, -1):
            high, low = table[row, cell, i, m] + 2.0 * place_x * high - low, high
        total += old * (table[row, cell, i, 0] + place_x * high - low)
        older, old = old, (place_u if i == 0 else 2.0 * place_u * old - older)
    return total


@part
def seen_by(solver: Solver, s: int, at: Motion) -> tuple[float, float, float, float]:
    """Gap and rate of another stop, and bounds on their errors, from those of a motion."""
    charts, speed, c, u, x, v = solver.charts, solver.one.speed, at.chart, at.u, at.x, at.v
    gaps, number = charts.gaps[c], charts.numbers[c]
    others = len(gaps) // 3
    gap = surface(gaps, s, number, u, x)
    by_x = surface(gaps, others + s, number, u, x)
    by_u = surface(gaps, 2 * others + s, number, u, x)
    wrong = charts.gap_bounds[c, s::others]
    # The slopes change by less than themselves over the whole domain.
    bent = at.dx / (number[rows.HIGH] - number[rows.LOW])
    d_gap = abs(by_x) * at.dx + wrong[0]
    d_rate = (
        abs(by_x) * at.dv
        + abs(v) * (wrong[1] + abs(by_x) * bent)
        + speed * (wrong[2] + abs(by_u) * bent)
    )
    return gap, by_x * v + by_u * speed, d_gap, d_rate


@part
def other_of(charts: Charts, c: int, stop: int) -> int:
    """Place of a stop among the others of a chart."""
    for s in range(charts.stops.shape[1] - rows.OTHERS):
        if charts.stops[c, rows.OTHERS + s] == stop:
            return s
    return -1


@part
def chart_at(charts: Charts, stop: int, travel: float) -> int:
    """The chart of a stop that holds a travel from the start of the turn, or -1."""
    for c in range(len(charts.stops)):
        past = travel - charts.numbers[c, rows.BEGIN]
        length = charts.numbers[c, rows.TRAVEL_MOST]
        if charts.stops[c, rows.OWN] == stop and 0.0 <= past <= length:
            return c
    return -1
