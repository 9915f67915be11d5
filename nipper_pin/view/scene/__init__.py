"""A solution seen in the browser: solids, animation, arrows and the page that carries them.

Nothing here is imported by a run that is not looked at.
"""

from .film import Film, Look, film
from .page import scene_page, write_page
from .server import serve

__all__ = ["Film", "Look", "film", "scene_page", "serve", "write_page"]
