"""Solids and arrows as objects of meshcat, and what changes in a film as tracks that it plays.

meshcat's own ``Animation`` takes one frame of one object at a time; a film has thousands, so the
same structure is written here from whole arrays.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import Any

import meshcat.commands as commands
import meshcat.geometry as geometry
import numpy as np
import umsgpack
from meshcat.path import Path
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...mechanism import Mechanism, Stop, Strut
from ..phases import intervals
from .arrows import JUMP, arrow_body, arrow_place, arrow_scale, arrow_shares, arrow_sizes
from .colours import ARROW, LINE, SPRING, channels
from .film import Film, bouncing_stop
from .meshes import as_stl, coil
from .solids import CYLINDER, FIXED, THICK, Colour, Solid, across_plane, extent, guide

ROOT = "nipper"
LINE_WIDTH = 0.003  # of the extent of the mechanism
# meshcat's cylinders stand along y, those of a URDF along z.
_UPRIGHT = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)
_SHORTEST = 1e-6  # m
_FLOAT32 = 0x17  # meshcat's code for a typed array in a message


def body_path(mechanism: Mechanism, body: int) -> str:
    """Path of the node that moves as a link, the cylinder or the frame."""
    names = {FIXED: "frame", CYLINDER: "cylinder"}
    return f"{ROOT}/{names.get(body) or mechanism.joints[body].child}"


def solid_path(mechanism: Mechanism, solid: Solid) -> str:
    """Path of the node that holds a solid."""
    return f"{body_path(mechanism, solid.body)}/{solid.name}"


def solid_commands(mechanism: Mechanism, solid: Solid) -> Iterator[dict[str, object]]:
    """Commands that put a solid in its place.

    Raises:
        InputError: The mesh cannot be read.
    """
    path = solid_path(mechanism, solid)
    place = solid.placement.copy()
    law = guide(mechanism)
    if solid.body == CYLINDER and law is not None:
        place[[0, 2], 3] -= law.crank_axis
    place[:3, :3] = place[:3, :3] * solid.scale
    if solid.kind == "cylinder":
        place = place @ _UPRIGHT
    yield _object(path, _shape(solid), solid.colour)
    yield _transform(path, place)


def arrow_path(mechanism: Mechanism, stop: Stop) -> str:
    """Path of the node that is scaled with the impulse of a stop."""
    return f"{body_path(mechanism, arrow_body(mechanism, stop))}/impulse_{stop.name}"


def arrow_commands(mechanism: Mechanism, stop: Stop) -> Iterator[dict[str, object]]:
    """Commands that put the arrow of a stop in its place, at its largest size."""
    path = arrow_path(mechanism, stop)
    shaft, thick, head, wide = arrow_sizes(mechanism)
    yield _transform(path, arrow_place(mechanism, stop))
    yield _object(f"{path}/shaft", geometry.Cylinder(shaft, thick), channels(ARROW), glow=True)
    yield _transform(f"{path}/shaft", _upward(0.5 * shaft))
    cone = geometry.Cylinder(head, radiusTop=0.0, radiusBottom=wide)
    yield _object(f"{path}/head", cone, channels(ARROW), glow=True)
    yield _transform(f"{path}/head", _upward(shaft + 0.5 * head))


def strut_path(strut: Strut) -> str:
    """Path of the node that is stretched from one point of a strut to the other."""
    return f"{ROOT}/{strut.kind}_{strut.name}"


def strut_command(mechanism: Mechanism, strut: Strut) -> dict[str, object]:
    """Command that draws a strut one unit long, along y; the animation places it."""
    if strut.kind == "damper":
        line = geometry.Cylinder(1.0, LINE_WIDTH * extent(mechanism))
        return _object(strut_path(strut), line, channels(LINE), glow=True)
    corners, faces = coil(THICK * extent(mechanism))
    wire = _mesh(corners[:, [1, 2, 0]] - [0.0, 0.5, 0.0], faces)
    return _object(strut_path(strut), wire, channels(SPRING))


def _upward(distance: float) -> FloatArray:
    place = np.eye(4)
    place[1, 3] = distance
    return place


def _shape(solid: Solid) -> geometry.Geometry:
    if solid.kind == "coil":
        return _mesh(*solid.mesh)
    if solid.path is None:
        if solid.kind == "box":
            return geometry.Box(list(solid.sizes))
        if solid.kind == "sphere":
            return geometry.Sphere(solid.sizes[0])
        return geometry.Cylinder(solid.sizes[1], solid.sizes[0])
    # Read also where the viewer reads it: a file that cannot be drawn is refused.
    corners, faces = solid.mesh
    if solid.path.suffix.lower() == ".stl":
        return geometry.StlMeshGeometry.from_file(str(solid.path))
    # Corners and faces alone: other files may name textures at any address.
    return _mesh(corners, faces)


def _mesh(corners: FloatArray, faces: NDArray[np.intp]) -> geometry.Geometry:
    return geometry.StlMeshGeometry.from_stream(io.BytesIO(as_stl(corners, faces)))


def _object(
    path: str, shape: geometry.Geometry, colour: Colour, *, glow: bool = False
) -> dict[str, object]:
    number = int.from_bytes(bytes(round(255.0 * part) for part in colour))
    kind = geometry.MeshBasicMaterial if glow else geometry.MeshPhongMaterial
    # Both sides: a spring that is drawn shorter, or a mirrored mesh, turns its faces round.
    material = kind(color=number, side=2) if glow else kind(color=number, side=2, shininess=40)
    command: dict[str, Any] = commands.SetObject(shape, material, Path((path,))).lower()
    for item in command["object"]["geometries"]:
        # The viewer complains of the name that this version of the library still writes.
        if item["type"] == "_meshfile":
            item["type"] = "_meshfile_geometry"
    return command


def _transform(path: str, place: FloatArray) -> dict[str, object]:
    command: dict[str, object] = commands.SetTransform(place, Path((path,))).lower()
    return command


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
    zero, heights = np.zeros(len(t)), across_plane(mechanism)
    moved = [
        (body, film.position[:, body], heights[body], film.angle[:, body])
        for body in range(len(mechanism.joints))
    ]
    law = guide(mechanism)
    if law is not None:
        moved.append((CYLINDER, np.tile(law.crank_axis, (len(t), 1)), 0.0, film.turned))
    for body, place, height, angle in moved:
        # A rotation about -y, in three.js's order x, y, z, w.
        turned = np.column_stack([zero, -np.sin(0.5 * angle), zero, np.cos(0.5 * angle)])
        yield _clip(
            body_path(mechanism, body),
            t,
            ("position", "vector3", np.column_stack([place[:, 0], zero + height, place[:, 1]])),
            ("quaternion", "quaternion", turned),
        )


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
