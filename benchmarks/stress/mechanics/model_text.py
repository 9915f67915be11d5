"""The moving links of a model, read from its URDF without the package's reader.

All is brought into the side view by textbook formulae for rotations, so that a wrong mass, place,
axis or plane in the building of a model is seen. Places are complex numbers x + i z [m]. Axes are
those of the side view in the touch configuration, where all coordinates are zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ...tolerances import UPRIGHT

Real = NDArray[np.float64]
_Y, _UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


class Frame(NamedTuple):
    """Axes of a link of the text, fixed to the moving link of a number; -1 is the machine's frame.

    Its place is from the joint of that link, its axes are the direction of x; 1 if out of plane.
    """

    body: int
    place: complex
    axes: complex


@dataclass
class Link:
    """A moving link with all that is fixed to it, and the joint that carries it on its parent.

    Offset and centre of mass are from joint to joint and from the joint; the inertia is about the
    latter. A hinge has no direction of sliding, and the sense 1 if it turns counter-clockwise as
    its coordinate grows, else -1. Damping is that of the text.
    """

    name: str
    joint: str
    parent: int
    offset: complex
    slide: complex | None
    sense: float = 1.0
    damping: float = 0.0
    mass: float = 0.0
    com: complex = 0j
    inertia: float = 0.0

    def add(self, mass: float, com: complex, inertia: float) -> None:
        """Fix more matter to it."""
        if mass > 0.0:
            apart = com - self.com
            self.inertia += self.mass * mass / (self.mass + mass) * abs(apart) ** 2
            self.com += mass / (self.mass + mass) * apart
            self.mass += mass
        self.inertia += inertia


@dataclass
class Links:
    """Moving links in the order of their coordinates, and the part of gravity in their plane."""

    links: list[Link] = field(default_factory=list)
    frames: dict[str, Frame] = field(default_factory=dict)
    steepness: float = 1.0

    def touch(self, frame: Frame) -> complex:
        """Place of a frame in the touch configuration."""
        place, body = frame.place, frame.body
        while body >= 0:
            place += self.links[body].offset
            body = self.links[body].parent
        return place


def read_links(
    text: str, order: Sequence[str] = (), closures: Mapping[str, Any] | None = None
) -> Links:
    """Read a URDF; coordinates are in the order of these joints, or of the text.

    A slot among the closures of the TOML document adds its block, a point of mass.
    """
    root = ElementTree.fromstring(text)
    moving = [item for item in root.findall("joint") if item.get("type") != "fixed"]
    names = list(order) or [str(item.get("name")) for item in moving]
    number = {name: place for place, name in enumerate(names)}
    at = _Placed(root, number)
    axes = [at.link(_end(item, "child"))[2] @ _axis(item) for item in moving]
    view = _side_view(axes, [item.get("type") != "prismatic" for item in moving])

    def flat(vector: Real) -> complex:
        return complex(view[0] @ vector, view[2] @ vector)

    links = [Link("", "", -1, 0j, None) for _ in names]
    for item, axis in zip(moving, axes, strict=True):
        name, hinge = str(item.get("name")), item.get("type") != "prismatic"
        parent, place, turn = at.link(_end(item, "parent"))
        slide = None if hinge else flat(axis) / abs(flat(axis))
        # A rotation about +y is clockwise in the side view.
        sense = -float(np.sign(view[1] @ axis)) if hinge else 1.0
        offset = flat(place + turn @ _origin(item.find("origin"))[0])
        damping = _number(item.find("dynamics"), "damping")
        child = _end(item, "child")
        links[number[name]] = Link(child, name, parent, offset, slide, sense, damping)
    frames = {}
    for item in root.findall("link"):
        body, place, turn = at.link(name := str(item.get("name")))
        upright = bool(view[1] @ turn[:, 1] > UPRIGHT)
        frames[name] = Frame(body, flat(place), flat(turn[:, 0]) if upright else 1.0)
        if body >= 0 and (inertial := item.find("inertial")) is not None:
            step, rotation = _origin(inertial.find("origin"))
            across = view[1] @ turn @ rotation
            moment = float(across @ _moments(inertial.find("inertia")) @ across)
            mass = _number(inertial.find("mass"), "value")
            links[body].add(mass, flat(place + turn @ step), moment)
    result = Links(links, frames, float(view[2, 2]))
    for name, closure in (closures or {}).items():
        if closure.get("slot_axis"):
            _add_block(result, number[name], name, closure)
    return result


class _Placed:
    """Where the links of a text are in the touch configuration."""

    def __init__(self, root: ElementTree.Element, number: Mapping[str, int]) -> None:
        self._above = {_end(item, "child"): item for item in root.findall("joint")}
        self._number = number
        self._known: dict[str, tuple[int, Real, Real]] = {}

    def link(self, name: str) -> tuple[int, Real, Real]:
        """Moving link of a link, its origin from the joint of that, its axes in the root's."""
        if name not in self._known:
            body, place, turn = -1, np.zeros(3), np.eye(3)
            if (joint := self._above.get(name)) is not None:
                body, place, turn = self.link(_end(joint, "parent"))
                step, rotation = _origin(joint.find("origin"))
                place, turn = place + turn @ step, turn @ rotation
                if joint.get("type") != "fixed":
                    body, place = self._number[str(joint.get("name"))], np.zeros(3)
            self._known[name] = body, place, turn
        return self._known[name]


