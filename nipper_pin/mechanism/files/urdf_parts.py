"""The parts of a URDF that a mechanism is built from, turned into the side view.

A machine is planar if all its hinges turn about one direction and no slide moves along it. The
side view looks at that plane with its z upwards, as far as it rises: x and z are the file's own for
a machine in its x-z plane, y and z for one in its y-z plane, x and y for one that lies flat. In it
x is forward, z up and y into the page.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import ModelError
from ...tolerances.mechanics import IN_PLANE_RAD, URDF_TOLERANCE
from .urdf_shapes import UrdfShape
from .urdf_values import placed

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


def nearest_plane(axes: Sequence[JointAxis]) -> Plane:
    """The plane that most joints move in."""
    if not axes:
        return Plane(np.eye(3))
    normal, least = _Y, len(axes) + 1
    for candidate in _candidates(axes):
        outside = int(np.count_nonzero(_off(axes, candidate) > IN_PLANE_RAD))
        if outside < least:
            normal, least = candidate, outside
        if not outside:
            break
    return Plane(_side_view(normal), float(_off(axes, normal).max()))


def _off(axes: Sequence[JointAxis], normal: FloatArray) -> FloatArray:
    """Angle by which each axis misses the plane across a direction [rad], shape (joints,)."""
    directions = np.array([item.axis for item in axes])
    turns = np.array([item.turns for item in axes])
    along = directions @ normal
    across = np.linalg.norm(directions - along[:, None] * normal, axis=1)
    angles: FloatArray = np.arcsin(np.clip(np.where(turns, across, np.abs(along)), 0.0, 1.0))
    return angles


def _candidates(axes: Sequence[JointAxis]) -> list[FloatArray]:
    """Directions that may be across the plane, the likeliest first."""
    found: list[FloatArray] = []
    hinges = np.array([item.axis for item in axes if item.turns])
    if not len(hinges):
        slides = [item.axis for item in axes]
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


def _spatial(axes: Sequence[JointAxis], plane: Plane, file: str) -> ModelError:
    """The error of a machine that is not planar."""
    normal = plane.axes[1]
    off = _off(axes, normal)
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


@dataclass(frozen=True, kw_only=True)
class UrdfJoint:
    """One joint of the URDF.

    Attributes:
        kind: "revolute", "prismatic" or "fixed".
        placement: Of the child's frame in the parent's at coordinate zero.
        axis: Unit axis of rotation or translation in the joint frame; zero if fixed.
        damping: Of its <dynamics> [N s/m or N m s/rad].
        mimic: The joint that it follows, and its coordinate by the other's [1, m/rad or rad/m];
            None if it follows none.
        written: What the file has as its axis, for messages.
    """

    name: str
    kind: Literal["revolute", "prismatic", "fixed"]
    parent: str
    child: str
    placement: pin.SE3
    axis: tuple[float, float, float]
    damping: float = 0.0
    mimic: tuple[str, float] | None = None
    written: object = None


@dataclass(frozen=True, kw_only=True)
class UrdfLink:
    """One link of the URDF.

    Attributes:
        inertia: Its inertia in its frame; None without mass, and of a link that cannot move.
        shapes: Its collision shapes in the order of the file.
    """

    inertia: pin.Inertia | None = None
    shapes: tuple[UrdfShape, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Urdf:
    """A checked URDF, in the side view: y of every frame points into the page.

    Attributes:
        root: Name of the root link.
        plane: The plane of the file that became the side view.
        own_axes: Frames of the file in the frames here where they differ, by link, shape (3, 3).
    """

    root: str
    links: Mapping[str, UrdfLink]
    joints: Mapping[str, UrdfJoint]
    plane: Plane
    own_axes: Mapping[str, FloatArray]

    @property
    def shapes(self) -> dict[str, tuple[str, ...]]:
        """Names of the collision elements of each link, in the order of the file."""
        return {
            name: tuple(shape.name for shape in link.shapes) for name, link in self.links.items()
        }

    def downwards(self) -> list[UrdfJoint]:
        """All joints, depth first and by name: the order of the coordinates of a tree."""
        below: dict[str, list[UrdfJoint]] = {}
        for joint in sorted(self.joints.values(), key=lambda joint: joint.name, reverse=True):
            below.setdefault(joint.parent, []).append(joint)
        found, waiting = [], below.get(self.root, [])
        while waiting:
            found.append(waiting.pop())
            waiting += below.get(found[-1].child, [])
        return found


def in_side_view(urdf: Urdf, file: str) -> Urdf:
    """Turn a URDF, as its file has it, into the side view.

    A frame whose y is across the plane already stays; any other becomes parallel to the world at
    q = 0. The joints come to lie exactly in the plane: programs write half a turn as three angles,
    of which one is pi but for round-off, or angles of a few digits, and a pin whose parts are not
    exactly parallel would pull across the plane.

    Raises:
        ModelError: It is not planar; names the joint that is not.
    """
    joints = urdf.downwards()
    world = {urdf.root: np.eye(3)}
    for joint in joints:
        world[joint.child] = world[joint.parent] @ joint.placement.rotation
    axes = _axes(urdf, world)
    plane = nearest_plane(axes)
    if plane.off_rad > IN_PLANE_RAD:
        raise _spatial(axes, plane, file)
    if plane.turned:
        world = {link: plane.axes @ rotation for link, rotation in world.items()}
    # Frames here in the frames of the file; the others stay.
    turned = {link: rotation.T for link, rotation in world.items() if not upright(rotation)}
    moved = {joint.name: _joint(joint, world, turned) for joint in joints}
    links = {
        name: _link(link, turned[name]) if name in turned else link
        for name, link in urdf.links.items()
    }
    return replace(
        urdf,
        links=links,
        joints={name: moved[name] for name in urdf.joints},
        plane=plane,
        own_axes={link: rotation.T for link, rotation in turned.items()},
    )


def _axes(urdf: Urdf, world: Mapping[str, FloatArray]) -> list[JointAxis]:
    """Axes of the joints that move, in the order of the file."""
    found = []
    for joint in urdf.joints.values():
        if joint.kind != "fixed":
            local = np.array(joint.axis) / max(map(abs, joint.axis))
            axis = world[joint.child] @ local / np.linalg.norm(local)
            found.append(JointAxis(joint.name, joint.kind == "revolute", axis, joint.written))
    return found


def upright(rotation: FloatArray) -> bool:
    """Whether the y axis of a frame points into the page.

    Args:
        rotation: The frame in the side view, shape (3, 3).
    """
    return bool(rotation[1, 1] > 0.0 and np.hypot(rotation[0, 1], rotation[2, 1]) < IN_PLANE_RAD)


def _joint(
    joint: UrdfJoint, world: Mapping[str, FloatArray], turned: Mapping[str, FloatArray]
) -> UrdfJoint:
    """A joint between frames of the side view, exactly in the plane."""
    place, above, below = joint.placement, turned.get(joint.parent), turned.get(joint.child)
    xyz, rotation = place.translation, place.rotation
    if above is not None:
        xyz, rotation = above.T @ xyz, above.T @ rotation
    if below is not None:
        rotation = rotation @ below
    both = above is not None and below is not None
    if above is not None or below is not None or rotation[1].tolist() != [0.0, 1.0, 0.0]:
        pitch = 0.0 if both else math.atan2(rotation[0, 2], rotation[0, 0])
        place = placed(xyz, np.array([0.0, pitch, 0.0]))
    axis = joint.axis
    if joint.kind == "revolute":
        axis = (0.0, math.copysign(1.0, (world[joint.child] @ np.array(axis))[1]), 0.0)
    elif joint.kind == "prismatic":
        axis = _along(np.array(axis) if below is None else below.T @ np.array(axis))
    return replace(joint, placement=place, axis=axis)


def _along(axis: FloatArray) -> tuple[float, float, float]:
    """Unit axis of a slide, in the plane."""
    x, z = float(axis[0]), float(axis[2])
    # A power of two changes no digit, and keeps squares in the range of doubles.
    _, power = math.frexp(max(abs(x), abs(z)))
    x, z = math.ldexp(x, -power), math.ldexp(z, -power)
    length = math.sqrt(x * x + z * z)
    return x / length, 0.0, z / length


def _link(link: UrdfLink, turn: FloatArray) -> UrdfLink:
    """A link in its new frame."""
    own = pin.SE3(turn.T, np.zeros(3))
    inertia = None if link.inertia is None else own.act(link.inertia)
    shapes = tuple(replace(item, placement=own * item.placement) for item in link.shapes)
    return UrdfLink(inertia=inertia, shapes=shapes)


def side_view_text(urdf: Urdf) -> str:
    """Say how a URDF became the side view, and which hinges turn clockwise in it.

    Returns:
        One sentence; empty if its plane is x-z and every axis is exactly ``0 -1 0`` or in it.
    """
    plane = urdf.plane
    hinges = [joint for joint in urdf.joints.values() if joint.kind == "revolute"]
    clockwise = [joint.name for joint in hinges if joint.axis[1] > 0.0]
    words = _plane_words(plane) if plane.turned else []
    if clockwise:
        which = ", ".join(clockwise)
        if len(clockwise) == len(hinges) and len(hinges) > 1:
            which = f"all hinges ({which})"
        words.append(f"coordinates of {which} grow clockwise in the side view, by their axes")
    if plane.off_rad > URDF_TOLERANCE:
        off = math.degrees(plane.off_rad)
        words.append(f"axes up to {off:.2g} deg out of the plane of the others are put into it")
    return "; ".join(words)


def _plane_words(plane: Plane) -> list[str]:
    """Which plane of the file is seen, and what gravity does in it."""
    right, _, up = (direction_text(axis) for axis in plane.axes)
    words = [f"the plane of {right} and {up} of the URDF is the side view here, as x and z"]
    if plane.steepness == 0.0:
        words.append("gravity, along -z of the URDF, acts across it and moves nothing")
    elif plane.steepness < 1.0:
        words.append(f"{plane.steepness:.6g} of gravity acts in it, along -z of the side view")
    return words
