"""A solution seen in the browser: solids, animation, arrows and the page that carries them.

A run that is not shown imports nothing of this. ``page`` needs meshcat, ``gif`` Matplotlib
and pillow; each is imported where such a file is written.
"""

from .film import Film, Look, film
from .solids import CYLINDER, FIXED, Solid, pictured, solids

__all__ = [
    "CYLINDER",
    "FIXED",
    "Film",
    "Look",
    "Solid",
    "film",
    "pictured",
    "solids",
]
