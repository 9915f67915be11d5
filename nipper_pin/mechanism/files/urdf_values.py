"""Reading and checking what belongs to one element of a URDF: numbers, placements, inertias."""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import ModelError
from ...tolerances.mechanics import URDF_TOLERANCE
from .description import LARGEST

_ABOUT = "an inertia about the centre of mass"
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
# What Python reads and what XML Schema calls so.
_INFINITE = re.compile(r"[+-]?inf(?:inity)?", re.IGNORECASE)
_HALF_TURNS = {("rad", "pi"), ("rad", "-pi")}


def finite(
    element: ElementTree.Element,
    attribute: str,
    count: int,
    default: str | None,
    key: str,
    file: str,
) -> list[float]:
    """Read an attribute of finite numbers as a list: most are only checked, hundreds a load.

    Args:
        default: Its text where it is missing; None if it must be there.

    Raises:
        ModelError: It has others, or too large ones.
    """
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
    found = element.find("origin")
    if found is None:
        return np.zeros(3), np.zeros(3)
    xyz = finite(found, "xyz", 3, "0 0 0", f"{key} origin xyz", file)
    rpy = finite(found, "rpy", 3, "0 0 0", f"{key} origin rpy", file)
    return np.array(xyz), np.array(rpy)


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


def placed(xyz: FloatArray, rpy: FloatArray) -> pin.SE3:
    """Placement by translation [m] and roll, pitch, yaw [rad].

    By the unit quaternion of the three angles, as other readers of URDF have it to the last bit.
    """
    if not rpy.any():
        return pin.SE3(np.eye(3), xyz)
    half = (0.5 * rpy).tolist()
    (cr, cp, cy), (sr, sp, sy) = map(math.cos, half), map(math.sin, half)
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    w = cr * cp * cy + sr * sp * sy
    size = math.sqrt(x * x + y * y + z * z + w * w)
    return pin.SE3(pin.Quaternion(w / size, x / size, y / size, z / size).matrix(), xyz)


def placement(element: ElementTree.Element, key: str, file: str) -> pin.SE3:
    """Placement that the origin of an element gives it."""
    return placed(*origin(element, key, file))


def check_limits(joint: ElementTree.Element, unit: str, key: str, file: str) -> None:
    """Refuse limits of a joint that are no numbers.

    Infinite ones may say that there is none, and so do those of half a turn, also in words.
    """
    limit = joint.find("limit")
    for side, none in (("lower", -math.inf), ("upper", math.inf)):
        text = None if limit is None else limit.get(side)
        if text is None:
            continue
        word = text.strip()
        if _NUMBER.fullmatch(word):
            continue
        if (_INFINITE.fullmatch(word) and float(word) == none) or (unit, word) in _HALF_TURNS:
            continue
        allowed = f"{side} is a number in {unit}, such as 0.2, or left out where nothing limits"
        raise ModelError(file=file, key=f"{key} limit {side}", value=text, allowed=allowed)


def read_damping(joint: ElementTree.Element, key: str, file: str) -> float:
    """Damping of a joint [N s/m or N m s/rad]; friction is refused, for nothing computes it."""
    dynamics = joint.find("dynamics")
    if dynamics is None:
        return 0.0
    (damping,) = finite(dynamics, "damping", 1, "0", f"{key} dynamics damping", file)
    if not 0.0 <= damping <= LARGEST:
        allowed = f"a damping from 0 to {LARGEST:g} N s/m or N m s/rad"
        raise ModelError(file=file, key=f"{key} dynamics damping", value=damping, allowed=allowed)
    (friction,) = finite(dynamics, "friction", 1, "0", f"{key} dynamics friction", file)
    if friction:
        allowed = (
            "0: dry friction of joints is not computed; leave it out, or put a damping in its place"
        )
        raise ModelError(file=file, key=f"{key} dynamics friction", value=friction, allowed=allowed)
    return damping


def read_inertial(
    link: ElementTree.Element, name: str, moving: bool, file: str
) -> pin.Inertia | None:
    """Inertia of a link in its frame; None of one without mass, and of one that cannot move."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    place = placement(inertial, f"link {name} inertial", file)
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    key, value, parts = f"link {name} inertia", 0.0, [0.0]
    if mass is not None:
        (value,) = finite(mass, "value", 1, None, f"link {name} mass", file)
    if inertia is not None:
        parts = [
            finite(inertia, f"i{part}", 1, "0", f"{key} i{part}", file)[0]
            for part in ("xx", "xy", "xz", "yy", "yz", "zz")
        ]
    if moving and (mass is None or inertia is None):
        part, allowed = ("mass", "a positive mass") if mass is None else ("inertia", _ABOUT)
        raise ModelError(file=file, key=f"link {name} {part}", value=None, allowed=allowed)
    if not moving or (value == 0.0 and not any(parts)):
        return None
    if value <= 0.0:
        raise ModelError(
            file=file, key=f"link {name} mass", value=value, allowed="a positive mass in kg"
        )
    return place.act(pin.Inertia(value, np.zeros(3), _tensor(parts, key, file)))


def _tensor(parts: list[float], key: str, file: str) -> FloatArray:
    """Inertia tensor; its principal values are those of a body, or zero for a point."""
    xx, xy, xz, yy, yz, zz = parts
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    values = [float(item) for item in np.linalg.eigvalsh(tensor)]
    if values[0] < -URDF_TOLERANCE * values[2] or values[2] < 0.0:
        allowed = "positive principal inertias in kg m2, or zeros for a point mass"
        raise ModelError(file=file, key=key, value=values, allowed=allowed)
    if values[2] > (values[0] + values[1]) * (1.0 + URDF_TOLERANCE):
        allowed = (
            "no body has a principal inertia above the sum of the other two "
            f"({values[2]:g} > {values[0] + values[1]:g} kg m2; ixx = {xx:g}, iyy = {yy:g}, "
            f"izz = {zz:g})"
        )
        raise ModelError(file=file, key=key, value=values, allowed=allowed)
    return tensor
