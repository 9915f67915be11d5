"""Files of meshes: what they may cost whoever reads them, and corners that no body can have."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ...errors import ModelError

MOST_MESH = 16 * 2**20
"""Most that is read of meshes that touch, or of one that is drawn [byte]: 300,000 triangles."""
# Distances of single precision, in which files hold them, are a metre there.
_FARTHEST_M = 1e7
# What a trial may take: with what a process has read before, within the bounds of SECURITY.md.
_MOST_BYTES, _MOST_SECONDS = 800 * 10**6, 4
_KINDS = (".stl", ".obj", ".dae")
# A list of triangles costs as much as it is long. The others may announce or repeat as much as they
# like, or end the reader: each is tried by a process that may be ended.
_TRIED = (".obj", ".dae")
_TRIAL = f"""
import resource, sys
import coal, numpy
resource.setrlimit(resource.RLIMIT_AS, ({_MOST_BYTES}, {_MOST_BYTES}))
resource.setrlimit(resource.RLIMIT_CPU, ({_MOST_SECONDS}, {_MOST_SECONDS + 1}))
try:
    coal.MeshLoader().load(sys.argv[1], numpy.ones(3))
except (MemoryError, RuntimeError, ValueError) as error:
    sys.exit(isinstance(error, MemoryError) or "bad_alloc" in str(error))
"""


def check_size(paths: Iterable[Path], key: str, file: str) -> None:
    """Refuse meshes that take too long to read, or too much memory.

    Raises:
        ModelError: They are too large together, one is of another kind, or costs too much.
    """
    size = 0
    for path in paths:
        found = path.stat()
        size += found.st_size
        if path.suffix.lower() not in _KINDS:
            allowed = "a mesh as STL, OBJ or DAE, in a file called so"
            raise ModelError(file=file, key=key, value=path.name, allowed=allowed)
        if size > MOST_MESH:
            allowed = (
                f"at most {MOST_MESH / 2**20:g} MiB; leave out what nobody sees, or write boxes"
            )
            raise ModelError(file=file, key=key, value=f"{size / 2**20:.3g} MiB", allowed=allowed)
        bears = path.suffix.lower() not in _TRIED or _bears(
            str(path), found.st_mtime_ns, found.st_size
        )
        if not bears:
            allowed = (
                f"a mesh that is read in {_MOST_SECONDS} s and {_MOST_BYTES / 1e6:g} MB; write "
                "it as a binary STL"
            )
            raise ModelError(file=file, key=key, value=path.name, allowed=allowed)


@lru_cache(maxsize=1000)
def _bears(path: str, *_changes: int) -> bool:
    """Whether a process that may be ended comes to an end with a file of its own."""
    import subprocess

    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    command = [sys.executable, "-P", "-c", _TRIAL, path]
    done = subprocess.run(
        command, env=os.environ | one_thread, stdin=subprocess.DEVNULL, capture_output=True,
        check=False,
    )  # fmt: skip
    return done.returncode == 0


def check_corners(corners: FloatArray, key: str, file: str) -> None:
    """Refuse corners that are no points of a machine.

    Args:
        corners: Shape (N, 3) or (3,) [m].
        key: Place in the model, for messages.
        file: File that names the mesh, for messages.

    Raises:
        ModelError: One of them is not finite, or too far away.
    """
    allowed = f"corners of finite coordinates of at most {_FARTHEST_M:g} m"
    # Of a single corner, what Coal gives is flat.
    corners = corners.reshape(-1, 3)
    right = (np.abs(corners) <= _FARTHEST_M).all(axis=1)
    if not right.all():
        row = int(np.argmin(right))
        value = f"corner {row + 1} at {corners[row].tolist()}"
        raise ModelError(file=file, key=key, value=value, allowed=allowed)
