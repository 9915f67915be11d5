"""Panels of a motion that are kept while it is computed, compiled.

Each has a block of rows below the scratch rows of the nodes: its series, as ``position`` and
``rate_at`` read them, and in the row KEPT its numbers. A stretch at rest is a panel without nodes.
In the first block the row KEPT begins with the number of panels that are kept.

The numbers of a panel: its chart, travel at its begin, length [s], part of it that is covered, x
and x' at its begin, nodes (0: at rest), bounds on the errors of time, x, x' and x'', and 1 if
bounces that are not computed come before it.
"""

from __future__ import annotations

from ...arrays import FloatArray
from .compiled import compiled
from .flight_errors import size
from .hits import Held
from .layout import (
    BY_U,
    BY_V,
    BY_X,
    KEPT,
    RESIDUAL,
    SCRATCH_ROWS,
    SERIES,
    SERIES_ONCE,
    SERIES_TWICE,
)

(
    CHART, FROM, LENGTH, COVERED, X_BEGIN, V_BEGIN, NODES, T_WRONG, X_WRONG, V_WRONG, A_WRONG,
    BOUNCED,
) = range(12)  # fmt: skip


@compiled
def keep(held: Held, covered: float) -> None:
    """Keep a panel of a flight up to a part of it, if panels are kept and there is room."""
    nodes = held.nodes
    first = _next_block(nodes)
    if first + SCRATCH_ROWS > nodes.shape[0]:
        return
    for row in (SERIES, SERIES_ONCE, SERIES_TWICE):
        for i in range(held.order + 2):
            nodes[first + row, i] = nodes[row, i]
    numbers = nodes[first + KEPT]
    numbers[FROM], numbers[LENGTH], numbers[COVERED] = held.u, held.h, covered
    numbers[X_BEGIN], numbers[V_BEGIN], numbers[NODES] = held.x0, held.v0, float(held.order)
    numbers[BOUNCED] = 0.0


@compiled
def keep_rest(nodes: FloatArray, chart: int, u: float, end: float, speed: float, late: float,
              bounced: bool) -> None:  # fmt: skip
    """Keep a stretch at rest between two travels of a chart; ``late`` bounds the errors of both."""
    first = _next_block(nodes)
    if first + SCRATCH_ROWS > nodes.shape[0]:
        return
    numbers = nodes[first + KEPT]
    numbers[CHART], numbers[FROM], numbers[LENGTH] = float(chart), u, (end - u) / speed
    numbers[COVERED], numbers[X_BEGIN], numbers[V_BEGIN], numbers[NODES] = 1.0, 0.0, 0.0, 0.0
    numbers[T_WRONG], numbers[X_WRONG], numbers[V_WRONG], numbers[A_WRONG] = late, 0.0, 0.0, 0.0
    numbers[BOUNCED] = 1.0 if bounced else 0.0


@compiled
def describe(nodes: FloatArray, before: int, chart: int, sizes: FloatArray,
             motion: tuple[float, float, float, float, float, float],
             wrong: tuple[float, float, float]) -> None:  # fmt: skip
    """Give the panels of a flight, those after the first ``before``, chart and errors.

    Args:
        nodes: The scratch rows, with the panels that are kept.
        before: Panels that were kept before the flight.
        sizes: Bounds of the case as polynomials of the rate.
        motion: Cylinder speed, time of the flight, fastest rate, last change and steady error of
            x'', and error of the time at its start.
        wrong: Bounds on the errors of time, x and x' along it.
    """
    if nodes.shape[0] == SCRATCH_ROWS:
        return
    speed, T, fastest, changed, left, dt = motion
    late, dx, dv = wrong
    by_v, by_x = size(sizes, BY_V, fastest), size(sizes, BY_X, fastest)
    felt = min(by_v * T + 0.5 * by_x * T * T, 1.0)
    da = size(sizes, RESIDUAL, fastest) + by_x * dx + by_v * dv + felt * changed + left
    da += speed * size(sizes, BY_U, fastest) * dt
    for number in range(before, kept(nodes)):
        numbers = nodes[(1 + number) * SCRATCH_ROWS + KEPT]
        numbers[CHART], numbers[T_WRONG] = float(chart), late
        numbers[X_WRONG], numbers[V_WRONG], numbers[A_WRONG] = dx, dv, da


@compiled
def kept(nodes: FloatArray) -> int:
    """Number of panels that are kept."""
    return int(nodes[KEPT, 0])


@compiled
def full(nodes: FloatArray) -> bool:
    """Whether panels are kept, and one more may not find room."""
    return nodes.shape[0] > SCRATCH_ROWS and len(nodes) < (kept(nodes) + 2) * SCRATCH_ROWS


@compiled
def _next_block(nodes: FloatArray) -> int:
    """First row of the next block, which counts as kept from now on if there is room for it."""
    first = (1 + kept(nodes)) * SCRATCH_ROWS
    if first + SCRATCH_ROWS <= nodes.shape[0]:
        nodes[KEPT, 0] += 1.0
    return first
