"""Reading and checking what belongs to one element of a URDF: numbers, inertias and shapes."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np

from ...arrays import FloatArray
from ...errors import ModelError
from ...texts import MOST_TEXT, followed, is_path, read_text
from ...tolerances.mechanics import URDF_TOLERANCE
from .toml_types import LARGEST

_PACKAGE = "package://"
_INSIDE = "a path relative to the model folder that stays inside it"
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_NUMERIC = ("value", "xyz", "rpy", "size", "radius", "length", "scale", "damping", "friction")
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_ATTRIBUTES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}


def numbers(
    element: ElementTree.Element,
    attribute: str,
    count: int,
    default: str | None,
    key: str,
    file: str,
) -> FloatArray:
    """Read an attribute of finite numbers."""
    return np.array(_finite(element, attribute, count, default, key, file))


def _finite(
    element: ElementTree.Element,
    attribute: str,
    count: int,
    default: str | None,
    key: str,
    file: str,
) -> list[float]:
    """Read an attribute of finite numbers as a list: most are only checked, hundreds a load."""
    text = element.get(attribute, default)
    # Python's float reads more than a number of XML: other digits, 3_0, infinity.
    words = (text or "").split()
    values = [float(word) for word in words if _NUMBER.fullmatch(word)]
    right = len(words) == count == len(values) and max(map(abs, values)) <= LARGEST
    if not right:
        noun = "a finite number" if count == 1 else f"{count} finite numbers"
        allowed = f"{attribute} is {noun} of at most {LARGEST:g}"
        raise ModelError(file=file, key=key, value=text, allowed=allowed)
    return values


def origin(element: ElementTree.Element, key: str, file: str) -> tuple[FloatArray, FloatArray]:
    """Read the origin of an element: translation [m] and roll, pitch, yaw [rad]."""
    xyz, rpy = _origin(element, key, file)
    return np.array(xyz), np.array(rpy)


def _origin(element: ElementTree.Element, key: str, file: str) -> tuple[list[float], list[float]]:
    """Read the origin of an element as lists."""
    found = element.find("origin")
    if found is None:
        return [0.0] * 3, [0.0] * 3
    xyz = _finite(found, "xyz", 3, "0 0 0", f"{key} origin xyz", file)
    return xyz, _finite(found, "rpy", 3, "0 0 0", f"{key} origin rpy", file)


def rotation_from_rpy(rpy: FloatArray) -> FloatArray:
    """Rotation matrix of roll, pitch, yaw [rad], shape (3, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def spell_out(root: ElementTree.Element) -> bool:
    """Write the numbers of a checked URDF as Pinocchio's parser needs them, in place.

    That parser takes a number between spaces, or an inertia without one of its six parts, for none,
    and goes on with zero. Here spaces are taken away and missing parts are written as zero.

    Args:
        root: The ``robot`` element.

    Returns:
        Whether anything was changed.
    """
    changed = False
    for element in root.iter():
        missing = () if element.tag != "inertia" else _INERTIA
        for name in (*_NUMERIC, *missing):
            text = element.get(name, "0" if name in missing else "")
            plain = " ".join(text.split())
            if plain and plain != element.get(name):
                element.set(name, plain)
                changed = True
    return changed


def check_dynamics(joint: ElementTree.Element, key: str, file: str) -> float:
    """Damping of a joint [N s/m or N m s/rad]; friction is refused, for nothing computes it."""
    dynamics = joint.find("dynamics")
    if dynamics is None:
        return 0.0
    (damping,) = _finite(dynamics, "damping", 1, "0", f"{key} dynamics damping", file)
    if not 0.0 <= damping <= LARGEST:
        allowed = f"a damping from 0 to {LARGEST:g} N s/m or N m s/rad"
        raise ModelError(file=file, key=f"{key} dynamics damping", value=damping, allowed=allowed)
    (friction,) = _finite(dynamics, "friction", 1, "0", f"{key} dynamics friction", file)
    if friction:
        allowed = (
            "0: dry friction of joints is not computed; leave it out, or put a damping in its place"
        )
        raise ModelError(file=file, key=f"{key} dynamics friction", value=friction, allowed=allowed)
    return damping


def check_inertial(link: ElementTree.Element, name: str, moving: bool, file: str) -> float:
    """Return the mass of a link [kg]; a moving one has mass and inertia that a body can have."""
    inertial = link.find("inertial")
    if inertial is None:
        if moving:
            allowed = "a moving link needs mass and inertia"
            raise ModelError(file=file, key=f"link {name} inertial", value=None, allowed=allowed)
        return 0.0
    _origin(inertial, f"link {name} inertial", file)
    mass = inertial.find("mass")
    if mass is None:
        raise ModelError(file=file, key=f"link {name} mass", value=None, allowed="a positive mass")
    (value,) = _finite(mass, "value", 1, None, f"link {name} mass", file)
    if value <= 0.0:
        raise ModelError(
            file=file, key=f"link {name} mass", value=value, allowed="a positive mass in kg"
        )
    _check_inertia(inertial, f"link {name} inertia", file)
    return value


def _check_inertia(inertial: ElementTree.Element, key: str, file: str) -> None:
    """Principal inertias are positive and satisfy the triangle inequality."""
    inertia = inertial.find("inertia")
    if inertia is None:
        allowed = "an inertia about the centre of mass"
        raise ModelError(file=file, key=key, value=None, allowed=allowed)
    xx, xy, xz, yy, yz, zz = (
        _finite(inertia, f"i{part}", 1, "0", f"{key} i{part}", file)[0]
        for part in ("xx", "xy", "xz", "yy", "yz", "zz")
    )
    principal = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    values = [float(item) for item in principal]
    if values[0] <= 0.0:
        allowed = "positive principal inertias in kg m2"
        raise ModelError(file=file, key=key, value=values, allowed=allowed)
    if values[2] > (values[0] + values[1]) * (1.0 + URDF_TOLERANCE):
        allowed = (
            "no body has a principal inertia above the sum of the other two "
            f"({values[2]:g} > {values[0] + values[1]:g} kg m2; ixx = {xx:g}, iyy = {yy:g}, "
            f"izz = {zz:g})"
        )
        raise ModelError(file=file, key=key, value=values, allowed=allowed)


def check_colours(root: ElementTree.Element, file: str) -> None:
    """Refuse colours that are no four numbers; a viewer would stumble over them."""
    for colour in root.iter("color"):
        _finite(colour, "rgba", 4, None, "color", file)


def check_shapes(
    link: ElementTree.Element, name: str, file: str, mesh_folder: Path
) -> tuple[str, ...]:
    """Check sizes and mesh paths of a link's shapes; return the names of the collision elements."""
    names = []
    for tag in ("visual", "collision"):
        for place, element in enumerate(link.findall(tag)):
            shape = element.get("name") or f"{name}_{place}"
            key = f"link {name} {tag} {shape}"
            if tag == "collision":
                names.append(shape)
            _origin(element, key, file)
            geometry = element.find("geometry")
            solids = [] if geometry is None else [item for item in geometry if _is_tag(item)]
            if len(solids) != 1 or solids[0].tag not in (*_ATTRIBUTES, "mesh"):
                found = [str(item.tag) for item in solids]
                allowed = f"one geometry out of {', '.join((*_ATTRIBUTES, 'mesh'))}"
                raise ModelError(file=file, key=key, value=found, allowed=allowed)
            if solids[0].tag == "mesh":
                filename = solids[0].get("filename", "")
                if tag == "collision":
                    mesh_path(filename, mesh_folder, key, file)
                else:
                    # Only a viewer opens it. A run, also one saved on another machine, does not
                    # depend on pictures, and a load does not wait for the file system.
                    path_inside(filename, key, file)
            else:
                _check_sizes(solids[0], key, file)
    return tuple(names)


def _is_tag(element: ElementTree.Element) -> bool:
    """Whether a child is an element and not a comment."""
    return isinstance(element.tag, str)


def _check_sizes(solid: ElementTree.Element, key: str, file: str) -> None:
    """Sizes of a primitive are positive."""
    for attribute in _ATTRIBUTES[solid.tag]:
        count = 3 if attribute == "size" else 1
        sizes = _finite(solid, attribute, count, None, f"{key} {attribute}", file)
        if min(sizes) <= 0.0:
            raise ModelError(
                file=file, key=f"{key} {attribute}", value=sizes, allowed="sizes above 0 m"
            )


def path_inside(filename: str, key: str, file: str) -> str:
    """Path of a mesh in the model folder, for which a package stands.

    Args:
        filename: Path in the URDF.
        key: Place in the URDF, for messages.
        file: File name, for messages.

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
        mesh_folder: The model folder.
        key: Place in the URDF, for messages.
        file: File name, for messages.

    Raises:
        ModelError: The path leaves the folder or names no file.
    """
    path = followed(mesh_folder / path_inside(filename, key, file))
    if not path.is_relative_to(followed(mesh_folder)):
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=_INSIDE)
    if not path.is_file():
        allowed = f"a mesh file in the model folder {mesh_folder}"
        raise ModelError(file=file, key=f"{key} mesh", value=filename, allowed=allowed)
    _check_package(filename, mesh_folder, key, file)
    return path
