"""Files of meshes: how large they may be, and corners that no body can have."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ...errors import ModelError

MOST_MESH = 16 * 2**20
"""Most that is read of meshes that touch, or of one that is drawn [byte]: 300,000 triangles."""
# Distances of single precision, in which files hold them, are a metre there.
_FARTHEST_M = 1e7


def check_size(paths: Iterable[Path], key: str, file: str) -> None:
    """Refuse meshes that take too long to read.

    Args:
        paths: Their files.
        key: Place in the model, for messages.
        file: File that names them, for messages.

    Raises:
        ModelError: They are too large together.
    """
    size = sum(path.stat().st_size for path in paths)
    if size > MOST_MESH:
        allowed = f"at most {MOST_MESH / 2**20:g} MiB; leave out what nobody sees, or write boxes"
        raise ModelError(file=file, key=key, value=f"{size / 2**20:.3g} MiB", allowed=allowed)


def check_corners(corners: FloatArray, key: str, file: str) -> None:
    """Refuse corners that are no points of a machine.

    Args:
        corners: Shape (N, 3) [m].
        key: Place in the model, for messages.
        file: File that names the mesh, for messages.

    Raises:
        ModelError: One of them is not finite, or too far away.
    """
    right = (np.abs(corners) <= _FARTHEST_M).all(axis=1)
    if not right.all():
        row = int(np.argmin(right))
        allowed = f"corners of finite coordinates of at most {_FARTHEST_M:g} m"
        value = f"corner {row + 1} at {corners[row].tolist()}"
        raise ModelError(file=file, key=key, value=value, allowed=allowed)
