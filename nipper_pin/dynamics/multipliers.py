"""Forces of constraint: closures, closed stops and drives, by inverse dynamics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from .assembly import Partition
from .system import ConstraintSet, System


@dataclass(frozen=True)
class Multipliers:
    """Forces of constraint of N states.

    Attributes:
        la_g: Closure forces on the body of each closure's frame a, in that frame's axes,
            shape (N, m) [N].
        la_N: Forces of the closed stops along their gaps, positive when they push,
            shape (N, closed) [N m or N], in the order of ``ConstraintSet.stops``.
        drive: Torques on the driven joints, shape (N, drives) [N m]. A shaft that is free to
            change its speed has its own inertia beside that of the links.
    """

    la_g: FloatArray
    la_N: FloatArray
    drive: FloatArray


def multipliers(
    system: System,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    jacobian: FloatArray,
    rows: ConstraintSet,
    split: Partition,
) -> Multipliers:
    """Solve M a + h = tau + G' la_g + W' la_N for the forces of constraint.

    The rows of the dependent coordinates, on which only springs and dampers act, determine la_g;
    the rows of stops and drives then give their forces.

    Args:
        system: The system.
        q: Configurations, shape (N, nv).
        v: Velocities, shape (N, nv).
        a: Accelerations, shape (N, nv).
        jacobian: Closure Jacobian G, shape (N, m, nv).
        rows: The phase.
        split: Dependent and independent coordinates; no given one may be dependent.
    """
    missing = system.body.inverse_dynamics(q, v, a) - system.applied_forces(q, v)
    dependent = list(split.dependent)
    transposed = np.swapaxes(jacobian[:, :, dependent], 1, 2)
    la_g: FloatArray = np.asarray(
        np.linalg.solve(transposed, missing[:, dependent, None])[:, :, 0], dtype=np.float64
    )
    rest = missing - np.einsum("nij,ni->nj", jacobian, la_g)
    drive = rest[:, system.driven]
    if not system.held:
        drive = drive + system.inertia * a[:, system.driven]
    return Multipliers(la_g, rest[:, list(rows.stops)] * rows.senses, drive)
