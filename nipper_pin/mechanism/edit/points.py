"""Points of a model in its touch configuration: where they stand, and moving them.

A *point* is a hinge or a named frame. Closures are cut pins, so two points can be one pin.

All coordinates are zero at touch, and closures and contacts are checked there. A dimension can
therefore not be changed alone: a pin moves together with everything that meets in it. Moving a
point means:

* both frames of a closure move together, and so does the guide axis of a drive on a moved hinge;
* a link with two pins turns with the line that joins them, and so does a slide between two pins;
* all other links, the frame among them, keep their masses and shapes where they are in the world:
  the lips still meet. A slide on the frame keeps its direction.

The URDF's elements are changed themselves. A text with expressions in it (xacro) could not do this
without expressions for every one of these numbers in every model, and would be a URDF no more.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import ModelError, looked_up
from ...tolerances.mechanics import COINCIDENT_M
from ...units import M_PER_MM, MM_PER_M
from ..files.urdf_parts import JointAxis, nearest_plane, upright
from ..files.urdf_values import finite, origin, rotation_from_rpy


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Places of links and points at touch, in the world of the side view.

    Attributes:
        file: Name of the URDF, for messages.
        order: Joint elements, parents before children.
        place: World place of every link frame [m], shape (3,) each.
        turn: World rotation of every link frame, shape (3, 3) each.
        points: Link whose frame stands in the point, by name of the point: the joint's name for a
            hinge, the link's for a frame without mass.
        meeting: Points that are one pin, by name of each.
    """

    root: ElementTree.Element
    file: str
    order: tuple[ElementTree.Element, ...]
    place: dict[str, FloatArray]
    turn: dict[str, FloatArray]
    points: dict[str, str]
    meeting: dict[str, tuple[str, ...]]

    def point_mm(self, name: str) -> tuple[float, float]:
        """World place (x, z) of a point at touch [mm].

        Raises:
            UnknownNameError: There is no such point.
        """
        x, _, z = MM_PER_M * self.place[looked_up("point", name, self.points)]
        return float(x), float(z)

    def gaps(self, document: Mapping[str, Any]) -> dict[str, FloatArray]:
        """Gap of every closure at touch, frame b minus frame a, x and z [m], by its name.

        Args:
            document: The TOML document, known to be well-formed; frames that are not there, which
                the loader refuses, have no gap.
        """
        found: dict[str, FloatArray] = {}
        for name, closure in document.get("closures", {}).items():
            first, second = closure["frame_a"], closure["frame_b"]
            if first not in self.place or second not in self.place:
                continue
            gap = self.place[second] - self.place[first]
            if closure.get("slot_axis") is not None:
                along = np.eye(3)["xyz".index(closure["slot_axis"])]
                if upright(self.turn[first]):
                    along = self.turn[first] @ along
                gap = gap - (gap @ along) * along
            found[name] = gap[[0, 2]]
        return found

    @cached_property
    def carried_by(self) -> dict[str, str]:
        """Hinge on which the link hangs that carries a point; none on the frame or a slide."""
        hinges = {link: point for point, link in self.points.items()}
        above = {end(joint, "child"): end(joint, "parent") for joint in self.order}
        found = {point: hinges.get(above[link]) for point, link in self.points.items()}
        return {point: hinge for point, hinge in found.items() if hinge is not None}

    def hinge_below(self, name: str) -> str:
        """Hinge on which the link hangs that carries a point.

        Raises:
            UnknownNameError: There is no such point, or its link hangs on no hinge.
        """
        self.point_mm(name)
        where = f"points.{name}: polar coordinates"
        return looked_up("point on a hinged link", name, self.carried_by, where)

    def inertial(self, link: str, path: str) -> ElementTree.Element:
        """Mass and inertia of a link.

        Raises:
            UnknownNameError: There is no such link, or it has no mass.
        """
        known = {
            element_name(item): part
            for item in self.root.findall("link")
            if (part := item.find("inertial")) is not None
        }
        return looked_up("link with a mass", link, known, f"path {path}")


