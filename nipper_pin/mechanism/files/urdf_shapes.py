"""Shapes and colours of a URDF; files of meshes, where they may lie and what reading them costs."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import ModelError
from ...texts import MOST_TEXT, followed, is_path, no_file, read_text
from .urdf_values import finite, placement

_PACKAGE = "package://"
_INSIDE = "a path relative to the model folder that stays inside it"
_ATTRIBUTES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}


@dataclass(frozen=True, kw_only=True)
class UrdfShape:
    """A collision shape of a link.

    Attributes:
        name: Its name; without one in the file ``<link>_<place>``.
        kind: "box", "cylinder", "sphere" or "mesh".
        sizes: Box: edges; cylinder: radius and length; sphere: radius [m]; mesh: its scale [-].
        path: Mesh file, or None.
        placement: In the frame of the link.
    """

    name: str
    kind: str
    sizes: tuple[float, ...]
    path: Path | None
    placement: pin.SE3


def check_colours(root: ElementTree.Element, file: str) -> None:
    """Refuse colours that are no four numbers; a viewer would stumble over them."""
    for part in root.iterfind("*"):
        for colour in part.iter("color") if part.tag in ("link", "material") else ():
            finite(colour, "rgba", 4, None, "color rgba", file)


def read_shapes(
    link: ElementTree.Element, name: str, file: str, mesh_folder: Path
) -> tuple[UrdfShape, ...]:
    """Read the collision shapes of a link; the visual ones are only checked."""
    found = []
    for tag in ("visual", "collision"):
        for place, element in enumerate(link.findall(tag)):
            shape = element.get("name") or f"{name}_{place}"
            key = f"link {name} {tag} {shape}"
            at = placement(element, key, file)
            solid = _solid(element, key, file)
            path, sizes = None, shape_sizes(solid, key, file)
            if solid.tag == "mesh":
                filename = solid.get("filename", "")
                if tag == "collision":
                    path = mesh_path(filename, mesh_folder, key, file)
                else:
                    # Only a viewer opens it. A run, also one saved on another machine, does not
                    # depend on pictures, and a load does not wait for the file system.
                    path_inside(filename, key, file)
            if tag == "collision":
                found.append(
                    UrdfShape(
                        name=shape, kind=solid.tag, sizes=tuple(sizes), path=path, placement=at
                    )
                )
    return tuple(found)


def _solid(element: ElementTree.Element, key: str, file: str) -> ElementTree.Element:
    """The one geometry of a shape; comments are none."""
    geometry = element.find("geometry")
    solids = [] if geometry is None else [item for item in geometry if isinstance(item.tag, str)]
    if len(solids) != 1 or solids[0].tag not in (*_ATTRIBUTES, "mesh"):
        found = [item.tag for item in solids]
        allowed = f"one geometry out of {', '.join((*_ATTRIBUTES, 'mesh'))}"
        raise ModelError(file=file, key=key, value=found, allowed=allowed)
    return solids[0]


def shape_sizes(solid: ElementTree.Element, key: str, file: str) -> list[float]:
    """Sizes of a primitive, which are positive [m], or the scale of a mesh [-]."""
    if solid.tag == "mesh":
        return finite(solid, "scale", 3, "1 1 1", f"{key} mesh scale", file)
    found = []
    for attribute in _ATTRIBUTES[solid.tag]:
        count = 3 if attribute == "size" else 1
        sizes = finite(solid, attribute, count, None, f"{key} {attribute}", file)
        if min(sizes) <= 0.0:
            raise ModelError(
                file=file, key=f"{key} {attribute}", value=sizes, allowed="sizes above 0 m"
            )
        found += sizes
    return found


def path_inside(filename: str, key: str, file: str) -> str:
    """Path of a mesh in the model folder, for which a package stands.

    Raises:
        ModelError: The path leaves the folder by its very words.
    """
    inner = filename
    if filename.startswith(_PACKAGE):
        inner = filename.removeprefix(_PACKAGE).partition("/")[2]
    path = PurePosixPath(inner)
    outside = path.is_absolute() or ".." in path.parts or ":" in inner or "\\" in inner
    if not inner or outside or not is_path(inner):
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=_INSIDE)
    return inner


def _check_package(filename: str, mesh_folder: Path, key: str, file: str) -> None:
    """Refuse a mesh of another package than that whose package.xml lies in the model folder."""
    manifest = mesh_folder / "package.xml"
    if not (filename.startswith(_PACKAGE) and manifest.is_file()):
        return
    try:
        name = ElementTree.fromstring(read_text(manifest, MOST_TEXT)).findtext("name", "").strip()
    except (OSError, ValueError, ElementTree.ParseError) as error:
        allowed = f"a package whose package.xml can be read: {error}"
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=allowed) from error
    if filename.removeprefix(_PACKAGE).partition("/")[0] != name:
        allowed = f"a mesh of the package of the model folder, {_PACKAGE}{name}/..."
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=allowed)


def mesh_path(filename: str, mesh_folder: Path, key: str, file: str) -> Path:
    """Path of a mesh, which must be a file inside the model folder.

    Args:
        filename: Path in the URDF, relative to the model folder; ``package://NAME/`` before it
            stands for that folder.

    Raises:
        ModelError: The path leaves the folder or names no file.
    """
    named = mesh_folder / path_inside(filename, key, file)
    path = followed(named)
    if not path.is_relative_to(followed(mesh_folder)):
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=_INSIDE)
    if not path.is_file():
        kind = no_file(named)
        allowed = f"a mesh file in the model folder {mesh_folder}"
        allowed += f"; {named.name} is {kind}" if kind else ""
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=allowed)
    _check_package(filename, mesh_folder, key, file)
    return path


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
