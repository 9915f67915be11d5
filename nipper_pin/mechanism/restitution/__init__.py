"""Laws of restitution that depend on the rate of approach.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program that
`register_restitution` makes known.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..files.register import RESTITUTIONS
    from .falling import Falling, FallingRestitution
    from .law import RestitutionLaw
    from .tables import RestitutionTable

    register_restitution = RESTITUTIONS.add
else:
    # The tables import the parser of model files, which a built mechanism does not need.
    _PLACES = {
        "falling": ("Falling", "FallingRestitution"),
        "law": ("RestitutionLaw",),
        "tables": ("RestitutionTable",),
    }
    _PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}

    def __getattr__(name: str) -> object:
        """Import the module of a public name at its first use."""
        if name == "register_restitution":
            return import_module("..files.register", __name__).RESTITUTIONS.add
        if name not in _PLACE_OF:
            message = f"module {__name__!r} has no attribute {name!r}"
            raise AttributeError(message)
        value = getattr(import_module(f".{_PLACE_OF[name]}", __name__), name)
        globals()[name] = value
        return value


__all__ = [
    "Falling",
    "FallingRestitution",
    "RestitutionLaw",
    "RestitutionTable",
    "register_restitution",
]