def _add_block(links: Links, place: int, name: str, item: Mapping[str, Any]) -> None:
    """The block of a slot slides from where it is nearest to the pin at touch."""
    slot, pin = links.frames[item["frame_a"]], links.frames[item["frame_b"]]
    direction = slot.axes * {"x": 1.0, "z": 1.0j}[item["slot_axis"]]
    along = (direction.conjugate() * (links.touch(pin) - links.touch(slot))).real
    offset, block = slot.place + along * direction, f"{name}_block"
    links.links[place] = Link(block, name, slot.body, offset, direction, mass=item["block_mass_kg"])
    links.frames[block] = Frame(place, 0j, slot.axes)


def _side_view(axes: Sequence[Real], turns: Sequence[bool]) -> Real:
    """Axes x, y (into the page) and z of the side view, in those of the root link.

    It looks at the plane of the joints with z upwards, from where x of the text, or else y, points
    to the right.
    """
    hinges = [axis for axis, hinge in zip(axes, turns, strict=True) if hinge]
    # Of slides alone the x-z plane, if they move in that.
    across = [_Y, *(np.cross(axes[0], other) for other in (*axes[1:], _UP))] if axes else [_Y]
    sizes = [float(np.linalg.norm(item)) for item in across]
    normals = [item / size for item, size in zip(across, sizes, strict=True) if size > 1e-6]
    slides = [axis for axis, hinge in zip(axes, turns, strict=True) if not hinge]
    normal = next(n for n in hinges or normals if all(abs(n @ axis) < 1e-6 for axis in slides))
    if abs(normal[2]) > UPRIGHT:
        return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    up = _UP - normal[2] * normal
    up /= np.linalg.norm(up)
    right = np.cross(normal, up)
    sense = np.sign(right[np.argmax(np.abs(right))])
    return np.array([sense * right, sense * normal, up])


def _end(joint: ElementTree.Element, side: str) -> str:
    end = joint.find(side)
    return "" if end is None else str(end.get("link"))


def _axis(joint: ElementTree.Element) -> Real:
    axis = joint.find("axis")
    direction = _numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
    return np.asarray(direction / np.linalg.norm(direction))


def _number(item: ElementTree.Element | None, key: str) -> float:
    return 0.0 if item is None else float(item.get(key, "0"))


def _moments(item: ElementTree.Element | None) -> Real:
    return np.array(
        [[_number(item, "i" + "".join(sorted(one + other))) for other in "xyz"] for one in "xyz"]
    )


def _origin(item: ElementTree.Element | None) -> tuple[Real, Real]:
    """Translation and rotation, which is about the fixed axes x, y and z in turn."""
    if item is None:
        return np.zeros(3), np.eye(3)
    turn = Rotation.from_euler("xyz", _numbers(item.get("rpy", "0 0 0"))).as_matrix()
    return _numbers(item.get("xyz", "0 0 0")), turn


def _numbers(text: str) -> Real:
    return np.array([float(number) for number in text.split()])
