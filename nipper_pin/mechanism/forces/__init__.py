"""Force elements on a joint whose force is any function of its coordinate and rate.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program that `register_force` makes known.
"""

from typing import TYPE_CHECKING

from ...first_use import at_first_use

if TYPE_CHECKING:
    from ..files.register import register_force
    from .law import ForceLaw, JointForce
    from .orifice import Orifice, OrificeForce
    from .tables import ForceTable
else:
    # The tables import the parser of model files, which a built mechanism does not need.
    _PLACES = {
        ".files.register": ("register_force",),
        "law": ("ForceLaw", "JointForce"),
        "orifice": ("Orifice", "OrificeForce"),
        "tables": ("ForceTable",),
    }
    __getattr__ = at_first_use(__name__, _PLACES)


__all__ = [
    "ForceLaw",
    "ForceTable",
    "JointForce",
    "Orifice",
    "OrificeForce",
    "register_force",
]
