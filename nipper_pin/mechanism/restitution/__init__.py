"""Laws of restitution that depend on the rate of approach.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program that
`register_restitution` makes known.
"""

from ..files.law_tables import RestitutionTable
from ..files.register import register_restitution
from ..laws import RestitutionLaw
from .falling import Falling

__all__ = [
    "Falling",
    "RestitutionLaw",
    "RestitutionTable",
    "register_restitution",
]
