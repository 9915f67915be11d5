"""Places of links and points in the touch configuration, read from the two texts of a model.

A *point* is a hinge or a named frame. Closures are cut pins, so two points can be one pin.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ...arrays import FloatArray
from ...errors import ModelError, UnknownNameError
from ...units import MM_PER_M
from ..files.plane import JointAxis, nearest_plane
from ..files.side_view import upright
from ..files.urdf_values import numbers, origin, rotation_from_rpy


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Places of links and points at touch, in the world of the side view.

    Attributes:
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
    points: dict[str, str]
    meeting: dict[str, tuple[str, ...]]

    def point_mm(self, name: str) -> tuple[float, float]:
        """World place (x, z) of a point at touch [mm].

        Raises:
            UnknownNameError: There is no such point.
        """
        if name not in self.points:
            raise UnknownNameError(kind="point", name=name, known=self.points)
        x, _, z = MM_PER_M * self.place[self.points[name]]
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

    def carried_by(self, name: str) -> str | None:
        """Hinge on which the link hangs that carries a point; None on the frame or a slide.

        Raises:
            UnknownNameError: There is no such point.
        """
        self.point_mm(name)
        joint = next(item for item in self.order if end(item, "child") == self.points[name])
        hinges = {link: point for point, link in self.points.items()}
        return hinges.get(end(joint, "parent"))

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
        if link not in known:
            raise UnknownNameError(
                kind="link with a mass", name=link, known=known, where=f"path {path}"
            )
        return known[link]


def read_layout(root: ElementTree.Element, document: Mapping[str, object], file: str) -> Layout:
    """Read where links and points stand at touch.

    Args:
        document: The TOML document, known to be well-formed (:mod:`.describe`).

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
            local = numbers(axis, "xyz", 3, "1 0 0", f"joint {name} axis", file)
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
