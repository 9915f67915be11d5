"""How coordinates answer impulses, and which unilateral contacts push: pivoting finds it.

xi = A P + b >= 0, P >= 0, xi P = 0, with the Delassus matrix A = W' M^-1 W of the motions that
closures and held drives leave: these do not yield. Work grows with the cube of the number of stops.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Jacobian, Vector
from ..errors import ImpactError
from ..mechanism import Stop
from ..tolerances.mechanics import DEPENDENT_PIVOT, EQUAL_RATIO, RANK_TOLERANCE
from .shaft import Driven
from .system import System


def impact_condition(system: System, q: Vector, jacobian: Jacobian, stops: Sequence[int]) -> float:
    """Condition number of the impact matrix A = J M^-1 J', J being closures and closed stops.

    Rows and columns are scaled to a diagonal of ones, so units do not count. Accelerations,
    impulses and forces of constraint lose that many digits: A is singular where the closures are,
    and badly conditioned where bodies of very different mass pull at one another.

    Args:
        stops: Coordinates of the closed stops; with any, the matrix is that of their parts.

    Returns:
        The condition number in the 2-norm; infinite if rows depend on one another, or the mass
        matrix is singular.
    """
    moving, mass = free_mass_matrix(system, q)
    rows = np.vstack([jacobian, np.eye(system.body.nv)[list(stops)]])[:, moving]
    if stops:
        # What other parts are is nothing to them.
        own = np.isin(system.parts[moving], system.parts[list(stops)])
        rows, mass = rows[rows[:, own].any(axis=1)][:, own], mass[np.ix_(own, own)]
    if not len(rows):
        return 1.0
    try:
        matrix = rows @ np.linalg.solve(mass, rows.T)
    except np.linalg.LinAlgError:
        return np.inf
    diagonal = np.diag(matrix)
    if not (diagonal > 0.0).all():
        # Round-off of a mass matrix that is singular in double precision has either sign.
        return np.inf
    size = np.sqrt(diagonal)
    return float(np.linalg.cond(matrix / size / size[:, None]))


def inverse_mass_roots(system: System, q: Vector, stops: Sequence[int]) -> FloatArray:
    """Roots of the diagonal of M^-1 at stops, shape (stops,): they make impulses comparable.

    An impulse times this is the root of twice the energy that it gives to a machine at rest whose
    loops are open [sqrt(J)], whatever the unit of the coordinate is.

    Raises:
        ImpactError: The mass matrix is singular.
    """
    moving, mass = free_mass_matrix(system, q)
    rows = np.eye(system.body.nv)[list(stops)][:, moving]
    try:
        diagonal = np.einsum("ij,ji->i", rows, np.linalg.solve(mass, rows.T))
    except np.linalg.LinAlgError as error:
        message = "the mass matrix is singular: masses or inertias of the links are too different"
        raise ImpactError(message, condition=np.inf) from error
    return np.asarray(np.sqrt(np.maximum(diagonal, 0.0)))


def free_mass_matrix(system: System, q: Vector) -> tuple[list[int], FloatArray]:
    """Coordinates that impulses move, and their mass matrix with the inertia of the shafts.

    Returns:
        Their numbers, and the matrix, shape (moving, moving).
    """
    moving = [i for i in range(system.body.nv) if i not in system.held_coordinates]
    mass = system.body.mass_matrix(q)[np.ix_(moving, moving)]
    if not system.held:
        mass[np.diag_indices(len(moving))] += system.drive_armature[moving]
    return moving, mass


def force_size(
    system: System, motion: Driven, q: Vector, v: Vector, a: Vector, index: int
) -> float:
    """Size of forces that balance in a coordinate's part: roots of f' M^-1 f of each kind, summed.

    Times the root of a diagonal term of M^-1 or of M it bounds what they come to in an
    acceleration or a force of that coordinate: round-off is a small part of that.

    Args:
        motion: Driven coordinates at this time, as one row.
    """
    moving, mass = free_mass_matrix(system, q)
    weight, whole = system.body.inverse_dynamics(*np.array([[q, q], [v, v], [0.0 * a, a]]))
    kinds = [weight, whole - weight, system.applied_forces(q[None], v[None])[0]]
    if not system.held:
        trains = np.zeros(system.body.nv)
        trains[system.driven_columns] = system.train_torques(motion, q[None], v[None])[0]
        kinds.append(trains)
    own = np.flatnonzero(system.parts[moving] == system.parts[index])
    forces = np.array(kinds)[:, moving].T[own]
    squares = np.einsum("ij,ij->j", forces, np.linalg.solve(mass[np.ix_(own, own)], forces))
    return float(np.sqrt(np.maximum(squares, 0.0)).sum())


# Pivots for each stop at which a search ends; the usual number is one or two.
_ROUNDS = 50


def delassus(system: System, q: Vector, jacobian: Jacobian, stops: Sequence[Stop]) -> FloatArray:
    """Rates of the gaps of stops by the impulses at them, A, shape (stops, stops).

    Rows of stops that closures and drives do not let move are zero.

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
