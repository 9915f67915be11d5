"""Turning a URDF of any plane into the side view, whose x is forward, z up and y into the page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...tolerances.mechanics import IN_PLANE_RAD, URDF_TOLERANCE
from .plane import JointAxis, Plane, direction_text, find_plane
from .urdf_parts import Urdf, UrdfJoint, UrdfLink
from .urdf_values import placed


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
    plane = find_plane(_axes(urdf, world), file)
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

    Args:
        urdf: The URDF, in the side view.

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
