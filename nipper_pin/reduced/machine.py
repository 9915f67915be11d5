"""What the compiled code is given: grids, tables and scratch arrays."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..arrays import FloatArray
from ..hybrid.collocation import nodes, prolonged
from .layout import (
    CASE_NUMBERS,
    DOUBLE,
    INTEGRAL,
    LEVELS,
    ONCE,
    REFINE,
    SCRATCH_ROWS,
    SIGMA,
    TWICE,
    VALUE,
    Tables,
    Work,
)
from .model import ReducedModel


@cache
def grids() -> FloatArray:
    """Nested collocation grids with the operators of the direct engine, padded to the finest one.

    Returns:
        Shape (operators, levels, N, N + 2); see the names in the kernel.
    """
    finest = LEVELS[-1]
    found = np.zeros((SIGMA + 1, len(LEVELS), finest, finest + 2))
    for level, count in enumerate(LEVELS):
        grid = nodes(count)
        found[SIGMA, level, 0, :count] = grid.sigma
        operators = [(ONCE, grid.once), (TWICE, grid.twice)]
        operators += zip((VALUE, INTEGRAL, DOUBLE), grid.integrals, strict=True)
        if level:
            operators.append((REFINE, prolonged(np.eye(LEVELS[level - 1]), count)))
        for kind, operator in operators:
            to, start = operator.shape
            found[kind, level, :start, :to] = operator.T
    return found


def tables(model: ReducedModel) -> Tables:
    """Arrays of a model."""
    return Tables(
        equation=np.ascontiguousarray(model.equation),
        gaps=np.ascontiguousarray(model.gaps),
        inertia=np.ascontiguousarray(model.inertia),
        residual=model.residual,
        largest=model.largest,
        steepest_x=model.steepest_x,
        steepest_u=model.steepest_u,
        travel=float(model.travel_rad),
        low=float(model.gap_low),
        high=float(model.gap_max),
        approach=float(model.approach_rate),
        inertia_residual=float(model.inertia_residual),
    )


def work(model: ReducedModel, most_collisions: int) -> Work:
    """Scratch arrays for one batch."""
    count_u, count_x = model.degrees
    rows = (3 + len(model.other_stops)) * count_x
    finest = LEVELS[-1]
    return Work(
        case=np.zeros(CASE_NUMBERS),
        mixed=np.zeros((model.cells, count_u, rows)),
        poly=np.zeros((finest + 1, rows)),
        nodes=np.zeros((SCRATCH_ROWS, finest + 2)),
        series=np.zeros((3, most_collisions)),
    )
