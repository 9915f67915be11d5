"""Contact points and normals of stops, found from collision shapes when a model is loaded."""

from __future__ import annotations

import math
from typing import NoReturn

import coal
import numpy as np
import pinocchio as pin

from ...errors import ModelError, looked_up
from ...tolerances.mechanics import ACROSS_PLANE, DISTANCE_ACCURACY_M, TOUCH_TOLERANCE_M
from ...units import MM_PER_M, coordinate_text
from ..files.description import ContactDescription
from ..files.urdf_parts import UrdfJoint
from ..parts import Contact, Stop
from ..scale import reach, unit_of, written
from .lips import Lips, Meeting, Shape, farthest, meet
from .placements import supports
from .tree import Tree

_IN_PLANE = np.array([1.0, 0.0, 1.0])
# Each pair of shapes of two bodies is looked at in every step of the search.
_MOST_PAIRS = 100


def find_contact(contact: ContactDescription, stop: Stop, tree: Tree) -> Contact:
    """Find the contact of the two bodies of a stop where it is closed, all other coordinates zero.

    Its joint moves the upper body and not the lower one.

    Raises:
        UnknownNameError: A body does not exist.
        ModelError: The bodies do not touch at that coordinate, opening does not part them, or one
            is neither body of the joint.
    """
    joint, key = tree.urdf.joints[tree.joints[stop.index].name], f"stops.{stop.name}.contact"
    lower = _body(contact.lower, joint, tree, f"{key}.lower", moved=False)
    upper = _body(contact.upper, joint, tree, f"{key}.upper", moved=True)
    if len(lower) * len(upper) > _MOST_PAIRS:
        value = f"{len(lower)} and {len(upper)} shapes"
        allowed = f"at most {_MOST_PAIRS} pairs; name the collision elements that touch"
        raise ModelError(file=tree.file, key=key, value=value, allowed=allowed)
    frame = tree.placements[tree.model.getJointId(joint.name)]
    unit_m = unit_of(reach(tree.model, (), ()))
    lips = Lips(
        lower=lower,
        upper=upper,
        slides=joint.kind == "prismatic",
        origin=frame.translation,
        axis=frame.rotation @ np.array(joint.axis),
        unit_m=unit_m,
        # The round-off of places is proportional to them.
        accuracy_m=DISTANCE_ACCURACY_M * max(unit_m, farthest([*lower, *upper])),
        within_m=TOUCH_TOLERANCE_M * written(unit_m),
    )
    meeting = meet(lips, stop.at, stop.sense)
    _check_touch(meeting, lips.within_m, joint, stop, contact, tree.file)
    point = meeting.point * _IN_PLANE
    normal = meeting.normal * _IN_PLANE
    normal /= np.linalg.norm(normal)
    lever = stop.sense * float(normal @ lips.velocity(point))
    return Contact(point=point, normal=normal, lever_m=lever, closing_coordinate=meeting.closing)


def _body(name: str, joint: UrdfJoint, tree: Tree, key: str, *, moved: bool) -> list[Shape]:
    """Shapes of a body, which the joint of the stop moves or does not."""
    identity = tree.model.getJointId(joint.name)
    shapes = _shapes(name, tree, key)
    if any((identity in supports(tree.model, item.parentJoint)) != moved for item in shapes):
        allowed = f"a body that joint {joint.name} {'moves' if moved else 'does not move'}"
        raise ModelError(file=tree.file, key=key, value=name, allowed=allowed)
    home = identity if moved else tree.model.parents[identity]
    for item in shapes:
        if item.parentJoint != home:
            _refuse_third(item, name, joint, tree, key, moved=moved)
    return [
        Shape(_planar(item), tree.placements[item.parentJoint] * item.placement) for item in shapes
    ]


def _refuse_third(
    item: pin.GeometryObject, name: str, joint: UrdfJoint, tree: Tree, key: str, *, moved: bool
) -> NoReturn:
    """Refuse a lip on a body that moves against both bodies of the joint."""
    link, own = tree.model.frames[item.parentFrame].name, joint.child if moved else joint.parent
    value = name if name == link else f"{name} of link {link}"
    allowed = (
        f"a lip on link {own}, or on one fixed to it: joint {joint.name} of the stop parts "
        f"{joint.parent} and {joint.child}, and {link} moves against both. Draw the "
        f"lip on {own}, or put the stop on the joint between the two bodies that touch"
    )
    raise ModelError(file=tree.file, key=key, value=value, allowed=allowed)


def _shapes(name: str, tree: Tree, key: str) -> list[pin.GeometryObject]:
    """Geometry objects of a collision element, or of all elements of a link."""
    urdf, geometry, file = tree.urdf, tree.geometry, tree.file
    known = {link: names for link, names in urdf.shapes.items() if names}
    known |= {item: (item,) for names in known.values() for item in names}
    if name in urdf.shapes and name not in known:
        raise ModelError(
            file=tree.urdf_file,
            key=f"link {name} collision",
            value=None,
            allowed=f"{key} in {file} needs a collision shape on this link",
        )
    names = looked_up("link or collision element", name, known, f"{file}: {key}")
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


def _check_touch(
    meeting: Meeting,
    within_m: float,
    joint: UrdfJoint,
    stop: Stop,
    contact: ContactDescription,
    file: str,
) -> None:
    """Refuse bodies that do not touch where the stop is closed."""
    if abs(meeting.distance) <= within_m and math.isfinite(meeting.closing):
        return
    apart = f"{MM_PER_M * meeting.distance:.6g} mm apart"
    if meeting.distance == -math.inf:
        apart = "overlapping"
    at, closing = (coordinate_text(item, joint.kind) for item in (stop.at, meeting.closing))
    value = f"{contact.lower} and {contact.upper}, {apart} at {joint.name} = {at}"
    if not math.isfinite(meeting.closing):
        allowed = (
            f"a {'growing' if stop.sense > 0.0 else 'falling'} coordinate of {joint.name} must "
            "move the upper body away from the lower one"
        )
    else:
        allowed = (
            f"the bodies must touch within {MM_PER_M * within_m:g} mm where the "
            f"coordinate is {at}; their shapes in the URDF touch at {joint.name} = {closing}"
        )
    key = f"stops.{stop.name}.contact"
    raise ModelError(file=file, key=key, value=value, allowed=allowed)
