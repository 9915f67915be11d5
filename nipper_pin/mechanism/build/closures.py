"""Closures in the touch configuration: blocks for pins in slots, and gaps that rounding leaves.

A pin in a slot leaves one planar equation, for which Pinocchio has no constraint. A block that
slides in the slot on a prismatic joint and carries the pin is the same machine: one coordinate more
and two equations, which are exact. The block is a point mass. It needs some mass, because the
dynamics of the tree are solved before the closures are met, and a body without any would accelerate
infinitely there.

A program that writes a URDF with five to eight digits leaves the two frames of a cut joint some
micrometres apart. The loop is closed in the touch configuration, by moving the frames: each by half
of the gap, the least that does it, and where several closures share a frame by the least sum of
squares. Links, masses and shapes stay where the file has them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import AssemblyError, ModelError, looked_up
from ...tolerances.mechanics import ASSEMBLY_TOLERANCE_M, ROUNDED_SHARE
from ...units import MM_PER_M
from ..files.description import ClosureDescription
from ..files.urdf_parts import Urdf, UrdfJoint, UrdfLink
from ..parts import Closure, Stop
from ..scale import reach, unit_of, written
from .placements import own_name
from .tree import Tree, add_own_frame

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
            looked_up("frame", getattr(closure, side), urdf.links, f"{file}: {key}.{side}")
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


PLANE = (0, 2)
"""Places of x and z in a vector of three."""


def frame_point(frame: str, model: pin.Model, placements: list[pin.SE3]) -> FloatArray:
    """World position of a frame's origin at q = 0, shape (3,)."""
    item = model.frames[model.getFrameId(frame, pin.FrameType.BODY)]
    return np.array((placements[item.parentJoint] * item.placement).translation)


def closure_gaps(
    closures: Sequence[Closure], model: pin.Model, placements: list[pin.SE3]
) -> FloatArray:
    """Gap of every closure at q = 0, frame b minus frame a.

    Returns:
        Gaps along x and z [m], shape (closures, 2).
    """
    gaps = [
        frame_point(closure.frame_b, model, placements)
        - frame_point(closure.frame_a, model, placements)
        for closure in closures
    ]
    return np.array(gaps).reshape(-1, 3)[:, PLANE]


def close_gaps(
    closures: Sequence[Closure], stops: Sequence[Stop], tree: Tree
) -> tuple[Closure, ...]:
    """Close what rounded numbers leave open; a machine that meets stays to the last bit.

    Args:
        stops: The stops, which tell the size of a machine of slides.
        tree: The tree; frames of its model are moved.

    Returns:
        The closures, each with the gap that was closed.

    Raises:
        AssemblyError: A gap is too large for that.
    """
    gaps = closure_gaps(closures, tree.model, tree.placements)
    lengths = np.linalg.norm(gaps, axis=1)
    reach_m = reach(tree.model, tree.joints, stops)
    within_m = ASSEMBLY_TOLERANCE_M * written(unit_of(reach_m))
    if not (lengths > within_m).any():
        return tuple(closures)
    most_m = max(within_m, ROUNDED_SHARE * reach_m)
    for closure, gap, length in zip(closures, gaps, lengths, strict=True):
        if length > most_m:
            raise _gaping(closure, gap, within_m, most_m, tree)
    gaps[lengths <= within_m] = 0.0
    _move_frames(closures, gaps, tree)
    pairs = [(float(x), float(z)) for x, z in gaps]
    return tuple(replace(closure, gap_m=gap) for closure, gap in zip(closures, pairs, strict=True))


def _move_frames(closures: Sequence[Closure], gaps: FloatArray, tree: Tree) -> None:
    """Move the frames of closures by as little as closes the gaps."""
    ends = [(closure.frame_a, closure.frame_b) for closure in closures]
    frames = list(dict.fromkeys(name for pair in ends for name in pair))
    opening = np.zeros((len(ends), len(frames)))
    for row, (first, second) in zip(opening, ends, strict=True):
        row[frames.index(first)], row[frames.index(second)] = -1.0, 1.0
    moves = -np.linalg.lstsq(opening, gaps)[0]
    model = tree.model
    for name, (x, z) in zip(frames, moves, strict=True):
        if not (x or z):
            continue
        frame = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
        if not model.existFrame(own_name(name), pin.FrameType.OP_FRAME):
            # What is drawn of the link stays.
            add_own_frame(model, name, frame.placement)
            frame = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
        shift = tree.placements[frame.parentJoint].rotation.T @ np.array([x, 0.0, z])
        frame.placement = pin.SE3(frame.placement.rotation, frame.placement.translation + shift)


def _gaping(
    closure: Closure, gap: FloatArray, within_m: float, most_m: float, tree: Tree
) -> AssemblyError:
    """The error of a closure whose frames do not meet."""
    x, z = MM_PER_M * gap
    meet, rounded = "the frames meet", ""
    if closure.slot_frame is not None:
        meet = "the pin stands on the line of its slot"
        if closure.slot_frame in tree.urdf.own_axes:
            meet += (
                f" (that is the {closure.slot_axis} of the side view, as the y axis of "
                f"{closure.slot_frame} does not point into the page)"
            )
    if most_m > within_m:
        rounded = (
            f"; up to {MM_PER_M * most_m:.3g} mm, {ROUNDED_SHARE:g} of the machine's reach, would "
            "be taken for rounded numbers and closed"
        )
    return AssemblyError(
        file=tree.file,
        key=f"closures.{closure.name}",
        value=f"a gap of {np.hypot(x, z):.6g} mm (x {x:.6g}, z {z:.6g}) from {closure.first_side} "
        f"to {closure.frame_b}",
        allowed=f"{meet} within {MM_PER_M * within_m:g} mm in the touch configuration, where all "
        f"joint coordinates are zero{rounded}: correct the origins of the joints that carry the "
        f"two, or place {closure.frame_b} by x {-x + 0.0:.6g} and z {-z + 0.0:.6g} mm (side view) "
        "elsewhere",
    )
