"""Links of a URDF as rigid bodies of the side view, x forward and z up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

Array = np.ndarray


def turned(angle: float) -> Array:
    """Matrix of a counter-clockwise rotation in the side view."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


@dataclass
class Body:
    """One rigid body; ``centre`` is its centre of mass in the drawing (touch) [m]."""

    mass: float = 0.0
    inertia: float = 0.0
    centre: Array = None  # type: ignore[assignment]

    def add(self, mass: float, inertia: float, centre: Array) -> None:
        """Fix more matter to the body."""
        if self.centre is None:
            self.centre = centre.copy()
        total = self.mass + mass
        apart = centre - self.centre
        self.inertia += inertia + self.mass * mass / total * float(apart @ apart)
        self.centre = self.centre + mass / total * apart
        self.mass = total


class Frame(NamedTuple):
    """A link's frame: its body, its place and its angle in the drawing."""

    body: int
    place: Array
    angle: float


class TreeJoint(NamedTuple):
    """A moving joint between two bodies, at a place and along a direction of the drawing."""

    name: str
    hinge: bool
    parent: int
    child: int
    place: Array
    direction: Array


@dataclass
class Links:
    """All bodies (0 is the frame), the frames of all links and the moving joints."""

    bodies: list[Body]
    frames: dict[str, Frame]
    joints: dict[str, TreeJoint]
    damping: dict[str, float]


def _rotation(element: ElementTree.Element | None) -> tuple[Array, Array]:
    """Translation and rotation matrix of an <origin>."""
    if element is None:
        return np.zeros(3), np.eye(3)
    xyz = np.array([float(word) for word in element.get("xyz", "0 0 0").split()])
    roll, pitch, yaw = (float(word) for word in element.get("rpy", "0 0 0").split())

    def about(axis: int, angle: float) -> Array:
        one, other = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[one, one] = matrix[other, other] = math.cos(angle)
        matrix[one, other], matrix[other, one] = -math.sin(angle), math.sin(angle)
        return matrix

    return xyz, about(2, yaw) @ about(1, pitch) @ about(0, roll)


def _matter(link: ElementTree.Element, frame: Frame, body: Body) -> None:
    """Add the mass of a link, its inertia seen along y."""
    inertial = link.find("inertial")
    if inertial is None:
        return
    xyz, rotation = _rotation(inertial.find("origin"))
    entries = inertial.find("inertia").attrib  # type: ignore[union-attr]
    tensor = np.array(
        [[float(entries.get("i" + "".join(sorted(a + b)), 0)) for b in "xyz"] for a in "xyz"]
    )
    mass = float(inertial.find("mass").get("value"))  # type: ignore[union-attr, arg-type]
    place = frame.place + turned(frame.angle) @ xyz[[0, 2]]
    body.add(mass, float((rotation @ tensor @ rotation.T)[1, 1]), place)


def read_links(text: str) -> Links:
    """Read a URDF."""
    root = ElementTree.fromstring(text)
    links = {str(link.get("name")): link for link in root.findall("link")}
    above = {str(item.find("child").get("link")): item for item in root.findall("joint")}  # type: ignore[union-attr]
    (top,) = (name for name in links if name not in above)
    found = Links([Body(centre=np.zeros(2))], {top: Frame(0, np.zeros(2), 0.0)}, {}, {})
    waiting = dict(above)
    while waiting:
        for child, item in list(waiting.items()):
            parent = str(item.find("parent").get("link"))  # type: ignore[union-attr]
            if parent in found.frames:
                _hang(found, parent, child, item)
                del waiting[child]
    for name, link in links.items():
        frame = found.frames[name]
        if frame.body:
            _matter(link, frame, found.bodies[frame.body])
    return found


def _hang(found: Links, parent: str, child: str, item: ElementTree.Element) -> None:
    """Add a link that hangs from one that is known."""
    above = found.frames[parent]
    xyz, rotation = _rotation(item.find("origin"))
    place = above.place + turned(above.angle) @ xyz[[0, 2]]
    # A rotation about +y is clockwise in the side view.
    angle = above.angle - math.atan2(rotation[0, 2], rotation[0, 0])
    kind, name = item.get("type"), str(item.get("name"))
    if kind == "fixed":
        found.frames[child] = Frame(above.body, place, angle)
        return
    found.bodies.append(Body())
    body = len(found.bodies) - 1
    found.frames[child] = Frame(body, place, angle)
    axis = item.find("axis")
    words = ("1 0 0" if axis is None else axis.get("xyz", "1 0 0")).split()
    along = turned(angle) @ np.array([float(words[0]), float(words[2])])
    hinge = kind != "prismatic"
    direction = np.zeros(2) if hinge else along / np.hypot(*along)
    found.joints[name] = TreeJoint(name, hinge, above.body, body, place, direction)
    dynamics = item.find("dynamics")
    if dynamics is not None and float(dynamics.get("damping", 0)) != 0.0:
        found.damping[name] = float(dynamics.get("damping", 0))
