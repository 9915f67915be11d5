"""Changes of a saved run: its document and its arrays, packed again."""

from __future__ import annotations

import io
import json
import random
import struct
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .tree import change_tree

# What a damaged archive ends in.
_NO_ARCHIVE = (
    OSError, ValueError, LookupError, TypeError, RuntimeError, EOFError, struct.error, zlib.error,
    zipfile.BadZipFile,
)  # fmt: skip
_BAD = (np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 0.0, 1e9, -1.0)


def change_archive(data: bytes, chance: random.Random) -> bytes:
    """Change a ``.npz``; one that is no archive by its bytes.

    Args:
        data: The archive.
        chance: Source of chance.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        document = json.loads(str(arrays["document"]))
    except _NO_ARCHIVE:
        return data[: chance.randrange(len(data) + 1)]
    if chance.random() < 0.7:
        arrays["document"] = np.array(json.dumps(change_tree(document, chance)))
    if chance.random() < 0.5:
        name = chance.choice(sorted(arrays))
        arrays[name] = _other(arrays[name], chance)
    stream = io.BytesIO()
    packed: Any = arrays
    np.savez(stream, **packed)
    return stream.getvalue()


def _other(array: NDArray[Any], chance: random.Random) -> NDArray[Any]:
    """An array of other numbers, shape or type."""
    kind = chance.random()
    if kind < 0.5 and array.dtype.kind == "f" and array.size:
        array = array.copy()
        for _ in range(chance.randint(1, 4)):
            place = chance.randrange(array.size)
            value = chance.choice(
                (*_BAD, -float(array.flat[place]), 2.0 * float(array.flat[place]))
            )
            array.flat[place] = value
        return array
    if kind < 0.6:
        return array.ravel()
    if kind < 0.7:
        return np.asarray(array[..., :-1]) if array.ndim else array
    if kind < 0.8:
        return np.concatenate([array, array]) if array.ndim else array
    if kind < 0.9:
        return np.array(chance.choice(("x", 1, 1.0, [], [[1.0]], True, 1j)))
    return np.zeros((chance.randrange(4), 4, chance.randrange(4)))