def read_layout(root: ElementTree.Element, document: Mapping[str, object], file: str) -> Layout:
    """Read where links and points stand at touch; the document is known to be well-formed.

    Raises:
        ModelError: The links are no tree, or a placement is no number.
    """
    joints = root.findall("joint")
    children = {end(joint, "child") for joint in joints}
    place: dict[str, FloatArray] = {}
    turn: dict[str, FloatArray] = {}
    for link in root.findall("link"):
        if element_name(link) not in children:
            place[element_name(link)], turn[element_name(link)] = np.zeros(3), np.eye(3)
    order: list[ElementTree.Element] = []
    points: dict[str, str] = {}
    while len(order) < len(joints):
        before = len(order)
        for joint in joints:
            parent, child = end(joint, "parent"), end(joint, "child")
            if parent not in place or child in place:
                continue
            xyz, rpy = origin(joint, f"joint {element_name(joint)}", file)
            place[child] = place[parent] + turn[parent] @ xyz
            turn[child] = turn[parent] @ rotation_from_rpy(rpy)
            order.append(joint)
            kind = joint.get("type")
            if kind in ("revolute", "continuous"):
                points[element_name(joint)] = child
            elif kind == "fixed":
                points[child] = child
        if len(order) == before:
            loose = sorted(element_name(item) for item in joints if item not in order)
            allowed = "joints that hang from the frame, one a link"
            raise ModelError(file=file, key="joints", value=loose, allowed=allowed)
    # What has none is refused when it is built.
    plane = nearest_plane(_axes(order, turn, file))
    if plane.turned:
        place = {link: plane.axes @ where for link, where in place.items()}
        turn = {link: plane.axes @ rotation for link, rotation in turn.items()}
    return Layout(
        root=root,
        file=file,
        order=tuple(order),
        place=place,
        turn=turn,
        points=points,
        meeting=_meeting(points, document),
    )


def _axes(
    order: Sequence[ElementTree.Element], turn: Mapping[str, FloatArray], file: str
) -> list[JointAxis]:
    """Axes of the joints that move; a joint without any direction has none."""
    found = []
    for joint in order:
        name, kind, axis = element_name(joint), joint.get("type"), joint.find("axis")
        local = np.array([1.0, 0.0, 0.0])
        if axis is not None:
            local = np.array(finite(axis, "xyz", 3, "1 0 0", f"joint {name} axis", file))
        length = np.linalg.norm(local)
        if kind != "fixed" and length > 0.0:
            direction = turn[end(joint, "child")] @ local / length
            found.append(JointAxis(name, kind != "prismatic", direction, local.tolist()))
    return found


