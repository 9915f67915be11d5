"""Meshes of drawn shapes as corners and faces: nothing else of their files reaches a viewer."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

import coal
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from ...arrays import FloatArray
from ...errors import InputError
from ...mechanism.files import check_corners, check_size

_CORNERS = 32  # of a circle
_RINGS = 9  # of a sphere, from pole to pole
_TURNS, _STEPS, _WIRE = 7, 16, 0.22  # of a coil, of a turn, and radius of its wire by its own

# A face in a binary STL file: normal, three corners, and two bytes that nobody uses.
_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
_HEAD = 80


def read_mesh(path: Path) -> tuple[FloatArray, NDArray[np.intp]]:
    """Corners and faces of a mesh file.

    Returns:
        Corners, shape (N, 3) [m], and faces, shape (F, 3), counter-clockwise from outside.

    Raises:
        InputError: It cannot be read, or holds no points of a machine.
    """
    try:
        check_size([path], "mesh", path.name)
        model = coal.MeshLoader().load(str(path), np.ones(3))
    except (OSError, ValueError, RuntimeError) as error:
        message = f"{path.name}: the mesh cannot be read; write it again, as STL or OBJ"
        raise InputError(message, file=str(path)) from error
    corners = np.asarray(model.vertices())
    check_corners(corners, "mesh", path.name)
    triangles = [model.tri_indices(place) for place in range(model.num_tris)]
    # Files like STL hold a corner once for each face that has it.
    corners, same = np.unique(corners.round(9), axis=0, return_inverse=True)
    faces = np.array([[item[0], item[1], item[2]] for item in triangles])
    return corners, same.reshape(-1)[faces]


def mesh_of(
    kind: str, sizes: Sequence[float], path: Path | None
) -> tuple[FloatArray, NDArray[np.intp]]:
    """Corners, shape (N, 3) [m], and faces, shape (F, 3), counter-clockwise, of a solid's shape.

    Raises:
        InputError: Its mesh cannot be read.
    """
    if path is not None:
        return read_mesh(path)
    if kind == "coil":
        return coil(sizes[0])
    corners = _surface(kind, sizes)
    hull = ConvexHull(corners)
    faces = hull.simplices.astype(np.intp)
    a, b, c = (corners[faces[:, place]] for place in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards, ::-1]
    return corners, faces


def _surface(kind: str, sizes: Sequence[float]) -> FloatArray:
    """Points whose convex hull is a plain shape, shape (N, 3) [m]."""
    if kind == "box":
        signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return np.asarray(signs * sizes)
    turn = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(_CORNERS)])
    if kind == "cylinder":
        radius, length = sizes
        lift = np.array([0.0, 0.0, 0.5 * length])
        return np.concatenate([radius * circle - lift, radius * circle + lift])
    polar = np.linspace(0.0, np.pi, _RINGS + 2)[1:-1]
    rings = [np.sin(item) * circle + [0.0, 0.0, np.cos(item)] for item in polar]
    poles = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    return np.asarray(sizes[0] * np.concatenate([*rings, poles]))


def coil(radius: float) -> tuple[FloatArray, NDArray[np.intp]]:
    """A coil around z from 0 to 1, of an outer radius [m], as :func:`mesh_of`."""
    turn = 2.0 * np.pi * np.arange(_TURNS * _STEPS + 1) / _STEPS
    along = np.linspace(0.0, 1.0, len(turn))
    wire, around = _WIRE * radius, 2.0 * np.pi * np.arange(6) / 6.0
    # A wire of round section would be flattened where the coil is short: it is a band.
    out = (radius - wire + wire * np.cos(around))[None, :]
    up = 0.5 / _TURNS * np.sin(around) * 0.5
    corners = np.stack([out * np.cos(turn)[:, None], out * np.sin(turn)[:, None],
                        np.clip(along[:, None] + up, 0.0, 1.0)], axis=-1)  # fmt: skip
    first = (6 * np.arange(len(turn) - 1)[:, None] + np.arange(6)).ravel()
    beside = (6 * np.arange(len(turn) - 1)[:, None] + (np.arange(6) + 1) % 6).ravel()
    faces = [[first, beside, first + 6], [beside, beside + 6, first + 6]]
    return corners.reshape(-1, 3), np.concatenate([np.column_stack(part) for part in faces])


def as_stl(corners: FloatArray, faces: NDArray[np.intp]) -> bytes:
    """A mesh, as that of :func:`mesh_of`, as a binary STL file."""
    rows = np.zeros(len(faces), dtype=_FACE)
    rows["corners"] = corners[faces]
    a, b, c = (corners[faces[:, place]] for place in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"] = normal / np.where(size > 0.0, size, 1.0)
    return bytes(_HEAD) + struct.pack("<I", len(rows)) + rows.tobytes()
