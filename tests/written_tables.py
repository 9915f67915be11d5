"""Reduced models whose functions are written down, and values of theirs by numpy alone."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from nipper_pin.arrays import FloatArray
from nipper_pin.reduced.kernels import kernel, layout, panel, turn_charts
from nipper_pin.reduced.kernels.layout import Case, Charts, Flown, Settings, Solver
from nipper_pin.reduced.model import Arrival

# Bounces of the waiting stop that are followed on the way to the touch.
_BOUNCES = 64
# Places of functions in x'' = F0 w^2 + F1 w x' + F2 x'^2 + Fg g + k (F4 p + F5).
BY_SPEED, BY_BOTH, BY_RATE, WEIGHT, UNIT, MOVED = range(6)


def tables_of(
    equation: FloatArray,
    *,
    low: float = -0.5,
    high: float = 2.0,
    travel: float = 3.0,
    gaps: FloatArray | None = None,
    inertia: FloatArray | None = None,
    lever: float = 1.0,
    approach: float = -1.0,
    approach_residual: float = 0.0,
    inertia_residual: float = 0.0,
    **bounds: FloatArray,
) -> Charts:
    """One chart of given coefficients, shape (functions, cells, Nu, Nx); no errors, inertia 1.

    Args:
        gaps: Those of other stops, shape (stops, cells, Nu, Nx); their slopes are not written.
        approach: Derivative by u of the gap where the chart is met.
        **bounds: Columns of its bounds, as of ``BOUNDS``.
    """
    functions, cells, count_u, _ = equation.shape
    gaps = np.zeros((0, *equation.shape[1:])) if gaps is None else gaps
    if inertia is None:
        inertia = np.zeros((cells, count_u))
        inertia[:, 0] = 1.0
    numbers = np.zeros(layout.CHART_NUMBERS)
    numbers[[layout.TRAVEL_MOST, layout.PER_RAD]] = travel, cells / travel
    numbers[[layout.LOW, layout.HIGH]] = low, high
    numbers[layout.SCALE] = 2.0 / (high - low)
    numbers[[layout.ARRIVE, layout.ARRIVE_ERROR]] = approach, approach_residual
    numbers[layout.INERTIA_ERROR] = inertia_residual
    stops = np.arange(2 + len(gaps)) - 1
    stops[:2] = 0
    charts = Charts(
        equation=np.ascontiguousarray(np.moveaxis(equation, 0, 2))[None],
        along=along_of(equation, low, high)[None],
        gaps=np.concatenate([gaps, np.zeros((2 * len(gaps), *equation.shape[1:]))])[None],
        inertia=inertia[None],
        bounds=np.zeros((1, functions, layout.SIZES)),
        gap_bounds=np.zeros((1, 3 * len(gaps))),
        numbers=numbers[None],
        beyond=np.empty((1, 0, cells, count_u)),
        stops=stops[None],
        lever=np.full(1 + len(gaps), lever),
    )
    return with_bounds(charts, **bounds)


def along_of(equation: FloatArray, low: float, high: float) -> FloatArray:
    """The same functions along x = 0, shape (cells, functions, Nu)."""
    place = -(low + high) / (high - low)
    line = equation @ chebyshev.chebvander([place], equation.shape[3] - 1)[0]
    return np.ascontiguousarray(np.moveaxis(line, 0, 1))


def functions_of(charts: Charts) -> FloatArray:
    """The functions of the first chart, shape (functions, cells, Nu, Nx)."""
    return np.moveaxis(charts.equation[0], 2, 0)


# Beside the waiting stop the gap of the other is x = y / 2 + 0.01, and grows by the travel.
HALF, ABOVE, BY_TRAVEL = 0.5, 0.01, -0.07


def rest_of_turn(
    equation: FloatArray, travel: float, *, pressed: float = -1.0, high: float = 2.0, **more: Any
) -> Charts:
    """Two charts that follow one another: x is pressed shut, then y moves up to the touch.

    Args:
        equation: That of y, shape (functions, 1, N, N).
        travel: Of the second chart [rad].
        pressed: x'' of the first one, by the square of the speed.
    """
    count, low = equation.shape[3], -0.5
    x = np.zeros((1, 1, count, count))
    x[0, 0, 0, :3] = linear(HALF, low, high)
    x[0, 0, 0, 0] += ABOVE
    second = tables_of(equation, low=low, high=high, travel=travel, gaps=x, **more)
    second.gaps[0, 1:, 0, 0, 0] = HALF, BY_TRAVEL
    closed, wrong = level(pressed, count=count), more.get("approach_residual", 0.0)
    first = tables_of(
        closed, low=low, high=high, travel=math.tau - travel, gaps=x, approach_residual=wrong
    )
    found = Charts(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))
    found.numbers[1, layout.BEGIN] = math.tau - travel
    return found._replace(stops=np.array([[0, 1, 1], [1, 0, 0]]), lever=first.lever)


def solve(
    charts: Charts, cases: FloatArray, settings: Settings, most: int, *, ask: bool = False,
    angle: tuple[float, float] = (0.0, 1.0), before: Any = None,
) -> tuple[Any, Any]:  # fmt: skip
    """What is written of cases, of their transitions or of what is asked of the turn before.

    Args:
        before: What was written of them before.
    """
    n = len(cases)
    table = np.full((n, most + layout.BESIDE, layout.COLUMNS), np.nan)
    told = np.array([[layout.GOES_ON, 0, layout.NOT_ASKED]] * n)
    if before is not None:
        table, told = before if ask else (table, before[1])
        table[:, 0] = before[0][:, 0]
    job = layout.Job(int(layout.TRANSITIONS), most, touch=angle[0], sense=angle[1])
    events = table
    if ask:
        job = layout.Job(int(layout.ARRIVALS), _BOUNCES)
        events = np.empty((1, 2 * _BOUNCES, layout.COLUMNS))
    kernel.run(
        panel.grids(), tuple(charts), cases, tuple(settings), tuple(job), events, told, table
    )
    return table, told


def one_of(charts: Charts, place: int) -> Charts:
    """One chart of a machine, without the cells that pad it."""
    one = Charts(*(array[place : place + 1] for array in charts[:-1]), charts.lever)
    travel, per_rad = one.numbers[0, [layout.TRAVEL_MOST, layout.PER_RAD]]
    cells = round(travel * per_rad)
    equation, gaps = one.equation[:, :cells], one.gaps[:, :, :cells]
    return one._replace(equation=equation, gaps=gaps)


def lowered(arrival: Arrival) -> Arrival:
    """The same with tables of the waiting stop that end just above it."""
    assert arrival.charts is not None
    numbers = arrival.charts.numbers.copy()
    numbers[1, layout.HIGH] = 1e-6
    return replace(arrival, charts=arrival.charts._replace(numbers=numbers))


BOUNDS = {
    "residual": layout.RESIDUAL, "steepest_x": layout.BY_X, "steepest_u": layout.BY_U,
    "largest": layout.BY_V,
}  # fmt: skip


def with_bounds(charts: Charts, **bounds: FloatArray) -> Charts:
    """The same with other bounds."""
    changed = charts.bounds.copy()
    for name, row in bounds.items():
        changed[0, :, BOUNDS[name]] = row
    return charts._replace(bounds=changed)


def with_numbers(charts: Charts, **numbers: float) -> Charts:
    """The same with other numbers, by the names of the layout in lower case."""
    changed = charts.numbers.copy()
    for name, number in numbers.items():
        changed[0, getattr(layout, name.upper())] = number
    return charts._replace(numbers=changed)


def level(*values: float, cells: int = 1, count: int = 3) -> FloatArray:
    """Coefficients of functions that do not change."""
    equation = np.zeros((max(len(values), 6), cells, count, count))
    equation[: len(values), :, 0, 0] = np.array(values)[:, None]
    return equation


def linear(x: float, low: float, high: float) -> FloatArray:
    """Coefficients in x of the function x times a factor, three of them."""
    return np.array([0.5 * x * (low + high), 0.5 * x * (high - low), 0.0])


def value(charts: Charts, table: FloatArray, u: float, x: float) -> float:
    """One function, shape (cells, Nu, Nx), at a point."""
    travel, low, high = charts.numbers[0, [layout.TRAVEL_MOST, layout.LOW, layout.HIGH]]
    width = travel / len(table)
    cell = min(max(math.floor(u / width), 0), len(table) - 1)
    place = (u - cell * width) / width * 2.0 - 1.0
    across = (x - low) / (high - low) * 2.0 - 1.0
    return float(chebyshev.chebval2d(place, across, table[cell]))


def x_dd(charts: Charts, u: float, x: float, v: float, w: float, springs: Any) -> float:
    """x'' as the model's docstring writes it; springs are pairs (k, p)."""
    f = [value(charts, table, u, x) for table in functions_of(charts)]
    total = f[0] * w**2 + f[1] * w * v + f[2] * v**2 + f[3]
    for number, (k, p) in enumerate(springs):
        total += k * (f[4 + 2 * number] * p + f[5 + 2 * number])
    return total


