"""A saved run names the folder of its meshes: which files of this disk may be read for it?

Whoever made the file chose the folder. So a mesh is read only if it is, byte for byte, the one that
the run was saved with, which its maker had to have; tables are in the saved run itself.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path

from ...errors import InputError, ModelError
from ...mechanism.files import mesh_path, parse_xml, path_inside
from ...mechanism.files.csv_tables import has_file
from ...texts import opened


def mesh_digests(name: str, urdf: str, folder: Path) -> dict[str, str]:
    """SHA-256 of each mesh file of a model that is there.

    Returns:
        Digests by the file names of the URDF.

    Raises:
        ModelError: A mesh lies outside the folder.
    """
    return dict(_found(name, urdf, folder))


def need_own_files(
    name: str,
    urdf: str,
    description: Mapping[str, object],
    folder: Path,
    digests: Mapping[str, str],
) -> None:
    """Refuse a model whose files are not those that it was saved with.

    Args:
        digests: What :func:`mesh_digests` gave when it was saved.

    Raises:
        InputError: A table is to be read from a file, or a mesh is another one.
        ModelError: A mesh lies outside the folder.
    """
    for section in ("drives", "springs"):
        entries = description.get(section)
        for key, entry in entries.items() if isinstance(entries, Mapping) else ():
            if has_file(section, entry):
                message = (
                    f"{section}.{key} names a file, and a saved run holds its tables; save it again"
                )
                raise InputError(message, table=key)
    for mesh, digest in _found(name, urdf, folder):
        if digest != digests.get(mesh):
            message = (
                f"{mesh} in {folder} is not the mesh that this was saved with; put that one back, "
                "or simulate the model again"
            )
            raise InputError(message, mesh=mesh, folder=str(folder))


def _found(name: str, urdf: str, folder: Path) -> Iterator[tuple[str, str]]:
    """Name and digest of each mesh that is there; names are checked before files are touched."""
    file = f"{name}.urdf"
    named = {item.get("filename", "") for item in parse_xml(urdf, file).iterfind(".//mesh")}
    for mesh in sorted(named):
        if not (folder / path_inside(mesh, "", file)).is_file():
            continue
        path = mesh_path(mesh, folder, "", file)
        try:
            with opened(path) as stream:
                yield mesh, hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            value, allowed = str(error), "a mesh that can be read"
            raise ModelError(file=file, key=mesh, value=value, allowed=allowed) from error
