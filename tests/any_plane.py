"""The same machine written down otherwise: another plane, other frames, other senses of axes."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def rewritten(
    urdf: str, turn: Matrix, senses: Mapping[str, float], frames: np.random.Generator | None = None
) -> str:
    """The URDF of a machine in the x-z plane, turned as a whole.

    Args:
        urdf: The URDF; placements have to be written out.
        turn: Rotation of the whole machine in the axes of the root link, shape (3, 3).
        senses: -1 for joints whose axes are turned round, by name.
        frames: If given, the frames of all other links are turned at random.
    """
    root = ElementTree.fromstring(urdf)
    # New frames in the old ones; that of the root turns the whole machine.
    change = {link.get("name", ""): turn.T for link in root.findall("link")}
    below = {joint.find("child").get("link") for joint in root.findall("joint")}  # type: ignore[union-attr]
    for name in change:
        if frames is not None and name in below:
            change[name] = pin.rpy.rpyToMatrix(*frames.uniform(-3.0, 3.0, 3))
    for link in root.findall("link"):
        for part in link:
            _turn_origin(part, change[link.get("name", "")], np.eye(3))
    for joint in root.findall("joint"):
        parent, child = (joint.find(side).get("link", "") for side in ("parent", "child"))  # type: ignore[union-attr]
        _turn_origin(joint, change[parent], change[child])
        axis = joint.find("axis")
        if axis is not None:
            old = np.array([float(word) for word in axis.get("xyz", "").split()])
            new = senses.get(joint.get("name", ""), 1.0) * change[child].T @ old
            axis.set("xyz", _text(new))
    return ElementTree.tostring(root, encoding="unicode")


def _turn_origin(element: ElementTree.Element, above: Matrix, below: Matrix) -> None:
    origin = element.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(element, "origin")
    xyz, rpy = (
        [float(word) for word in origin.get(key, "0 0 0").split()] for key in ("xyz", "rpy")
    )
    origin.set("xyz", _text(above.T @ np.array(xyz)))
    origin.set("rpy", _text(pin.rpy.matrixToRpy(above.T @ pin.rpy.rpyToMatrix(*rpy) @ below)))


def _text(values: Matrix) -> str:
    return " ".join(repr(float(value)) for value in values)
