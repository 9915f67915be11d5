"""The animation: what changes in a film, as tracks of three.js that meshcat plays.

meshcat's own ``Animation`` takes one frame of one object at a time; a film has thousands, so the
same structure is written here from whole arrays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import umsgpack

from ...arrays import FloatArray
from ..phases import intervals
from .arrows import JUMP, arrow_scale, arrow_shares
from .colours import channels
from .film import Film, bouncing_stop
from .objects import arrow_path, body_path, solid_path, strut_path
from .solids import CYLINDER, Solid, across_plane, cylinder_axis

_SHORTEST = 1e-6  # m
_FLOAT32 = 0x17  # meshcat's code for a typed array in a message


def animation(film: Film, solids: Sequence[Solid]) -> dict[str, object]:
    """The command that loads and plays the animation of a film."""
    clips = [*_bodies(film), *_springs(film, solids), *_struts(film), *_phases(film, solids),
             *_arrows(film)]  # fmt: skip
    return {
        "type": "set_animation",
        "path": "",
        "animations": clips,
        "options": {"play": True, "repetitions": float("inf")},
    }


def _bodies(film: Film) -> Iterator[dict[str, object]]:
    """Position and rotation of all links and of the cylinder."""
    mechanism, t = film.solution.mechanism, film.pace.playback
    heights = across_plane(mechanism)
    for body in range(len(mechanism.joints)):
        x, z = film.position[:, body].T
        yield _clip(
            body_path(mechanism, body),
            t,
            ("position", "vector3", np.column_stack([x, np.full(len(x), heights[body]), z])),
            ("quaternion", "quaternion", _quaternions(film.angle[:, body])),
        )
    axis = cylinder_axis(mechanism)
    if axis is not None:
        place = np.tile([axis[0], 0.0, axis[1]], (len(t), 1))
        yield _clip(
            body_path(mechanism, CYLINDER),
            t,
            ("position", "vector3", place),
            ("quaternion", "quaternion", _quaternions(film.turned)),
        )


def _quaternions(angle: FloatArray) -> FloatArray:
    """Rotations about -y, shape (K, 4), in three.js's order x, y, z, w."""
    zero = np.zeros(len(angle))
    return np.column_stack([zero, -np.sin(0.5 * angle), zero, np.cos(0.5 * angle)])


def _springs(film: Film, solids: Sequence[Solid]) -> Iterator[dict[str, object]]:
    """Length of springs: a coil that is one unit long is scaled along its axis."""
    for solid in solids:
        if solid.spring is not None:
            scale = np.tile(solid.scale, (len(film.drawn), 1))
            length = scale[:, 2] + solid.stretch * film.drawn[:, solid.spring]
            scale[:, 2] = np.maximum(length, _SHORTEST)
            path = solid_path(film.solution.mechanism, solid)
            yield _clip(path, film.pace.playback, ("scale", "vector3", scale))


def _struts(film: Film) -> Iterator[dict[str, object]]:
    """Lines between the two points of springs and dampers: middle, direction and length."""
    struts = film.solution.mechanism.struts
    if not struts:
        return
    places, _ = film.solution.system.body.points(film.drawn)
    for number, strut in enumerate(struts):
        first, second = places[:, number, 0], places[:, number, 1]
        x, z = 0.5 * (first + second).T
        along = second - first
        # A quarter turn about x lays the line, which stands along y, along z; from there it turns
        # about -y, as everything in the plane does.
        half = 0.5 * np.unwrap(np.arctan2(-along[:, 0], along[:, 1]))
        turned = np.column_stack([np.cos(half), -np.sin(half), np.sin(half), np.cos(half)])
        # Nothing at all would leave a matrix that cannot be inverted.
        length = np.maximum(np.hypot(*along.T), _SHORTEST)
        yield _clip(
            strut_path(strut),
            film.pace.playback,
            ("position", "vector3", np.column_stack([x, np.zeros(len(x)), z])),
            ("quaternion", "quaternion", np.sqrt(0.5) * turned),
            ("scale", "vector3", np.column_stack([np.ones_like(x), length, np.ones_like(x)])),
        )


def _phases(film: Film, solids: Sequence[Solid]) -> Iterator[dict[str, object]]:
    """Colour of the link that opens the transition stop, by phase."""
    mechanism = film.solution.mechanism
    stop = bouncing_stop(mechanism)
    if stop is None:
        return
    shown = intervals(film.solution)
    colours = [channels(item.colour) for item in shown]
    starts = film.pace.playback_at(np.array([item.start for item in shown]))
    end = float(film.pace.playback[-1])
    t, values = [0.0], [colours[int(film.phase[0])]]
    for before, after, start in zip(colours, colours[1:], starts[1:], strict=False):
        if start + JUMP < end:
            t += [float(start), float(start) + JUMP]
            values += [before, after]
    t, values = [*t, end], [*values, values[-1]]
    for solid in solids:
        if solid.body == stop.index:
            path = f"{solid_path(mechanism, solid)}/<object>"
            yield _clip(path, np.array(t), (".material.color", "color", np.array(values)))


def _arrows(film: Film) -> Iterator[dict[str, object]]:
    """Size of the arrows."""
    for stop, t, share in arrow_shares(film.solution, film.pace):
        path = arrow_path(film.solution.mechanism, stop)
        yield _clip(path, t, ("scale", "vector3", arrow_scale(share)))


def _clip(path: str, t: FloatArray, *tracks: tuple[str, str, FloatArray]) -> dict[str, object]:
    """Tracks of one object; times count in seconds."""
    times = _packed(t)
    return {
        "path": f"/{path}",
        "clip": {
            "fps": 1,
            "name": path,
            "tracks": [
                {"name": name if name.startswith(".") else f".{name}", "type": kind,
                 "times": times, "values": _packed(values)}
                for name, kind, values in tracks
            ],
        },
    }  # fmt: skip


def _packed(values: FloatArray) -> umsgpack.Ext:
    return umsgpack.Ext(_FLOAT32, np.ascontiguousarray(values, dtype="<f4").tobytes())
