"""Force elements on a joint whose force is any function of its coordinate and rate.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program that `register_force` makes known.
"""

from ..files.law_tables import ForceTable
from ..files.register import register_force
from ..laws import ForceLaw, JointForce

__all__ = [
    "ForceLaw",
    "ForceTable",
    "JointForce",
    "register_force",
]
