"""One self-contained page: meshcat's viewer, the scene, the animation and what stands beside it."""

from __future__ import annotations

import base64
import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import umsgpack

from ...arrays import FloatArray
from ...mechanism import Mechanism
from .arrows import arrow_stops
from .film import Film, true_size, worlds
from .objects import animation, arrow_commands, solid_commands, strut_command
from .readings import drawing, readings, rounded
from .solids import Solid, across_plane, pictured

OBLIQUE, ALONG = (0.38, -1.0, 0.34), (0.0, -1.0, 0.0)
"""Directions from the mechanism to the camera: from the front and above, and along the hinges."""
# The page shows 40 degrees from top to bottom, half of it here with a margin, and in width at least
# a quarter more: in a pane that is less wide it moves the camera back.
_HALF, _WIDE = math.radians(19.3), 1.25
_FRAMES = 200  # of a film that are looked at, evenly spaced on the machine's clock
_VIEWER = Path(meshcat.__file__).parent / "viewer"
_SCRIPTS = ("scene.js", "lips.js", "curves.js", "controls.js")
# The viewer's scene as an empty page, of which the script colours the background.
_BARE = [{"type": "set_property", "path": f"/{path}", "property": "visible", "value": False}
         for path in ("Grid", "Axes")]  # fmt: skip


def scene_page(shown: Film) -> str:
    """The page of a film, served or written alike, with script, scene and animation inside."""
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
        # It cannot end the script element it stands in.
        "film": json.dumps(found, allow_nan=False).replace("<", "\\u003c"),
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


def corners(shown: Film, drawn: Sequence[Solid]) -> FloatArray:
    """Corners of what stands, and of boxes around what moves in frames all over a film.

    Returns:
        Shape (N, 3) [m].

    Raises:
        InputError: A mesh cannot be read.
    """
    t = shown.pace.machine
    places = np.unique(np.searchsorted(t, np.linspace(t[0], t[-1], _FRAMES)))
    planes = worlds(shown.position[places], shown.angle[places])
    heights = across_plane(shown.solution.mechanism)
    return np.concatenate([np.zeros((0, 3)), *_boxes(drawn, planes, heights)])


def _boxes(
    drawn: Sequence[Solid], planes: FloatArray, heights: Sequence[float]
) -> Iterator[FloatArray]:
    for solid in drawn:
        points = solid.corners
        # Frame and cylinder stand where they are.
        if solid.body < 0:
            yield points
            continue
        ends = points.min(axis=0), points.max(axis=0)
        box = np.array(list(itertools.product(*zip(*ends, strict=True))))
        moved = planes[:, solid.body, :2, :2] @ box[:, [0, 2]].T + planes[:, solid.body, :2, 2:]
        x, z = moved.transpose(1, 0, 2).reshape(2, -1)
        yield np.column_stack([x, np.tile(heights[solid.body] + box[:, 1], len(planes)), z])


def camera(points: FloatArray, direction: tuple[float, float, float]) -> tuple[FloatArray, ...]:
    """Target and position of the nearest camera that has all points in sight.

    Args:
        points: Shape (N, 3) [m].
        direction: From the mechanism to the camera (x, y, z).

    Returns:
        Target and position (x, y, z), each of shape (3,) [m].
    """
    towards = np.array(direction) / np.linalg.norm(direction)
    across = np.cross([0.0, 0.0, 1.0], towards)
    across /= np.linalg.norm(across)
    axes = np.array([across, np.cross(towards, across), towards])
    seen = points @ axes.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    off = seen - middle
    reach = np.maximum(np.abs(off[:, 0]) / _WIDE, np.abs(off[:, 1])) / math.tan(_HALF)
    distance = float((reach + off[:, 2]).max())
    target = middle @ axes
    return target, target + distance * towards


def _policy(*scripts: str, connect: str) -> str:
    """What a browser lets the page do: run these scripts alone, and load nothing from anywhere."""
    digests = (hashlib.sha256(script.encode()).digest() for script in scripts)
    own = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; "
        f"img-src data: blob:; connect-src {connect}"
    )


def _licences() -> str:
    """Licences of meshcat and what is bundled with it, which a copy has to carry."""
    files = (_VIEWER / "LICENSE", _VIEWER / "dist" / "main.min.js.LICENSE.txt")
    texts = [item.read_text(encoding="utf-8") for item in files if item.is_file()]
    return "\n".join(texts).replace("--", "- -")
