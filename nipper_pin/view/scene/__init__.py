"""A solution seen in the browser: solids, animation, arrows and the page that carries them.

Nothing here is imported by a run that is not looked at. ``page`` needs meshcat, ``gif`` Matplotlib
and pillow; each is imported by those who write such a file.
"""

from .film import Film, Look, film

__all__ = ["Film", "Look", "film"]
