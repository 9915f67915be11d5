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
from .impact import Impact, arrest, collide, drive_impulses, no_impact
from .multibody import INFINITE_INERTIA, Multibody
from .shaft import Driven, ShaftMotion
from .system import DriveMode, System

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
    "arrest",
    "close_positions",
    "close_velocities",
    "collide",
    "drive_impulses",
    "inverses",
    "inverted",
    "no_impact",
    "partition",
    "weakest",
]
