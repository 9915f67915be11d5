"""Contact points and normals of stops, found from collision shapes when a model is loaded."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import ModelError, UnknownNameError
from ...tolerances.mechanics import ACROSS_PLANE, DISTANCE_ACCURACY_M, TOUCH_STEP, TOUCH_TOLERANCE_M
from ...units import MM_PER_M
from ..files.description import ContactDescription
from ..files.urdf_parts import UrdfJoint
from ..mechanism import Contact
from ..scale import reach, unit_of, written
from .placements import supports
from .tree import Tree

_ITERATIONS = 12
# Each pair of shapes of two bodies is looked at in every step of the search.
_MOST_PAIRS = 100


@dataclass(frozen=True)
class _Shape:
    """A collision shape and its world placement at q = 0."""

    solid: coal.CollisionGeometry
    placement: pin.SE3


@dataclass(frozen=True)
class _Gap:
    """Signed distance of two shapes, the nearest points [m] and the normal from the first on."""

    distance: float
    first: FloatArray
    second: FloatArray
    normal: FloatArray


class _Asked(NamedTuple):
    """Configuration in which a stop is closed, and its name in messages.

    Attributes:
        pair: Names of both bodies.
        key: Path of the contact in the TOML file.
        file: Name of that file.
        sense: 1 if the bodies part with a growing coordinate, -1 with a falling one.
        at: Coordinate at which the stop is closed [rad or m].
        unit_m: The size of the machine [m].
    """

    pair: str
    key: str
    file: str
    sense: float
    at: float
    unit_m: float


def find_contact(
    contact: ContactDescription, joint_name: str, tree: Tree, *, key: str, sense: float, at: float
) -> Contact:
    """Find the contact of the two bodies of a stop.

    Args:
        contact: Names of the bodies.
        joint_name: Joint of the stop; it moves the upper body and not the lower one.
        tree: The tree with its collision shapes.
        key: Path of the contact in the TOML file, for messages.
        sense: 1 if the bodies part with a growing coordinate, -1 with a falling one.
        at: Coordinate at which the stop is closed, all others being zero [rad or m].

    Raises:
        UnknownNameError: A body does not exist.
        ModelError: The bodies do not touch at that coordinate or opening does not part them.
    """
    joint = tree.urdf.joints[joint_name]
    lower = _body(contact.lower, joint, tree, f"{key}.lower", moved=False)
    upper = _body(contact.upper, joint, tree, f"{key}.upper", moved=True)
    if len(lower) * len(upper) > _MOST_PAIRS:
        value = f"{len(lower)} and {len(upper)} shapes"
        allowed = f"at most {_MOST_PAIRS} pairs; name the collision elements that touch"
        raise ModelError(file=tree.file, key=key, value=value, allowed=allowed)
    frame = tree.placements[tree.model.getJointId(joint.name)]
    axis = frame.rotation @ np.array(joint.axis)
    pair, unit_m = f"{contact.lower} and {contact.upper}", unit_of(reach(tree.model, (), ()))
    asked = _Asked(pair, key, tree.file, sense, at, unit_m)
    start = _nearest(lower, upper, _motion(at, joint, frame, axis), unit_m)
    closing, gap = _close(lower, upper, joint, frame, axis, asked)
    _check_touch(closing, start, joint, asked)
    # The search ends at the closing coordinate, where the bodies have one common point.
    point = 0.5 * (gap.first + gap.second)
    point[1] = 0.0
    normal = gap.normal * np.array([1.0, 0.0, 1.0])
    normal /= np.linalg.norm(normal)
    lever = sense * float(normal @ _velocity(point, joint, frame, axis))
    return Contact(point=point, normal=normal, lever_m=lever, closing_coordinate=closing)


def _body(name: str, joint: UrdfJoint, tree: Tree, key: str, *, moved: bool) -> list[_Shape]:
    """Shapes of a body, which the joint of the stop moves or does not."""
    identity = tree.model.getJointId(joint.name)
    shapes = _shapes(name, tree, key)
    if any((identity in supports(tree.model, item.parentJoint)) != moved for item in shapes):
        allowed = f"a body that joint {joint.name} {'moves' if moved else 'does not move'}"
        raise ModelError(file=tree.file, key=key, value=name, allowed=allowed)
    return [
        _Shape(_planar(item), tree.placements[item.parentJoint] * item.placement) for item in shapes
    ]


def _shapes(name: str, tree: Tree, key: str) -> list[pin.GeometryObject]:
    """Geometry objects of a collision element, or of all elements of a link."""
    urdf, geometry, file = tree.urdf, tree.geometry, tree.file
    elements = {item for names in urdf.shapes.values() for item in names}
    if name in elements:
        names: Iterable[str] = (name,)
    elif name in urdf.shapes:
        names = urdf.shapes[name]
        if not names:
            raise ModelError(
                file=tree.urdf_file,
                key=f"link {name} collision",
                value=None,
                allowed=f"{key} in {file} needs a collision shape on this link",
            )
    else:
        known = elements | {link for link, found in urdf.shapes.items() if found}
        raise UnknownNameError(
            kind="link or collision element", name=name, known=known, where=f"{file}: {key}"
        )
    return [geometry.geometryObjects[geometry.getGeometryId(item)] for item in names]


def _planar(item: pin.GeometryObject) -> coal.CollisionGeometry:
    """Shape to search with: the same section in the plane, found as precisely as possible.

    The search is iterative and stops at about 1e-6 m on the flank of a cylinder. It is exact to
    round-off for a capsule, which is a segment with a radius, and the two have the same section
    if their axis is y.
    """
    solid = item.geometry
    axis = item.placement.rotation[:, 2]
    if isinstance(solid, coal.Cylinder) and abs(abs(axis[1]) - 1.0) < ACROSS_PLANE:
        return coal.Capsule(solid.radius, 2.0 * solid.halfLength)
    return solid


def _motion(coordinate: float, joint: UrdfJoint, frame: pin.SE3, axis: FloatArray) -> pin.SE3:
    """World motion of the moved body when the joint stands at a coordinate."""
    if joint.kind == "prismatic":
        return pin.SE3(np.eye(3), coordinate * axis)
    rotation = pin.exp3(coordinate * axis)
    return pin.SE3(rotation, frame.translation - rotation @ frame.translation)


def _velocity(point: FloatArray, joint: UrdfJoint, frame: pin.SE3, axis: FloatArray) -> FloatArray:
    """Velocity of a point of the moved body per unit rate of the joint."""
    if joint.kind == "prismatic":
        return axis
    return np.cross(axis, point - frame.translation)


def _nearest(lower: list[_Shape], upper: list[_Shape], motion: pin.SE3, unit_m: float) -> _Gap:
    """Least signed distance of two bodies."""
    request = coal.DistanceRequest()
    request.gjk_tolerance = request.epa_tolerance = DISTANCE_ACCURACY_M * unit_m
    request.gjk_max_iterations = 1000
    request.epa_max_iterations = 1000
    best = _Gap(math.inf, np.zeros(3), np.zeros(3), np.zeros(3))
    for one in lower:
        for other in upper:
            result = coal.DistanceResult()
            moved = motion * other.placement
            distance = coal.distance(
                one.solid,
                coal.Transform3s(one.placement.rotation, one.placement.translation),
                other.solid,
                coal.Transform3s(moved.rotation, moved.translation),
                request,
                result,
            )
            if distance < best.distance:
                best = _Gap(
                    float(distance),
                    np.array(result.getNearestPoint1()),
                    np.array(result.getNearestPoint2()),
                    np.array(result.normal),
                )
    return best


def _close(
    lower: list[_Shape],
    upper: list[_Shape],
    joint: UrdfJoint,
    frame: pin.SE3,
    axis: FloatArray,
    asked: _Asked,
) -> tuple[float, _Gap]:
    """Move the upper body until it touches: Newton's method on the signed distance.

    Returns:
        Closing coordinate, NaN if the motion does not part or join the bodies, and the gap there.
    """
    coordinate, unit_m = asked.at, asked.unit_m
    last = TOUCH_STEP * (unit_m if joint.kind == "prismatic" else 1.0)
    gap = _nearest(lower, upper, _motion(coordinate, joint, frame, axis), unit_m)
    for _ in range(_ITERATIONS):
        slope = float(gap.normal @ _velocity(gap.second, joint, frame, axis))
        if not asked.sense * slope > 0.0:
            return math.nan, gap
        step = -gap.distance / slope
        coordinate += step
        gap = _nearest(lower, upper, _motion(coordinate, joint, frame, axis), unit_m)
        if abs(step) < last:
            break
    return coordinate, gap


def _check_touch(closing: float, start: _Gap, joint: UrdfJoint, asked: _Asked) -> None:
    """Refuse bodies that do not touch where the stop is closed."""
    within_m = TOUCH_TOLERANCE_M * written(asked.unit_m)
    if abs(start.distance) <= within_m and math.isfinite(closing):
        return
    apart = MM_PER_M * start.distance
    value = f"{asked.pair}, {apart:.6g} mm apart at {joint.name} = {_place(asked.at, joint)}"
    if not math.isfinite(closing):
        allowed = (
            f"a {'growing' if asked.sense > 0.0 else 'falling'} coordinate of {joint.name} must "
            "move the upper body away from the lower one"
        )
    else:
        allowed = (
            f"the bodies must touch within {MM_PER_M * within_m:g} mm where the "
            f"coordinate is {_place(asked.at, joint)}; their shapes in the URDF touch at "
            f"{joint.name} = {_place(closing, joint)}"
        )
    raise ModelError(file=asked.file, key=asked.key, value=value, allowed=allowed)


def _place(coordinate: float, joint: UrdfJoint) -> str:
    """Return a coordinate as text, in mm or degrees."""
    if joint.kind == "revolute":
        return f"{math.degrees(coordinate):.6g} deg"
    return f"{MM_PER_M * coordinate:.6g} mm"
