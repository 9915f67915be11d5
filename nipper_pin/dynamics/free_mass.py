"""How coordinates answer impulses and forces: sizes that make those of any unit comparable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, Jacobian, Vector
from ..errors import ImpactError
from .shaft import Driven
from .system import System


def impact_condition(system: System, q: Vector, jacobian: Jacobian, stops: Sequence[int]) -> float:
    """Condition number of the impact matrix A = J M^-1 J', J being closures and closed stops.

    Rows and columns are scaled to a diagonal of ones, so units do not count. Accelerations,
    impulses and forces of constraint lose that many digits: A is singular where the closures are,
    and badly conditioned where bodies of very different mass pull at one another.

    Args:
        system: The system; held drives do not yield.
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

    Args:
        system: The system; held drives do not yield.

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

    Args:
        system: The system; held drives do not yield.

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
    """Size of the forces that balance in a part, the root of f' M^-1 f of each kind, added up.

    Times the root of a diagonal term of M^-1 or of M it bounds what they come to in an
    acceleration or a force of that coordinate: round-off is a small part of that.

    Args:
        motion: Driven coordinates at this time, as one row.
        index: A coordinate of the part.
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