def bounded(charts: Charts) -> Charts:
    """The same with the largest values and slopes of their functions, on a fine grid."""
    place = np.linspace(-1.0, 1.0, 41)
    grid = np.array(np.meshgrid(place, place)).reshape(2, -1)
    travel, low, high = charts.numbers[0, [layout.TRAVEL_MOST, layout.LOW, layout.HIGH]]
    cells = charts.equation.shape[1]

    def most(change: Any) -> FloatArray:
        return np.array([
            max(np.abs(chebyshev.chebval2d(*grid, change(cell))).max() for cell in table)
            for table in functions_of(charts)
        ])  # fmt: skip

    return with_bounds(
        charts,
        largest=most(lambda cell: cell),
        steepest_u=most(lambda cell: chebyshev.chebder(cell, axis=0)) * 2.0 * cells / travel,
        steepest_x=most(lambda cell: chebyshev.chebder(cell, axis=1)) * (2.0 / (high - low)),
    )


def case(speed: float, stiffness: Any, preload: Any, e_N: float = 0.0) -> Case:
    """Numbers of a case with one restitution for all stops."""
    return Case(speed, np.full(4, e_N), np.array(stiffness), np.array(preload))


def bounce(
    T: float, v: float, a: float, peak: float, fastest: float, changed: float = 0.0,
    left: float = 0.0,
) -> Flown:  # fmt: skip
    """A flight that ends at its own stop, as of :class:`Flown`."""
    return Flown(int(layout.AT_REST), T, v, 0.0, peak, a, fastest, changed, left, 0.0, -1, False)


def solver_of(charts: Charts, one: Case, *, most: int = 8) -> Solver:
    """What motions of a case are computed with, its first chart combined.

    Scratch arrays are filled with what no result may contain.
    """
    work = turn_charts.scratch(charts, most)
    for array in (work.sizes, work.mixed, work.line, work.poly, work.nodes, work.series):
        array.fill(np.nan)
    records = turn_charts.records_in(np.full((most, layout.COLUMNS), np.nan), 1, 0)
    solver = Solver(panel.grids(), charts, work, one, records)
    turn_charts.prepare(solver, True)
    panel.reach(solver, 0, 0.0, charts.numbers[0, layout.TRAVEL_MOST])
    return solver
