"""Reduced models whose functions are written down, and values of theirs by numpy alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from nipper_pin.arrays import FloatArray
from nipper_pin.reduced.kernels.layout import (
    CASE_NUMBERS,
    LEVELS,
    SCRATCH_ROWS,
    SIZES,
    Tables,
    Turn,
    Work,
)

# Places of functions in x'' = F0 w^2 + F1 w x' + F2 x'^2 + Fg g + k (F4 p + F5).
BY_SPEED, BY_BOTH, BY_RATE, WEIGHT, UNIT, MOVED = range(6)


def tables_of(
    equation: FloatArray, *, low: float = -0.5, high: float = 2.0, travel: float = 3.0, **more: Any
) -> Tables:
    """Tables of given coefficients, shape (functions, cells, Nu, Nx); no errors, inertia 1."""
    functions, cells, count_u, _ = equation.shape
    inertia = np.zeros((cells, count_u))
    inertia[:, 0] = 1.0
    values: dict[str, Any] = {
        "equation": equation,
        "gaps": np.zeros((0, *equation.shape[1:])),
        "inertia": inertia,
        **{name: np.zeros(functions) for name in ("residual", "largest")},
        **{name: np.zeros(functions) for name in ("steepest_x", "steepest_u")},
        "travel": travel,
        "low": low,
        "high": high,
        "inertia_residual": 0.0,
        "approach": -1.0,
    }
    return Tables(**{**values, **more})


def level(*values: float, cells: int = 1, count: int = 3) -> FloatArray:
    """Coefficients of functions that do not change."""
    equation = np.zeros((max(len(values), 6), cells, count, count))
    equation[: len(values), :, 0, 0] = np.array(values)[:, None]
    return equation


def linear(x: float, low: float, high: float) -> FloatArray:
    """Coefficients in x of the function x times a factor, three of them."""
    return np.array([0.5 * x * (low + high), 0.5 * x * (high - low), 0.0])


def value(tables: Tables, table: FloatArray, u: float, x: float) -> float:
    """One function, shape (cells, Nu, Nx), at a point."""
    width = tables.travel / len(table)
    cell = min(max(math.floor(u / width), 0), len(table) - 1)
    place = (u - cell * width) / width * 2.0 - 1.0
    across = (x - tables.low) / (tables.high - tables.low) * 2.0 - 1.0
    return float(chebyshev.chebval2d(place, across, table[cell]))


def x_dd(
    tables: Tables, u: float, x: float, v: float, w: float, gravity: float, springs: Any
) -> float:
    """x'' as the model's docstring writes it; springs are pairs (k, p)."""
    f = [value(tables, table, u, x) for table in tables.equation]
    total = f[0] * w**2 + f[1] * w * v + f[2] * v**2 + f[3] * gravity
    for number, (k, p) in enumerate(springs):
        total += k * (f[4 + 2 * number] * p + f[5 + 2 * number])
    return total


def bounded(tables: Tables) -> Tables:
    """The same with the largest values and slopes of their functions, on a fine grid."""
    place = np.linspace(-1.0, 1.0, 41)
    grid = np.array(np.meshgrid(place, place)).reshape(2, -1)
    cells = tables.equation.shape[1]

    def most(change: Any) -> FloatArray:
        return np.array([
            max(np.abs(chebyshev.chebval2d(*grid, change(cell))).max() for cell in table)
            for table in tables.equation
        ])  # fmt: skip

    return tables._replace(
        largest=most(lambda cell: cell),
        steepest_u=most(lambda cell: chebyshev.chebder(cell, axis=0)) * 2.0 * cells / tables.travel,
        steepest_x=most(lambda cell: chebyshev.chebder(cell, axis=1))
        * (2.0 / (tables.high - tables.low)),
    )


def work_of(tables: Tables, *, most: int = 8, line: tuple[int, int] = (1, 2)) -> Work:
    """Scratch arrays, filled with what no result may contain."""
    _, cells, count_u, count_x = tables.equation.shape
    rows = (3 + len(tables.gaps)) * count_x
    finest = LEVELS[-1]
    shapes = (
        (CASE_NUMBERS,), (cells, count_u, rows), (finest + 1, rows), (SCRATCH_ROWS, finest + 2),
        (3, most), (SIZES, 3), line,
    )  # fmt: skip
    work = Work(*(np.full(shape, np.nan) for shape in shapes))
    # A rate has no bound by its square: that number is never written.
    work.sizes[:] = 0.0
    return work


def turn_of(**values: Any) -> Turn:
    """The rest of a turn, of which all is known that is given."""
    none = np.zeros((6, 1, 2))
    written = Turn(0.0, 0.0, none, none, np.zeros(6), np.zeros((3, 2)), np.zeros(3))
    return written._replace(**values)
