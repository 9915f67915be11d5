"""Meshes of drawn shapes as corners and faces: nothing else of their files reaches a viewer."""

from __future__ import annotations

import struct
from pathlib import Path

import coal
import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import InputError
from ...mechanism.files.meshes import check_corners, check_size

# A face in a binary STL file: normal, three corners, and two bytes that nobody uses.
_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
_HEAD = 80


def read_mesh(path: Path) -> tuple[FloatArray, NDArray[np.intp]]:
    """Corners and faces of a mesh file.

    Args:
        path: The file.

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


def as_stl(corners: FloatArray, faces: NDArray[np.intp]) -> bytes:
    """A mesh as a binary STL file.

    Args:
        corners: Shape (N, 3) [m].
        faces: Shape (F, 3).
    """
    rows = np.zeros(len(faces), dtype=_FACE)
    rows["corners"] = corners[faces]
    a, b, c = (corners[faces[:, place]] for place in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"] = normal / np.where(size > 0.0, size, 1.0)
    return bytes(_HEAD) + struct.pack("<I", len(rows)) + rows.tobytes()
