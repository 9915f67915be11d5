"""Force elements on a joint whose force is any function of its coordinate and rate.

Each module has a law and the table of the model file that it is built from. A new one is a module
here and a name in :data:`.registry.BuiltInForce`, or a class in a user's own program that
:func:`register_force` makes known.
"""

from .law import ForceLaw, ForceTable, JointForce
from .orifice import Orifice, OrificeForce
from .registry import FORCES, BuiltInForce, register_force

__all__ = [
    "FORCES",
    "BuiltInForce",
    "ForceLaw",
    "ForceTable",
    "JointForce",
    "Orifice",
    "OrificeForce",
    "register_force",
]
