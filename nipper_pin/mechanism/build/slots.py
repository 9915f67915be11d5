"""Pins in slots: each gets a sliding block in the tree, and a plain pin closes the loop.

A pin in a slot leaves one planar equation, for which Pinocchio has no constraint. A block that
slides in the slot on a prismatic joint and carries the pin is the same machine: one coordinate more
and two equations, which are exact. The block is a point mass. It needs some mass, because the
dynamics of the tree are solved before the closures are met, and a body without any would accelerate
infinitely there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np

from ...errors import ModelError, UnknownNameError
from ..edit.layout import read_layout
from ..edit.points import text_of
from ..files.description import ClosureDescription
from ..files.urdf import Urdf, UrdfJoint, parse_xml

_AXES: dict[str, tuple[float, float, float]] = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0)}


def block_of(closure: str) -> str:
    """Name of the link that slides in the slot of a closure."""
    return f"{closure}_block"


def check_frames(closures: Mapping[str, ClosureDescription], urdf: Urdf, file: str) -> None:
    """Check that the frames of closures exist and that slots are described in full.

    Args:
        closures: The closures of the TOML file, by name.
        urdf: The checked URDF.
        file: Name of the TOML file, for messages.

    Raises:
        UnknownNameError: A frame does not exist.
        ModelError: A slot lacks its axis or its block, or the name of the block is taken.
    """
    for name, closure in closures.items():
        key = f"closures.{name}"
        for side in ("frame_a", "frame_b"):
            frame = getattr(closure, side)
            if frame not in urdf.links:
                where = f"{file}: {key}.{side}"
                raise UnknownNameError(kind="frame", name=frame, known=urdf.links, where=where)
        if (closure.slot_axis is None) != (closure.block_mass_kg is None):
            missing = "slot_axis" if closure.slot_axis is None else "block_mass_kg"
            allowed = (
                "a pin in a slot has slot_axis and block_mass_kg (the mass of the sliding block, "
                "above 0), a plain pin neither"
            )
            raise ModelError(file=file, key=f"{key}.{missing}", value=None, allowed=allowed)
        if closure.slot_axis is None:
            continue
        if name in urdf.joints or block_of(name) in urdf.links:
            allowed = (
                f"a slot needs a name of its own: its block slides on a joint {name!r} as the link "
                f"{block_of(name)!r}, and the URDF has one of them already"
            )
            raise ModelError(file=file, key=key, value=name, allowed=allowed)


def with_blocks(
    text: str,
    urdf: Urdf,
    closures: Mapping[str, ClosureDescription],
    file: str,
) -> tuple[str, Urdf]:
    """Put the blocks of all slots into the tree.

    In the touch configuration a block stands where the line of its slot, through the origin of
    ``frame_a``, comes nearest to the origin of ``frame_b``; its coordinate is zero there and grows
    along the axis of ``frame_a``.

    Args:
        text: The URDF.
        urdf: The same, checked.
        closures: The closures, checked.
        file: Name of the URDF file, for messages.

    Returns:
        The URDF with a link and a prismatic joint for each slot, and its parts.
    """
    slots = {name: item for name, item in closures.items() if item.slot_axis is not None}
    if not slots:
        return text, urdf
    root = parse_xml(text, file)
    found = read_layout(root, {}, file)
    links, joints = list(urdf.links), dict(urdf.joints)
    shapes, masses = dict(urdf.shapes), dict(urdf.masses)
    for name, closure in slots.items():
        axis, block = _AXES[closure.slot_axis or "x"], block_of(name)
        frame = closure.frame_a
        apart = found.turn[frame].T @ (found.place[closure.frame_b] - found.place[frame])
        along = float(apart @ axis)
        link = ElementTree.SubElement(root, "link", name=block)
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value=repr(closure.block_mass_kg))
        none = {f"i{part}": "0" for part in ("xx", "xy", "xz", "yy", "yz", "zz")}
        ElementTree.SubElement(inertial, "inertia", none)
        joint = ElementTree.SubElement(root, "joint", name=name, type="prismatic")
        ElementTree.SubElement(joint, "parent", link=frame)
        ElementTree.SubElement(joint, "child", link=block)
        ElementTree.SubElement(joint, "origin", xyz=text_of(along * np.array(axis)), rpy="0 0 0")
        ElementTree.SubElement(joint, "axis", xyz=text_of(np.array(axis)))
        # A URDF requires limits; these are never reached.
        ElementTree.SubElement(
            joint, "limit", lower="-1e9", upper="1e9", effort="1e9", velocity="1e9"
        )
        links.append(block)
        joints[name] = UrdfJoint(name=name, kind="prismatic", parent=frame, child=block, axis=axis)
        shapes[block] = ()
        masses[block] = closure.block_mass_kg or 0.0
    changed = replace(urdf, links=tuple(links), joints=joints, shapes=shapes, masses=masses)
    return ElementTree.tostring(root, encoding="unicode"), changed
