"""Kinematics, constrained dynamics, impacts and forces of a mechanism, on Pinocchio."""

from .assembly import (
    Partition,
    assemble,
    close_positions,
    close_velocities,
    inverses,
    inverted,
    partition,
    weakest,
)
from .complementarity import impact_condition
from .constraint_set import ConstraintSet
from .elements import Elements
from .impact import Impact, closing_impulse, collide, drive_impulses, no_impact
from .multibody import INFINITE_INERTIA, Multibody, multibody
from .shaft import Driven, ShaftMotion
from .system import DriveMode, System, multipliers

__all__ = [
    "INFINITE_INERTIA",
    "ConstraintSet",
    "DriveMode",
    "Driven",
    "Elements",
    "Impact",
    "Multibody",
    "Partition",
    "ShaftMotion",
    "System",
    "assemble",
    "close_positions",
    "close_velocities",
    "closing_impulse",
    "collide",
    "drive_impulses",
    "impact_condition",
    "inverses",
    "inverted",
    "multibody",
    "multipliers",
    "no_impact",
    "partition",
    "weakest",
]
