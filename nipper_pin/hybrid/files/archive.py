"""What a stored archive may hold: plain arrays, as long as they say, and not too much of them.

It names the folder of its meshes, which whoever made the file chose. So a mesh of this disk is read
only if it is, byte for byte, the one that the run was saved with, which its maker had to have;
tables are in the saved run itself.
"""

from __future__ import annotations

import hashlib
import tokenize
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from ...errors import InputError, ModelError
from ...mechanism.files import mesh_path, parse_xml, path_inside
from ...texts import opened

MOST_BYTES = 3 * 2**27
"""Most that an archive may hold after decompression [byte]; a turn of a comber has 0.11 MB."""
MOST_TEXT = 2**27
"""Most of that which may be text [byte], four for a letter: objects of JSON are larger than it."""
MOST_ARRAYS = 50_000
"""Most arrays of an archive: 1,800 turns of a comber, which take some seconds to read."""


def need_readable(arrays: Mapping[str, NDArray[Any]]) -> None:
    """Refuse to write what could not be read again.

    Raises:
        InputError: They are too many, or too large.
    """
    total = sum(array.nbytes for array in arrays.values())
    text = sum(array.nbytes for array in arrays.values() if array.dtype.kind == "U")
    if total <= 0.99 * MOST_BYTES and text <= 0.99 * MOST_TEXT and len(arrays) <= MOST_ARRAYS:
        return
    message = (
        f"this run has {len(arrays)} arrays of {total:.3g} bytes, and a saved one may have "
        f"{MOST_ARRAYS} of {MOST_BYTES:.3g} bytes, {MOST_TEXT:.3g} of them text; simulate fewer "
        "turns, or write tables"
    )
    raise InputError(message, arrays=len(arrays), bytes=total)


def read_archive(stream: IO[bytes]) -> dict[str, NDArray[Any]]:
    """Read the arrays of an archive, or refuse it before they take more than they may.

    Raises:
        ValueError: It says that it is too large, or an array is incomplete or of another kind.
        zipfile.BadZipFile: It is no archive.
    """
    with zipfile.ZipFile(stream) as archive:
        named = {item.filename.removesuffix(".npy"): item for item in archive.infolist()}
        total = sum(item.file_size for item in named.values())
        text = sum(item.file_size for name, item in named.items() if name == "document")
        if total > MOST_BYTES or text > MOST_TEXT or len(named) > MOST_ARRAYS:
            message = (
                f"it would take {total:.3g} bytes in {len(named)} arrays, {text:.3g} of them text; "
                f"at most {MOST_BYTES:.3g}, {MOST_ARRAYS} and {MOST_TEXT:.3g} are read"
            )
            raise ValueError(message)
        return {name: _array(archive, item) for name, item in named.items()}


def _array(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> NDArray[Any]:
    with archive.open(item) as member:
        try:
            found = np.asarray(npy.read_array(member, allow_pickle=False))
        except (ValueError, SyntaxError, tokenize.TokenError, MemoryError) as error:
            message = f"{item.filename} is not what it says ({error})"
            raise ValueError(message) from error
        # At its end the checksum is compared.
        if member.read(1):
            message = f"{item.filename} is longer than it says"
            raise ValueError(message)
        return found


def mesh_digests(name: str, urdf: str, folder: Path) -> dict[str, str]:
    """SHA-256 of each mesh file of a model that is there.

    Returns:
        Digests by the file names of the URDF.

    Raises:
        ModelError: A mesh lies outside the folder.
    """
    file, digests = f"{name}.urdf", dict[str, str]()
    named = {item.get("filename", "") for item in parse_xml(urdf, file).iterfind(".//mesh")}
    for mesh in sorted(named):
        # Names are checked before files are touched.
        if not (folder / path_inside(mesh, "", file)).is_file():
            continue
        path = mesh_path(mesh, folder, "", file)
        try:
            with opened(path) as stream:
                digests[mesh] = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            value, allowed = str(error), "a mesh that can be read"
            raise ModelError(file=file, key=mesh, value=value, allowed=allowed) from error
    return digests
