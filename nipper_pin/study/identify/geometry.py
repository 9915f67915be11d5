"""Moving the points of a model in its touch configuration, so that it stays assembled.

All coordinates are zero at touch, and closures and contacts are checked there. A dimension can
therefore not be changed alone: a pin moves together with everything that meets in it. Here a
*point* is a hinge or a named frame, with its place in the world at touch, and moving one means:

* both frames of a closure move together, and so does the guide axis of a drive on a moved hinge;
* a link with two pins turns with the line that joins them, and so does a slide between two pins;
* all other links keep their masses and shapes where they are in the world: the lips still meet.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import ModelError, UnknownNameError
from ...mechanism import Mechanism, from_sources
from ...mechanism.urdf import parse_xml
from ...mechanism.urdf_values import origin, rotation_from_rpy

_SAME_M = 1e-9
_PARTS = ("inertial", "visual", "collision")


@dataclass(frozen=True, kw_only=True)
class Sources:
    """The two texts of a model.

    Attributes:
        name: Model name.
        urdf: The URDF text.
        document: The TOML document as plain data.
        folder: Folder that mesh and table files start from.
    """

    name: str
    urdf: str
    document: Mapping[str, object]
    folder: str

    @classmethod
    def of(cls, mechanism: Mechanism) -> Sources:
        """Return the texts that a mechanism was built from."""
        return cls(
            name=mechanism.name,
            urdf=mechanism.urdf,
            document=mechanism.description,
            folder=mechanism.mesh_folder,
        )

    def build(self) -> Mechanism:
        """Build the mechanism.

        Raises:
            InputError: The texts make no mechanism.
        """
        return from_sources(self.name, self.urdf, self.document, Path(self.folder))


@dataclass(frozen=True)
class _Swing:
    """How the parts of a link move in the world: x -> new + turn (x - old)."""

    old: FloatArray
    new: FloatArray
    turn: FloatArray


@dataclass(frozen=True)
class Layout:
    """Where links and points stand at touch, read from a model's texts.

    Attributes:
        root: The ``robot`` element.
        order: Joint elements, parents before children.
        place: World place of every link frame [m], shape (3,) each.
        turn: World rotation of every link frame, shape (3, 3) each.
        points: Link whose frame stands in the point, by name of the point: the joint's name for a
            hinge, the link's for a frame without mass.
        meeting: Points that are one pin, by name of each.
    """

    root: ElementTree.Element
    order: tuple[ElementTree.Element, ...]
    place: dict[str, FloatArray]
    turn: dict[str, FloatArray]
    points: dict[str, str] = field(default_factory=dict)
    meeting: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def point_mm(self, name: str) -> tuple[float, float]:
        """World place (x, z) of a point at touch [mm].

        Raises:
            UnknownNameError: There is no such point.
        """
        if name not in self.points:
            raise UnknownNameError(kind="point", name=name, known=self.points)
        x, _, z = 1e3 * self.place[self.points[name]]
        return float(x), float(z)

    def carried_by(self, name: str) -> str | None:
        """Hinge on which the link hangs that carries a point; None on the frame or a slide.

        Raises:
            UnknownNameError: There is no such point.
        """
        self.point_mm(name)
        joint = next(item for item in self.order if _end(item, "child") == self.points[name])
        carrier = _end(joint, "parent")
        hinges = {link: point for point, link in self.points.items()}
        return hinges.get(carrier)

    def hinge_below(self, name: str) -> str:
        """Hinge on which the link hangs that carries a point.

        Raises:
            UnknownNameError: There is no such point, or its link hangs on no hinge.
        """
        hinge = self.carried_by(name)
        if hinge is None:
            known = (point for point in self.points if self.carried_by(point) is not None)
            where = f"points.{name}: polar coordinates"
            raise UnknownNameError(
                kind="point on a hinged link", name=name, known=known, where=where
            )
        return hinge


def layout(sources: Sources) -> Layout:
    """Read where links and points stand at touch.

    Args:
        sources: A model's texts, already known to be valid.
    """
    file = f"{sources.name}.urdf"
    root = parse_xml(sources.urdf, file)
    joints = root.findall("joint")
    children = {_end(joint, "child") for joint in joints}
    top = next(name for link in root.findall("link") if (name := _name(link)) not in children)
    place, turn = {top: np.zeros(3)}, {top: np.eye(3)}
    order: list[ElementTree.Element] = []
    points: dict[str, str] = {}
    while len(order) < len(joints):
        for joint in joints:
            parent, child = _end(joint, "parent"), _end(joint, "child")
            if parent not in place or child in place:
                continue
            xyz, rpy = origin(joint, f"joint {_name(joint)}", file)
            place[child] = place[parent] + turn[parent] @ xyz
            turn[child] = turn[parent] @ rotation_from_rpy(rpy)
            order.append(joint)
            kind = joint.get("type")
            if kind in ("revolute", "continuous"):
                points[_name(joint)] = child
            elif kind == "fixed":
                points[child] = child
    meeting: dict[str, tuple[str, ...]] = {name: (name,) for name in points}
    closures: Any = sources.document.get("closures", {})
    for closure in closures.values():
        ends = tuple(closure[side] for side in ("frame_a", "frame_b"))
        for end in ends:
            meeting[end] = ends
    return Layout(root, tuple(order), place, turn, points, meeting)


def moved(sources: Sources, places_mm: Mapping[str, tuple[float, float]]) -> Sources:
    """Move points of a model.

    Args:
        sources: The model's texts.
        places_mm: New world places (x, z) at touch [mm] by name of the point.

    Returns:
        Texts of the changed model.

    Raises:
        UnknownNameError: There is no such point.
        ModelError: The root frame would move, or two places are given for one pin.
    """
    found = layout(sources)
    shifts = _shifts(found, places_mm, sources.name)
    if not shifts:
        return sources
    pins = _pins(found)
    place = {link: where + shifts.get(link, 0.0) for link, where in found.place.items()}
    slides = [joint for joint in found.order if joint.get("type") == "prismatic"]
    for slide in slides:
        # A slide has no place of its own: it goes with what its far link is pinned to.
        far = [link for link in pins.get(_end(slide, "child"), ()) if link in shifts]
        for end in far:
            place[_end(slide, "child")] = found.place[_end(slide, "child")] + shifts[end]
    swings = _swings(found, place, pins, slides)
    _keep_contacts(swings, found, sources.document)
    for joint in found.order:
        parent, child = _end(joint, "parent"), _end(joint, "child")
        if joint in slides and parent in swings:
            axis = joint.find("axis")
            if axis is not None:
                old = np.array([float(part) for part in axis.get("xyz", "1 0 0").split()])
                new = found.turn[child].T @ swings[parent].turn @ found.turn[child] @ old
                axis.set("xyz", _text(new))
        _write(joint, found.turn[parent].T @ (place[child] - place[parent]), None)
    for link in found.root.findall("link"):
        _carry(link, found, place, swings.get(_name(link)), f"{sources.name}.urdf")
    return Sources(
        name=sources.name,
        urdf=ElementTree.tostring(found.root, encoding="unicode"),
        document=_with_guides(sources.document, found, place),
        folder=sources.folder,
    )


def _shifts(
    found: Layout, places_mm: Mapping[str, tuple[float, float]], name: str
) -> dict[str, FloatArray]:
    """Displacement [m] of every link frame that stands in a moved point."""
    shifts: dict[str, FloatArray] = {}
    for point, (x, z) in places_mm.items():
        old_x, old_z = found.point_mm(point)
        shift = 1e-3 * np.array([x - old_x, 0.0, z - old_z])
        for other in found.meeting[point]:
            link = found.points[other]
            if np.abs(shifts.get(link, shift) - shift).max() > _SAME_M:
                allowed = f"one place for the points {', '.join(found.meeting[point])}: one pin"
                raise ModelError(
                    file=f"{name}.urdf", key=f"points.{point}", value=[x, z], allowed=allowed
                )
            shifts[link] = shift
    return {link: shift for link, shift in shifts.items() if shift.any()}


def _pins(found: Layout) -> dict[str, tuple[str, ...]]:
    """Link frames that stand in the pins of each link: its own and those that hang from it."""
    stand = set(found.points.values())
    pins: dict[str, tuple[str, ...]] = {link: (link,) for link in found.points.values()}
    for joint in found.order:
        parent, child = _end(joint, "parent"), _end(joint, "child")
        if child in stand:
            pins[parent] = (*pins.get(parent, ()), child)
    return pins


def _swings(
    found: Layout,
    place: Mapping[str, FloatArray],
    pins: Mapping[str, tuple[str, ...]],
    slides: Sequence[ElementTree.Element],
) -> dict[str, _Swing]:
    """How the links turn that have two pins, those at both ends of a slide taken as one."""
    lines = {link: (ends[0], ends[1]) for link, ends in pins.items() if len(ends) == 2}
    swings = {link: _swing(found, place, *ends, about=ends[0]) for link, ends in lines.items()}
    for slide in slides:
        near, far = _end(slide, "parent"), _end(slide, "child")
        ends = (*pins.get(near, ()), *pins.get(far, ()))
        if len(ends) == 2:
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
    """Leave links alone whose shapes meet at a stop: they meet where they did."""
    stops: Any = document.get("stops", {})
    meet = {name for stop in stops.values() for name in stop.get("contact", {}).values()}
    for link in found.root.findall("link"):
        shapes = {shape.get("name") for shape in link.findall("collision")}
        if meet & (shapes | {_name(link)}):
            swings.pop(_name(link), None)


def _carry(
    link: ElementTree.Element,
    found: Layout,
    place: Mapping[str, FloatArray],
    swing: _Swing | None,
    file: str,
) -> None:
    """Write where mass and shapes of a link stand in its moved frame."""
    name = _name(link)
    turn = found.turn[name]
    if swing is None and np.array_equal(place[name], found.place[name]):
        return
    for part in _PARTS:
        for element in link.findall(part):
            xyz, rpy = origin(element, f"link {name} {part}", file)
            world = found.place[name] + turn @ xyz
            angles = None
            if swing is not None:
                world = swing.new + swing.turn @ (world - swing.old)
                if part != "inertial":
                    local = turn.T @ swing.turn @ turn @ rotation_from_rpy(rpy)
                    angles = np.asarray(pin.rpy.matrixToRpy(local))
            _write(element, turn.T @ (world - place[name]), angles)


def _with_guides(
    document: Mapping[str, object], found: Layout, place: Mapping[str, FloatArray]
) -> dict[str, object]:
    """The document with the axes of guides and cranks on the moved pins that they stood on."""
    changed: Any = copy.deepcopy(dict(document))
    for drive in changed.get("drives", {}).values():
        for key in ("guide_axis_mm", "crank_axis_mm"):
            if key not in drive:
                continue
            for link in found.points.values():
                x, _, z = 1e3 * found.place[link]
                if math.hypot(drive[key][0] - x, drive[key][1] - z) < 1e3 * _SAME_M:
                    new_x, _, new_z = 1e3 * place[link]
                    drive[key] = [float(new_x), float(new_z)]
                    break
    return dict(changed)


def _write(element: ElementTree.Element, xyz: FloatArray, rpy: FloatArray | None) -> None:
    """Write an origin."""
    where = element.find("origin")
    if where is None:
        where = ElementTree.SubElement(element, "origin")
    where.set("xyz", _text(xyz))
    if rpy is not None:
        where.set("rpy", _text(rpy))


def _text(values: FloatArray) -> str:
    return " ".join(repr(float(value)) for value in values)


def _name(element: ElementTree.Element) -> str:
    return element.get("name", "")


def _end(joint: ElementTree.Element, side: str) -> str:
    end = joint.find(side)
    return "" if end is None else end.get("link", "")
