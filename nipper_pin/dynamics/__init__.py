"""Kinematics, constrained dynamics, impacts and forces of a mechanism, on Pinocchio."""

from .assembly import (
    Partition,
    close_positions,
    close_velocities,
    inverses,
    inverted,
    partition,
    weakest,
)
from .constraint_set import ConstraintSet
from .elements import Elements
from .free_mass import impact_condition
from .impact import Impact, closing_impulse, collide, drive_impulses, no_impact
from .multibody import INFINITE_INERTIA, Multibody, multibody
from .multipliers import multipliers
from .shaft import Driven, ShaftMotion
from .system import DriveMode, System
from .touch import assemble

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
