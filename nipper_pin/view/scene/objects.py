"""Solids and arrows as objects of meshcat."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import meshcat.commands as commands
import meshcat.geometry as geometry
import numpy as np
from meshcat.path import Path
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import InputError
from ...mechanism import Mechanism, Stop, Strut
from .arrows import arrow_body, arrow_place, arrow_sizes
from .colours import ARROW, LINE, SPRING, channels
from .meshes import as_stl, coil
from .solids import CYLINDER, FIXED, THICK, Colour, Solid, cylinder_axis, extent

ROOT = "nipper"
LINE_WIDTH = 0.003  # of the extent of the mechanism
_SUFFIXES = (".stl", ".obj", ".dae")
# meshcat's cylinders stand along y, those of a URDF along z.
_UPRIGHT = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


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
        InputError: The mesh is of a format that meshcat does not read.
    """
    path = solid_path(mechanism, solid)
    place = solid.placement.copy()
    axis = cylinder_axis(mechanism)
    if solid.body == CYLINDER and axis is not None:
        place[[0, 2], 3] -= axis
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
    if solid.path.suffix.lower() not in _SUFFIXES:
        message = (
            f"{solid.path.name}: the viewer reads meshes in {', '.join(_SUFFIXES)}; convert this "
            "one"
        )
        raise InputError(message, file=str(solid.path))
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
