"""Unilateral contacts as linear complementarity problems, solved by pivoting.

xi = A P + b >= 0, P >= 0, xi P = 0, with the Delassus matrix A = W' M^-1 W of the motions that
closures and held drives leave. Work grows with the cube of the number of stops.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Jacobian, Vector
from ..mechanism import Stop
from ..tolerances.mechanics import DEPENDENT_PIVOT, EQUAL_RATIO, RANK_TOLERANCE
from .free_mass import free_mass_matrix, inverse_mass_roots
from .system import System

# Pivots for each stop at which a search ends; the usual number is one or two.
_ROUNDS = 50


def delassus(system: System, q: Vector, jacobian: Jacobian, stops: Sequence[Stop]) -> FloatArray:
    """Rates of the gaps of stops by the impulses at them, A, shape (stops, stops).

    Args:
        system: The system; held drives do not yield.
        stops: The stops. Rows of those that closures and drives do not let move are zero.

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
    """
    columns = [stop.index for stop in stops]
    split = system.split(jacobian, system.held_coordinates, tuple(columns))
    moving, mass = free_mass_matrix(system, q)
    free = [index for index in split.independent if index in moving]
    if not free:
        return np.zeros((len(stops), len(stops)))
    motions = system.lift(jacobian, split, np.eye(system.body.nv)[free])
    rows = motions[:, columns] * [stop.sense for stop in stops]
    within = motions[:, moving]
    matrix: FloatArray = rows.T @ np.linalg.solve(within @ mass @ within.T, rows)
    alone = inverse_mass_roots(system, q, columns) ** 2
    fixed = np.diag(matrix) <= RANK_TOLERANCE**2 * alone
    matrix[fixed] = 0.0
    matrix[:, fixed] = 0.0
    return matrix


def complementary(matrix: FloatArray, offset: FloatArray) -> FloatArray | None:
    """Impulses P >= 0 with A P + b >= 0 and a product of zero; of dependent stops a few carry all.

    Args:
        matrix: A, symmetric and without a negative eigenvalue, shape (n, n).
        offset: b, shape (n,).

    Returns:
        P, shape (n,); None if there are none.
    """
    found = np.zeros(len(offset))
    if offset.min(initial=0.0) >= 0.0:
        return found
    size = np.sqrt(np.diag(matrix))
    able = size > 0.0
    if offset[~able].min(initial=0.0) < 0.0:
        return None
    size = size[able]
    scaled = offset[able] / size
    largest = float(np.abs(scaled).max())
    chosen = _basis(matrix[np.ix_(able, able)] / size / size[:, None], scaled / largest)
    if chosen is None:
        return None
    places = np.flatnonzero(able)[chosen]
    found[places] = np.linalg.solve(matrix[np.ix_(places, places)], -offset[places])
    return found


def independent(matrix: FloatArray, carrying: Sequence[int], other: int) -> bool:
    """Whether one more stop can carry a force of its own beside others.

    Args:
        matrix: A, shape (n, n).
        carrying: Places of stops that do not depend on one another.
        other: Place of another one.
    """
    across = matrix[other, carrying]
    inner = matrix[np.ix_(carrying, carrying)]
    left = matrix[other, other] - across @ np.linalg.solve(inner, across)
    return bool(left > DEPENDENT_PIVOT * matrix[other, other])


def _basis(matrix: FloatArray, offset: FloatArray) -> list[int] | None:
    """Stops that carry, by Lemke's method; None if none do.

    Columns of the table: slacks, impulses, the artificial one, right side. Ties are broken by the
    columns of the slacks, the inverse of the basis, so that no basis comes twice.
    """
    count = len(offset)
    table = np.hstack([np.eye(count), -matrix, -np.ones((count, 1)), offset[:, None]])
    artificial, basis = 2 * count, list(range(count))
    entering, row = artificial, _first(table, np.arange(count), np.ones(count))
    for _ in range(_ROUNDS * count):
        table[row] /= table[row, entering]
        others = np.arange(count) != row
        table[others] -= np.outer(table[others, entering], table[row])
        leaving, basis[row] = basis[row], entering
        if leaving == artificial:
            return _carrying(basis)
        entering = leaving + count if leaving < count else leaving - count
        column = table[:, entering]
        able = np.flatnonzero(column > DEPENDENT_PIVOT)
        last = basis.index(artificial)
        if not able.size:
            # Of dependent stops round-off may be left of what is no longer needed.
            return _carrying(basis) if table[last, -1] <= DEPENDENT_PIVOT else None
        row = _first(table, able, column[able], preferred=last)
    return None


def _carrying(basis: Sequence[int]) -> list[int]:
    """Numbers of the stops whose impulses are in a basis."""
    count = len(basis)
    return sorted(number - count for number in basis if count <= number < 2 * count)


def _first(
    table: FloatArray, rows: NDArray[np.intp], pivots: FloatArray, preferred: int = -1
) -> int:
    """Row whose variable is the first to reach zero; of equal ones the preferred row."""
    count = len(table)
    for column in (-1, *range(count)):
        ratios = table[rows, column] / pivots
        least = ratios.min()
        keep = ratios <= least + EQUAL_RATIO * max(abs(least), 1.0)
        rows, pivots = rows[keep], pivots[keep]
        if preferred in rows:
            return preferred
        if len(rows) == 1:
            break
    return int(rows[0])
