"""Force elements on a joint whose force is any function of its coordinate and rate.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program that `register_force` makes known.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..files.register import FORCES
    from .law import ForceLaw, JointForce
    from .orifice import Orifice, OrificeForce
    from .tables import ForceTable

    register_force = FORCES.add
else:
    # The tables import the parser of model files, which a built mechanism does not need.
    _PLACES = {
        "law": ("ForceLaw", "JointForce"),
        "orifice": ("Orifice", "OrificeForce"),
        "tables": ("ForceTable",),
    }
    _PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}

    def __getattr__(name: str) -> object:
        """Import the module of a public name at its first use."""
        if name == "register_force":
            return import_module("..files.register", __name__).FORCES.add
        if name not in _PLACE_OF:
            message = f"module {__name__!r} has no attribute {name!r}"
            raise AttributeError(message)
        value = getattr(import_module(f".{_PLACE_OF[name]}", __name__), name)
        globals()[name] = value
        return value


__all__ = [
    "ForceLaw",
    "ForceTable",
    "JointForce",
    "Orifice",
    "OrificeForce",
    "register_force",
]
