"""A machine read from the texts of its model, without the package's reader.

The URDF is read here anew, by textbook formulae for rotations, so that a wrong mass, place or axis
in the building of a model is seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from nipper_pin.arrays import FloatArray

_SLOT_AXES = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class _Joint:
    """A joint of the text: where it is on its parent, and how it moves its child."""

    name: str
    kind: str
    parent: str
    child: str
    place: FloatArray
    turn: FloatArray
    axis: FloatArray


@dataclass(frozen=True)
class _Mass:
    """Mass [kg], its centre [m] and moments of inertia about that [kg m^2], in axes of the link."""

    mass: float
    centre: FloatArray
    inertia: FloatArray


@dataclass(frozen=True)
class Inertias:
    """Mass properties of a configuration, from masses and places.

    Attributes:
        mass_matrix: M, shape (nv, nv).
        weight: Generalised forces of gravity, taken with the opposite sign, shape (nv,).
        weight_size: Sum of the sizes of the terms of these, shape (nv,).
    """

    mass_matrix: FloatArray
    weight: FloatArray
    weight_size: FloatArray


class Text:
    """Links and joints of a model, from its URDF and TOML document.

    Args:
        urdf: The URDF text.
        description: The TOML document.
        order: Names of the joints in the order of their coordinates.
    """

    def __init__(self, urdf: str, description: Mapping[str, Any], order: list[str]) -> None:
        """Read the texts."""
        root = ElementTree.fromstring(urdf)
        self._gravity = float(description["gravity_m_s2"])
        self._order = {name: place for place, name in enumerate(order)}
        self._masses = {
            str(link.get("name")): _mass(link.find("inertial")) for link in root.findall("link")
        }
        self._joints = {str(item.get("name")): _joint(item) for item in root.findall("joint")}
        for name, closure in description.get("closures", {}).items():
            if closure.get("slot_axis"):
                self._add_block(name, closure)
        self._above = {joint.child: joint for joint in self._joints.values()}

    def _add_block(self, name: str, closure: Mapping[str, Any]) -> None:
        """The block of a slot slides from where it is nearest to the pin at touch."""
        self._above = {joint.child: joint for joint in self._joints.values()}
        still = np.zeros(len(self._order))
        (pin, _), (slot, turn) = (
            self._frame(closure[key], still)[:2] for key in ("frame_b", "frame_a")
        )
        axis = np.array(_SLOT_AXES[closure["slot_axis"]])
        along = float((turn.T @ (pin - slot)) @ axis)
        block, one = f"{name}_block", np.eye(3)
        frame = closure["frame_a"]
        self._joints[name] = _Joint(name, "prismatic", frame, block, along * axis, one, axis)
        mass = float(closure["block_mass_kg"])
        self._masses[block] = _Mass(mass, np.zeros(3), np.zeros((3, 3)))

    def _frame(self, link: str, q: FloatArray) -> tuple[FloatArray, FloatArray, list[_Moving]]:
        """Place and axes of a link in the world, and the joints that move it."""
        chain = []
        while link in self._above:
            chain.append(self._above[link])
            link = chain[-1].parent
        place, turn = np.zeros(3), np.eye(3)
        moving: list[_Moving] = []
        for joint in reversed(chain):
            place = place + turn @ joint.place
            turn = turn @ joint.turn
            if joint.kind == "fixed":
                continue
            row = self._order[joint.name]
            slides = joint.kind == "prismatic"
            moving.append((row, slides, turn @ joint.axis, place))
            if slides:
                place = place + turn @ joint.axis * q[row]
            else:
                turn = turn @ _rotation(joint.axis, float(q[row]))
        return place, turn, moving

    def inertias(self, q: FloatArray) -> Inertias:
        """Mass matrix and weight at one configuration, shape (nv,)."""
        count = len(q)
        matrix, weight, size = np.zeros((count, count)), np.zeros(count), np.zeros(count)
        for link, item in self._masses.items():
            if item is None:
                continue
            place, turn, moving = self._frame(link, q)
            centre = place + turn @ item.centre
            linear, angular = np.zeros((3, count)), np.zeros((3, count))
            for row, slides, axis, origin in moving:
                if slides:
                    linear[:, row] = axis
                else:
                    linear[:, row] = np.cross(axis, centre - origin)
                    angular[:, row] = axis
            about = turn @ item.inertia @ turn.T
            matrix += item.mass * linear.T @ linear + angular.T @ about @ angular
            weight += item.mass * self._gravity * linear[2]
            size += item.mass * self._gravity * np.abs(linear).max(axis=0, initial=0.0)
        return Inertias(matrix, weight, size)


_Moving = tuple[int, bool, FloatArray, FloatArray]


def _mass(item: ElementTree.Element | None) -> _Mass | None:
    if item is None:
        return None
    place, turn = _origin(item.find("origin"))
    moments = np.zeros((3, 3))
    of = item.find("inertia")
    for row, first in enumerate("xyz"):
        for column, second in enumerate("xyz"):
            name = "i" + "".join(sorted(first + second))
            moments[row, column] = float(of.get(name, "0")) if of is not None else 0.0
    mass = item.find("mass")
    value = float(mass.get("value", "0")) if mass is not None else 0.0
    return _Mass(value, place, turn @ moments @ turn.T)


def _joint(item: ElementTree.Element) -> _Joint:
    place, turn = _origin(item.find("origin"))
    axis = item.find("axis")
    direction = _numbers(axis.get("xyz", "1 0 0") if axis is not None else "1 0 0")
    ends = [item.find(side) for side in ("parent", "child")]
    parent, child = (str(end.get("link")) if end is not None else "" for end in ends)
    return _Joint(
        str(item.get("name")), str(item.get("type")), parent, child, place, turn,
        direction / np.linalg.norm(direction),
    )  # fmt: skip


def _origin(item: ElementTree.Element | None) -> tuple[FloatArray, FloatArray]:
    if item is None:
        return np.zeros(3), np.eye(3)
    roll, pitch, yaw = _numbers(item.get("rpy", "0 0 0"))
    x, y, z = np.eye(3)
    turn = _rotation(z, yaw) @ _rotation(y, pitch) @ _rotation(x, roll)
    return _numbers(item.get("xyz", "0 0 0")), turn


def _numbers(text: str) -> FloatArray:
    return np.array([float(number) for number in text.split()])


def _rotation(axis: FloatArray, angle: float) -> FloatArray:
    """Rotation matrix by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)
