"""A solution seen in the browser: solids, animation, arrows and the page that carries them.

A run that is not shown imports nothing of this. ``page`` needs meshcat, ``gif`` Matplotlib
and pillow; each is imported where such a file is written.
"""

from .film import Film, Look, film
from .solids import CYLINDER, FIXED, Colour, Solid, cylinder_axis, pictured, solids

__all__ = [
    "CYLINDER",
    "FIXED",
    "Colour",
    "Film",
    "Look",
    "Solid",
    "cylinder_axis",
    "film",
    "pictured",
    "solids",
]
