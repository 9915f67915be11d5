"""What a stored archive may hold: plain arrays, as long as they say, and not too much of them."""

from __future__ import annotations

import math
import zipfile
from typing import IO

import numpy as np
from numpy.lib import format as npy

MOST_BYTES = 2**30
"""Most that an archive may hold after decompression [byte]: four thousand turns of a comber, no two
of them equal, at 0.22 MB each."""
_SUFFIX = ".npy"
# Of an array: numbers, or one text.
_KINDS = "fU"


def check_archive(stream: IO[bytes]) -> None:
    """Refuse an archive whose arrays are too large, or larger than their content.

    Sizes stand in the archive's directory and at the begin of each array; nothing is decompressed
    but these begins.

    Args:
        stream: The archive; its position is at its begin afterwards.

    Raises:
        ValueError: An array is too large, incomplete or of another kind.
        zipfile.BadZipFile: It is no archive.
    """
    with zipfile.ZipFile(stream) as archive:
        members = archive.infolist()
        total = sum(item.file_size for item in members)
        if total > MOST_BYTES:
            message = f"it would take {total:.3g} bytes; at most {MOST_BYTES:.3g} are read"
            raise ValueError(message)
        for item in members:
            with archive.open(item) as member:
                shape, kind, size = _begin(member)
                if kind.kind not in _KINDS or not item.filename.endswith(_SUFFIX):
                    message = f"{item.filename} holds {kind}, which is no number and no text"
                    raise ValueError(message)
                if math.prod(shape) * kind.itemsize + size != item.file_size:
                    message = f"{item.filename} is not as long as it says"
                    raise ValueError(message)
    stream.seek(0)


def _begin(member: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[np.generic], int]:
    """Shape and kind of an array, and where its numbers begin."""
    major = npy.read_magic(member)
    read = npy.read_array_header_1_0 if major == (1, 0) else npy.read_array_header_2_0
    shape, _, kind = read(member)
    return shape, kind, member.tell()
