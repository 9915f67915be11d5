"""One self-contained page: meshcat's viewer, the scene, the animation and what stands beside it."""

from __future__ import annotations

import base64
import json
from importlib import resources
from pathlib import Path

import meshcat
import numpy as np
import umsgpack

from ...hybrid.solution import Solution
from ...hybrid.storage import complete_file
from .film import Film, Look, film
from .objects import arrow_commands, arrow_stops, solid_commands, strut_command
from .readings import readings
from .solids import solids
from .tracks import animation

_VIEWER = Path(meshcat.__file__).parent / "viewer"
_NEAR = 1.6  # distance of the camera by the size of the mechanism
_BELOW = 0.1  # so far below the middle it looks: the controls cover the lower edge
_DIRECTION = (0.38, -1.0, 0.34)


def write_page(solution: Solution, path: str | Path, look: Look | None = None) -> Path:
    """Write a solution as one HTML file that needs nothing else, not even a network.

    Args:
        solution: The solution.
        path: File to write; it appears only when it is complete.
        look: How the solution is shown.

    Raises:
        InputError: There is nothing to show, or the file cannot be written.
    """
    page = scene_page(film(solution, look or Look()))
    with complete_file(Path(path)) as partial:
        partial.write_text(page, encoding="utf-8")
    return Path(path)


def scene_page(shown: Film) -> str:
    """The page of a film, served or written alike.

    Args:
        shown: The film.

    Returns:
        HTML with script, scene and animation inside.
    """
    here = resources.files(__package__)
    parts = {
        "licence": _licences(),
        "viewer": (_VIEWER / "dist" / "main.min.js").read_text(encoding="utf-8"),
        "scene": json.dumps(_messages(shown)),
        "film": _in_script(json.dumps({**readings(shown), "camera": _camera(shown)})),
        "overlay": (here / "overlay.js").read_text(encoding="utf-8"),
    }
    pieces = []
    # Split first: what is put in may hold anything, also what looks like a place to put something.
    for place, piece in enumerate((here / "page.html").read_text(encoding="utf-8").split("@@")):
        pieces.append(parts[piece] if place % 2 else piece)
    return "".join(pieces)


def _messages(shown: Film) -> list[str]:
    """The messages that meshcat's server would send, in base64."""
    mechanism = shown.solution.mechanism
    drawn = solids(mechanism)
    sent: list[dict[str, object]] = [
        _property("Background", "top_color", [1.0, 1.0, 1.0]),
        _property("Background", "bottom_color", [0.80, 0.84, 0.88]),
        _property("Grid", "visible", False),
        _property("Axes", "visible", False),
    ]
    for solid in drawn:
        sent += solid_commands(mechanism, solid)
    for stop in arrow_stops(mechanism):
        sent += arrow_commands(mechanism, stop)
    sent += (strut_command(mechanism, strut) for strut in mechanism.struts)
    sent.append(animation(shown, drawn))
    return [base64.b64encode(umsgpack.packb(item)).decode("ascii") for item in sent]


def _property(path: str, name: str, value: object) -> dict[str, object]:
    return {"type": "set_property", "path": f"/{path}", "property": name, "value": value}


def _camera(shown: Film) -> dict[str, object]:
    """Where the camera stands and looks (x, y, z) [m]: at all that moves, from front and above."""
    points = np.concatenate([shown.position.reshape(-1, 2), np.zeros((1, 2))])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    target = np.array([middle[0], 0.0, middle[1]])
    size = max(float(np.linalg.norm(high - low)), 0.5 * shown.solution.mechanism.reach_m)
    target[2] -= _BELOW * size
    direction = np.array(_DIRECTION) / np.linalg.norm(_DIRECTION)
    return {
        "target": target.tolist(),
        "position": (target + _NEAR * size * direction).tolist(),
    }


def _in_script(text: str) -> str:
    """JSON that cannot end the script element it stands in."""
    return text.replace("<", "\\u003c")


def _licences() -> str:
    """Licences of meshcat and what is bundled with it, which a copy has to carry."""
    files = (_VIEWER / "LICENSE", _VIEWER / "dist" / "main.min.js.LICENSE.txt")
    texts = [item.read_text(encoding="utf-8") for item in files if item.is_file()]
    return "\n".join(texts).replace("--", "- -")
