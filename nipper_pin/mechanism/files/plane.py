"""The plane that the joints of a URDF move in, and how it becomes the side view.

A machine is planar if all its hinges turn about one direction and no slide moves along it. The
side view looks at that plane with its z upwards, as far as it rises: x and z are the file's own for
a machine in its x-z plane, y and z for one in its y-z plane, x and y for one that lies flat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...errors import ModelError
from ...tolerances.mechanics import IN_PLANE_RAD

_UP = np.array([0.0, 0.0, 1.0])
_Y = np.array([0.0, 1.0, 0.0])


class JointAxis(NamedTuple):
    """Axis of a joint that moves.

    Attributes:
        joint: Its name.
        turns: Whether it is a hinge.
        axis: Unit axis at q = 0 in the axes of the root link, shape (3,).
        written: What the file has for it, for messages.
    """

    joint: str
    turns: bool
    axis: FloatArray
    written: object


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane of a machine.

    Attributes:
        axes: Axes x, y, z of the side view in the axes of the root link, shape (3, 3); y, into the
            page, is across the plane.
        off_rad: Largest angle by which the axis of a joint misses it [rad].
    """

    axes: FloatArray
    off_rad: float = 0.0

    @property
    def turned(self) -> bool:
        """Whether the side view is not the x-z plane of the file."""
        return not np.array_equal(self.axes, np.eye(3))

    @property
    def steepness(self) -> float:
        """Part of gravity that acts in the plane, along -z of the side view."""
        return float(self.axes[2, 2])


def find_plane(axes: Sequence[JointAxis], file: str) -> Plane:
    """Find the plane that all joints move in.

    Args:
        axes: Axes of the joints that move.

    Raises:
        ModelError: There is none; names the joint that leaves the plane of most others.
    """
    normal, off = _nearest(axes)
    if off.max() > IN_PLANE_RAD:
        raise _spatial(axes, off, normal, file)
    return Plane(_side_view(normal), float(off.max()))


def nearest_plane(axes: Sequence[JointAxis]) -> Plane:
    """The plane that most joints move in.

    Args:
        axes: Axes of the joints that move.
    """
    normal, off = _nearest(axes)
    return Plane(_side_view(normal), float(off.max()))


def _nearest(axes: Sequence[JointAxis]) -> tuple[FloatArray, FloatArray]:
    """Direction across the plane that most joints move in, and the angle by which each misses it.

    Angles [rad] have shape (joints,), or (1,) without any joint.
    """
    if not axes:
        return _Y, np.zeros(1)
    directions = np.array([item.axis for item in axes])
    turns = np.array([item.turns for item in axes])
    best, least = (_Y, np.zeros(1)), len(axes) + 1
    for candidate in _candidates(directions, turns):
        off = _off(directions, turns, candidate)
        outside = int(np.count_nonzero(off > IN_PLANE_RAD))
        if outside < least:
            best, least = (candidate, off), outside
        if not outside:
            break
    return best


def _off(directions: FloatArray, turns: FloatArray, normal: FloatArray) -> FloatArray:
    """Angle by which each axis misses the plane [rad]."""
    along = directions @ normal
    across = np.linalg.norm(directions - along[:, None] * normal, axis=1)
    angles: FloatArray = np.arcsin(np.clip(np.where(turns, across, np.abs(along)), 0.0, 1.0))
    return angles


def _candidates(directions: FloatArray, turns: FloatArray) -> list[FloatArray]:
    """Directions that may be across the plane, the likeliest first."""
    found: list[FloatArray] = []
    hinges = directions[turns]
    if not len(hinges):
        slides = directions
        # One direction of sliding: the upright plane through it, or x-z.
        across = [np.cross(slides[0], other) for other in (*slides[1:], _UP)]
        hinges = np.array([_Y, *(item for item in across if np.linalg.norm(item) > IN_PLANE_RAD)])
        hinges /= np.linalg.norm(hinges, axis=1, keepdims=True)
    for hinge in hinges:
        known = np.array(found).reshape(-1, 3)
        if not (np.linalg.norm(np.cross(known, hinge), axis=1) < IN_PLANE_RAD).any():
            found.append(_snapped(hinge))
    return found


def _snapped(direction: FloatArray) -> FloatArray:
    """The axis of the file that a direction is but for rounded angles, or the direction itself."""
    largest = int(np.argmax(np.abs(direction)))
    axis = np.zeros(3)
    axis[largest] = math.copysign(1.0, direction[largest])
    return axis if np.linalg.norm(direction - axis) < IN_PLANE_RAD else direction


def _side_view(normal: FloatArray) -> FloatArray:
    """Axes of the side view of the plane across a direction, shape (3, 3)."""
    if abs(normal[2]) == 1.0:
        return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    up = _UP - normal[2] * normal
    up /= np.linalg.norm(up)
    right = np.cross(normal, up)
    # From the side from which x, or else y, of the file points to the right.
    sense = math.copysign(1.0, right[np.argmax(np.abs(right))])
    # Without negative zeros: the axes of a file in the x-z plane are the unit matrix.
    return np.array([sense * right, sense * normal, up]) + 0.0


def _spatial(
    axes: Sequence[JointAxis], off: FloatArray, normal: FloatArray, file: str
) -> ModelError:
    """The error of a machine that is not planar."""
    item = axes[int(np.argmax(off > IN_PLANE_RAD))]
    inside = [other.joint for other, angle in zip(axes, off, strict=True) if angle <= IN_PLANE_RAD]
    others = ", ".join(inside[:3]) + (f" and {len(inside) - 3} more" if len(inside) > 3 else "")
    allowed = (
        f"an axis {'along' if item.turns else 'across'} {direction_text(normal).lstrip('-')} of "
        f"the root link, as the plane of {others} has it: in a planar machine all hinges are "
        "parallel, and all slides across them"
    )
    return ModelError(
        file=file, key=f"joint {item.joint} axis", value=item.written, allowed=allowed
    )


def direction_text(direction: FloatArray) -> str:
    """A direction in words: an axis of the file, or its three numbers.

    Args:
        direction: Unit direction in the axes of the root link, shape (3,).
    """
    for place, name in enumerate("xyz"):
        if abs(direction[place]) == 1.0:
            return f"{'-' if direction[place] < 0.0 else ''}{name}"
    return "(" + ", ".join(f"{part:.6g}" for part in direction.round(9) + 0.0) + ")"
