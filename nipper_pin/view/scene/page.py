"""One self-contained page: meshcat's viewer, the scene, the animation and what stands beside it."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import umsgpack

from ...mechanism import Mechanism
from .arrows import arrow_stops
from .film import Film, true_size
from .framing import ALONG, OBLIQUE, camera, corners
from .objects import arrow_commands, solid_commands, strut_command
from .readings import drawing, readings, rounded
from .solids import Solid
from .symbols import pictured
from .tracks import animation

_VIEWER = Path(meshcat.__file__).parent / "viewer"
_SCRIPTS = ("scene.js", "lips.js", "curves.js", "controls.js")
# The viewer's scene as an empty page, of which the script colours the background.
_BARE = [{"type": "set_property", "path": f"/{path}", "property": "visible", "value": False}
         for path in ("Grid", "Axes")]  # fmt: skip


def scene_page(shown: Film) -> str:
    """The page of a film, served or written alike.

    Returns:
        HTML with script, scene and animation inside.
    """
    drawn = pictured(shown.solution.mechanism)
    found = {**readings(shown), "cameras": cameras((shown, drawn))}
    if shown.larger > 1.0:
        plain = true_size(shown)
        found["true_size"] = {**drawing(plain), "scene": encoded(animation(plain, drawn))}
    messages = machine_messages(shown.solution.mechanism, drawn)
    return assembled([*messages, animation(shown, drawn)], found)


def encoded(message: Mapping[str, object]) -> str:
    """A message to meshcat's viewer as text."""
    return base64.b64encode(umsgpack.packb(message)).decode("ascii")


def assembled(
    messages: Sequence[Mapping[str, object]],
    found: Mapping[str, object],
    room: str = __package__,
    connect: str = "data: blob:",
) -> str:
    """The page of messages to meshcat's viewer and of what is written beside it.

    Args:
        messages: Commands that draw the scene and play its animation.
        found: What the page's script reads (:func:`~.readings.readings`, and cameras).
        room: Package with further scripts and style sheets, which follow those of every page.
        connect: Where the page's script may connect to, as a browser's policy has it.
    """
    here, there = (resources.files(name) / "page_files" for name in (__package__, room))
    files = [here / name for name in (*_SCRIPTS, "style.css")]
    files += there.iterdir() if room != __package__ else []
    texts = {file.name: file.read_text(encoding="utf-8") for file in files}
    viewer = (_VIEWER / "dist" / "main.min.js").read_text(encoding="utf-8")
    script = "".join(text for name, text in texts.items() if name.endswith(".js"))
    parts = {
        "policy": _policy(viewer, script, connect=connect),
        "licence": _licences(),
        "style": "".join(text for name, text in texts.items() if name.endswith(".css")),
        "viewer": viewer,
        "scene": json.dumps([encoded(item) for item in (*_BARE, *messages)]),
        "film": _in_script(json.dumps(found, allow_nan=False)),
        "script": script,
    }  # fmt: skip
    pieces = []
    # Split first: what is put in may hold anything, also what looks like a place to put something.
    for place, piece in enumerate((here / "page.html").read_text(encoding="utf-8").split("@@")):
        pieces.append(parts[piece] if place % 2 else piece)
    return "".join(pieces)


def machine_messages(mechanism: Mechanism, drawn: Sequence[Solid]) -> list[dict[str, Any]]:
    """Messages that draw a machine with its arrows and lines; an animation moves it."""
    sent: list[dict[str, object]] = []
    for solid in drawn:
        sent += solid_commands(mechanism, solid)
    for stop in arrow_stops(mechanism):
        sent += arrow_commands(mechanism, stop)
    sent += (strut_command(mechanism, strut) for strut in mechanism.struts)
    return sent


def cameras(*shown: tuple[Film, Sequence[Solid]]) -> dict[str, object]:
    """Positions and targets of the cameras (x, y, z) [m], for views of all that is drawn."""
    points = np.concatenate([corners(film, drawn) for film, drawn in shown])
    found: dict[str, object] = {}
    for name, direction in (("whole", OBLIQUE), ("side", ALONG)):
        target, place = camera(points, direction)
        found[name] = {"target": rounded(target), "position": rounded(place)}
    return found


def _policy(*scripts: str, connect: str) -> str:
    """What a browser lets the page do: run these scripts alone, and load nothing from anywhere."""
    digests = (hashlib.sha256(script.encode()).digest() for script in scripts)
    own = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; "
        f"img-src data: blob:; connect-src {connect}"
    )


def _in_script(text: str) -> str:
    """JSON that cannot end the script element it stands in."""
    return text.replace("<", "\\u003c")


def _licences() -> str:
    """Licences of meshcat and what is bundled with it, which a copy has to carry."""
    files = (_VIEWER / "LICENSE", _VIEWER / "dist" / "main.min.js.LICENSE.txt")
    texts = [item.read_text(encoding="utf-8") for item in files if item.is_file()]
    return "\n".join(texts).replace("--", "- -")
