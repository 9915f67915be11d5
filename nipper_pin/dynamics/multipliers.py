"""Forces of constraint: closures, closed stops and drives, by inverse dynamics."""

from __future__ import annotations

from dataclasses import dataclass

from ..arrays import FloatArray, Jacobians, Vectors
from .assembly import Partition, inverses, products
from .constraint_set import ConstraintSet
from .shaft import Driven
from .system import System


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Forces of constraint of N states.

    Attributes:
        la_g: Closure forces on the body of each closure's frame a, in that frame's axes,
            shape (N, m) [N].
        la_N: Forces of the closed stops along their gaps, positive when they push,
            shape (N, closed) [N m or N], in the order of ``ConstraintSet.stops``.
        drive: Torques on the driven joints, shape (N, drives) [N m]; those of the elastic trains
            where the shafts may change their speed.
    """

    la_g: FloatArray
    la_N: FloatArray
    drive: FloatArray


def multipliers(
    system: System,
    motion: Driven,
    q: Vectors,
    v: Vectors,
    a: Vectors,
    jacobian: Jacobians,
    phase: ConstraintSet,
    split: Partition,
    inverse: FloatArray | None = None,
) -> Multipliers:
    """Solve M a + h = tau + G' la_g + W' la_N for the forces of constraint.

    The rows of the dependent coordinates, on which only known forces act, determine la_g; the rows
    of stops and held drives then give their forces. The torque of an elastic drive train is known,
    and the inertia of its shaft stands beside that of the links.

    Args:
        split: Dependent and independent coordinates; no given one may be dependent.
        inverse: What :func:`inverses` gives for them, where it is known already.
    """
    missing = system.body.inverse_dynamics(q, v, a) - system.applied_forces(q, v)
    trains = 0.0 if system.held else system.train_torques(motion, q, v)
    if not system.held:
        missing[:, system.driven_columns] += system.inertia * a[:, system.driven_columns] - trains
    if inverse is None:
        inverse = inverses(jacobian, split)
    la_g = products(inverse.transpose(0, 2, 1), missing.take(split.columns, 1))
    rest = missing - products(jacobian.transpose(0, 2, 1), la_g)
    drive = rest[:, system.driven_columns] + trains
    return Multipliers(la_g, rest[:, phase.columns] * phase.senses, drive)