def _meeting(points: Mapping[str, str], document: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """Groups of points that are one pin; the loader refuses ends of closures that are no points."""
    meeting: dict[str, tuple[str, ...]] = {name: (name,) for name in points}
    for closure in document.get("closures", {}).values():
        if closure.get("slot_axis") is not None:
            # A pin moves along its slot.
            continue
        ends = (closure["frame_a"], closure["frame_b"])
        if all(name in points for name in ends):
            joined = tuple(dict.fromkeys(other for name in ends for other in meeting[name]))
            for name in joined:
                meeting[name] = joined
    return meeting


def element_name(element: ElementTree.Element) -> str:
    """Name of an element, empty without one."""
    return element.get("name", "")


def end(joint: ElementTree.Element, side: str) -> str:
    """Link on one side of a joint: "parent" or "child"."""
    found = joint.find(side)
    return "" if found is None else found.get("link", "")


_PARTS = ("inertial", "visual", "collision")


@dataclass(frozen=True)
class _Swing:
    """Motion of the parts of a link in the world: x -> new + turn (x - old)."""

    old: FloatArray
    new: FloatArray
    turn: FloatArray


def move_points(
    found: Layout, document: Mapping[str, object], places_mm: Mapping[str, tuple[float, float]]
) -> dict[str, object]:
    """Move points of a model.

    Args:
        found: Where everything stands; its elements are changed in place.
        document: The TOML document, known to be well-formed.
        places_mm: New world places (x, z) at touch [mm] by name of the point.

    Returns:
        The document with the axes of guides and cranks where their pins have gone.

    Raises:
        UnknownNameError: There is no such point.
        ModelError: Two places are given for one pin.
    """
    shifts = _shifts(found, places_mm)
    if not shifts:
        return dict(document)
    pins = _pins(found)
    place = {link: where + shifts.get(link, 0.0) for link, where in found.place.items()}
    slides = [joint for joint in found.order if joint.get("type") == "prismatic"]
    for slide in slides:
        # A slide has no fixed place: it moves with the pin of its far link.
        far = [link for link in pins.get(end(slide, "child"), ()) if link in shifts]
        for pinned in far:
            place[end(slide, "child")] = found.place[end(slide, "child")] + shifts[pinned]
    swings = _swings(found, place, pins, slides)
    _keep_contacts(swings, found, document)
    for joint in found.order:
        parent, child = end(joint, "parent"), end(joint, "child")
        if joint in slides and parent in swings:
            axis = joint.find("axis")
            if axis is not None:
                key = f"joint {element_name(joint)} axis"
                old = finite(axis, "xyz", 3, "1 0 0", key, found.file)
                new = found.turn[child].T @ swings[parent].turn @ found.turn[child] @ old
                axis.set("xyz", text_of(new))
        write_origin(joint, found.turn[parent].T @ (place[child] - place[parent]), None)
    for link in found.root.findall("link"):
        _carry(link, found, place, swings.get(element_name(link)))
    return _with_guides(document, found, place)


def _shifts(found: Layout, places_mm: Mapping[str, tuple[float, float]]) -> dict[str, FloatArray]:
    """Displacement [m] of every link frame that stands in a moved point."""
    shifts: dict[str, FloatArray] = {}
    asked: dict[str, FloatArray] = {}
    for point, (x, z) in places_mm.items():
        old_x, old_z = found.point_mm(point)
        shift = M_PER_MM * np.array([x - old_x, 0.0, z - old_z])
        place = M_PER_MM * np.array([x, 0.0, z])
        for other in found.meeting[point]:
            link = found.points[other]
            # Frames of one pin need not quite meet in a file of rounded numbers.
            apart = np.minimum(
                np.abs(shifts.get(link, shift) - shift), np.abs(asked.get(link, place) - place)
            )
            if apart.max() > COINCIDENT_M:
                key, names = f"points.{point}", ", ".join(found.meeting[point])
                allowed = f"one place for the points {names}: one pin"
                raise ModelError(file=found.file, key=key, value=[x, z], allowed=allowed)
            shifts[link], asked[link] = shift, place
    return {link: shift for link, shift in shifts.items() if shift.any()}


def _pins(found: Layout) -> dict[str, tuple[str, ...]]:
    """Link frames that stand in the pins of each link: its own and those that hang from it."""
    stand = set(found.points.values())
    pins: dict[str, tuple[str, ...]] = {link: (link,) for link in found.points.values()}
    for joint in found.order:
        parent, child = end(joint, "parent"), end(joint, "child")
        if child in stand:
            pins[parent] = (*pins.get(parent, ()), child)
    return pins


def _swings(
    found: Layout,
    place: Mapping[str, FloatArray],
    pins: Mapping[str, tuple[str, ...]],
    slides: Sequence[ElementTree.Element],
) -> dict[str, _Swing]:
    """Motions of the links with two pins; those at both ends of a slide count as one link.

    The frame turns with nothing, and so does a slide in a guide on it.
    """
    hung = {end(joint, "child") for joint in found.order}
    lines = {link: ends for link, ends in pins.items() if len(ends) == 2 and link in hung}
    swings = {
        link: _swing(found, place, first, second, about=first)
        for link, (first, second) in lines.items()
    }
    for slide in slides:
        near, far = end(slide, "parent"), end(slide, "child")
        ends = (*pins.get(near, ()), *pins.get(far, ()))
        if len(ends) == 2 and near in hung:
            swings[near] = _swing(found, place, *ends, about=ends[0])
            swings[far] = _swing(found, place, *ends, about=ends[1])
    return swings


def _swing(
    found: Layout, place: Mapping[str, FloatArray], first: str, second: str, *, about: str
) -> _Swing:
    old = found.place[second] - found.place[first]
    new = place[second] - place[first]
    angle = math.atan2(new[0], new[2]) - math.atan2(old[0], old[2])
    turn = rotation_from_rpy(np.array([0.0, angle, 0.0]))
    return _Swing(found.place[about], place[about], turn)


def _keep_contacts(
    swings: dict[str, _Swing], found: Layout, document: Mapping[str, object]
) -> None:
    """Leave links unchanged whose shapes meet at a stop, so that the contact stays."""
    stops: Any = document.get("stops", {})
    meet = {name for stop in stops.values() for name in stop.get("contact", {}).values()}
    for link in found.root.findall("link"):
        shapes = {shape.get("name") for shape in link.findall("collision")}
        if meet & (shapes | {element_name(link)}):
            swings.pop(element_name(link), None)


def _carry(
    link: ElementTree.Element, found: Layout, place: Mapping[str, FloatArray], swing: _Swing | None
) -> None:
    """Write where mass and shapes of a link stand in its moved frame."""
    name = element_name(link)
    turn = found.turn[name]
    if swing is None and np.array_equal(place[name], found.place[name]):
        return
    for part in _PARTS:
        for element in link.findall(part):
            xyz, rpy = origin(element, f"link {name} {part}", found.file)
            world = found.place[name] + turn @ xyz
            angles = None
            if swing is not None:
                world = swing.new + swing.turn @ (world - swing.old)
                if part != "inertial":
                    local = turn.T @ swing.turn @ turn @ rotation_from_rpy(rpy)
                    angles = np.asarray(pin.rpy.matrixToRpy(local))
            write_origin(element, turn.T @ (world - place[name]), angles)


def _with_guides(
    document: Mapping[str, object], found: Layout, place: Mapping[str, FloatArray]
) -> dict[str, object]:
    """The document with the axes of guides and cranks on the moved pins that they stood on."""
    changed: Any = dict(document)
    drives = changed["drives"] = copy.deepcopy(changed.get("drives", {}))
    for drive in drives.values():
        for key in ("guide_axis_mm", "crank_axis_mm"):
            if key not in drive:
                continue
            for link in found.points.values():
                x, _, z = MM_PER_M * found.place[link]
                if math.hypot(drive[key][0] - x, drive[key][1] - z) < MM_PER_M * COINCIDENT_M:
                    new_x, _, new_z = MM_PER_M * place[link]
                    drive[key] = [float(new_x), float(new_z)]
                    break
    return dict(changed)


def write_origin(element: ElementTree.Element, xyz: FloatArray, rpy: FloatArray | None) -> None:
    """Write the origin of an element.

    Args:
        xyz: Translation [m], shape (3,).
        rpy: Roll, pitch, yaw [rad], shape (3,); None leaves them.
    """
    where = element.find("origin")
    if where is None:
        where = ElementTree.SubElement(element, "origin")
    where.set("xyz", text_of(xyz))
    if rpy is not None:
        where.set("rpy", text_of(rpy))


def text_of(values: FloatArray) -> str:
    """Numbers as the text of an attribute; they read back equal."""
    return " ".join(repr(float(value)) for value in values)
