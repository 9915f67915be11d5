"""Laws of restitution that depend on the rate of approach.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program that
`register_restitution` makes known.
"""

from typing import TYPE_CHECKING

from ...first_use import at_first_use

if TYPE_CHECKING:
    from ..files.register import register_restitution
    from .falling import Falling, FallingRestitution
    from .law import RestitutionLaw
    from .tables import RestitutionTable
else:
    # The tables import the parser of model files, which a built mechanism does not need.
    _PLACES = {
        ".files.register": ("register_restitution",),
        "falling": ("Falling", "FallingRestitution"),
        "law": ("RestitutionLaw",),
        "tables": ("RestitutionTable",),
    }
    __getattr__ = at_first_use(__name__, _PLACES)


__all__ = [
    "Falling",
    "FallingRestitution",
    "RestitutionLaw",
    "RestitutionTable",
    "register_restitution",
]
