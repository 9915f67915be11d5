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

import numpy as np
import pinocchio as pin

from ...errors import ModelError, UnknownNameError
from ..files.description import ClosureDescription
from ..files.urdf_parts import Urdf, UrdfJoint, UrdfLink

_AXES: dict[str, tuple[float, float, float]] = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0)}


def block_of(closure: str) -> str:
    """Name of the link that slides in the slot of a closure."""
    return f"{closure}_block"


def check_frames(closures: Mapping[str, ClosureDescription], urdf: Urdf, file: str) -> None:
    """Check that the frames of closures exist and that slots are described in full.

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


def with_blocks(urdf: Urdf, closures: Mapping[str, ClosureDescription]) -> Urdf:
    """Put the blocks of all slots into the tree.

    In the touch configuration a block stands where the line of its slot, through the origin of
    ``frame_a``, comes nearest to the origin of ``frame_b``; its coordinate is zero there and grows
    along the axis of ``frame_a``.

    Args:
        closures: The closures, checked.

    Returns:
        The URDF with a link and a prismatic joint for each slot.
    """
    slots = {name: item for name, item in closures.items() if item.slot_axis is not None}
    if not slots:
        return urdf
    places = {urdf.root: pin.SE3.Identity()}
    for joint in urdf.downwards():
        places[joint.child] = places[joint.parent] * joint.placement
    links, joints = dict(urdf.links), dict(urdf.joints)
    for name, closure in slots.items():
        axis, block = _AXES[closure.slot_axis or "x"], block_of(name)
        frame = closure.frame_a
        apart = places[frame].actInv(places[closure.frame_b].translation)
        along = float(apart @ axis) * np.array(axis)
        links[block] = UrdfLink(
            inertia=pin.Inertia(closure.block_mass_kg, np.zeros(3), np.zeros((3, 3)))
        )
        joints[name] = UrdfJoint(
            name=name,
            kind="prismatic",
            parent=frame,
            child=block,
            placement=pin.SE3(np.eye(3), along),
            axis=axis,
        )
    return replace(urdf, links=links, joints=joints)
