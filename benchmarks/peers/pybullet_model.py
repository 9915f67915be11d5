"""The mechanism as PyBullet reads it: a bare tree, and pins that close its loops."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import pybullet

STRONG = 1e9
"""Largest force of motors and pins [N or N m], never reached."""


def bare_urdf(urdf: str) -> str:
    """The tree without shapes and without links that only name a point (PyBullet weighs them)."""
    root = ElementTree.fromstring(urdf)
    for joint in root.findall("joint[@type='fixed']"):
        root.remove(joint)
    parents = {joint.get("link") for joint in root.findall("joint/parent")}
    for link in root.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
        if link.find("inertial") is None:
            if link.get("name") in parents:
                # The frame stands still, but PyBullet writes to the terminal if it has no mass.
                inertial = ElementTree.SubElement(link, "inertial")
                ElementTree.SubElement(inertial, "mass", value="1")
                ElementTree.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1",
                                       ixy="0", ixz="0", iyz="0")  # fmt: skip
            else:
                root.remove(link)
    return ElementTree.tostring(root, encoding="unicode")


def pin_frames(
    body: int, places: dict[str, int], model: Any, a: Any, b: Any, here: dict[str, int]
) -> None:
    """Pin two frames to each other; points count from the centres of mass, as Bullet requires."""

    def end(frame: Any) -> tuple[int, list[float]]:
        if not frame.parentJoint:
            return -1, list(frame.placement.translation)
        lever = model.inertias[frame.parentJoint].lever
        return places[model.names[frame.parentJoint]], list(frame.placement.translation - lever)

    (link, point), (other, point_other) = end(a), end(b)
    child = body if other >= 0 else -1
    pin = pybullet.createConstraint(body, link, child, other, pybullet.JOINT_POINT2POINT,
                                    [0.0] * 3, point, point_other, **here)  # fmt: skip
    pybullet.changeConstraint(pin, maxForce=STRONG, **here)
