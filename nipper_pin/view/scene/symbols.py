"""Springs and stops along joints, which the shapes of a URDF seldom show: coils, plates, pegs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...mechanism import Joint, Mechanism, Stop, joint_axis, joint_placements
from .colours import SPRING, STOP, channels
from .solids import Solid, extent, holds, solids

# Lengths by the size of the picture.
_WIRE, _AROUND, _COIL = 0.022, 0.028, 0.25
_PLATE, _PEG = (0.11, 0.04, 0.015), (0.012, 0.06)
_BAR = 0.016  # half of the width of a link
_ALONG = 0.999  # cosine of the largest angle between a slide and a rod that it lengthens
_STRUCK = 0.6  # place of a peg along its link


def pictured(mechanism: Mechanism) -> tuple[Solid, ...]:
    """Everything that a mechanism is drawn with: its solids, springs on joints, and stops.

    Raises:
        ModelError: A shape of the URDF cannot be read.
    """
    found = solids(mechanism)
    size = _size(mechanism, found)
    # A shape of the URDF that is called like one of these stands for it.
    shown = {(solid.body, solid.name) for solid in found}
    added = (*_coils(mechanism, found, size), *_marks(mechanism, found, size))
    return (*found, *(solid for solid in added if (solid.body, solid.name) not in shown))


def _coils(mechanism: Mechanism, found: Sequence[Solid], size: float) -> Iterator[Solid]:
    """A coil for each joint with springs, unless a shape of the URDF shows one of them."""
    shown = {solid.spring for solid in found}
    named = {spring.index: spring.name for spring in mechanism.springs}
    named |= {spring.index: spring.name for spring in mechanism.tabulated_springs}
    for joint in mechanism.joints:
        if joint.index in named and joint.index not in shown:
            coil = _around if joint.kind == "revolute" else _along
            yield coil(mechanism, joint, f"spring_{named[joint.index]}", size)


def _around(mechanism: Mechanism, joint: Joint, name: str, size: float) -> Solid:
    """A coil around a hinge."""
    parent, at, _ = _carried(mechanism, joint)
    long, across = 4.0 * _AROUND * size, np.array([0.0, 1.0, 0.0])
    place = _placed(at.translation - 0.75 * long * across, across)
    scale = np.array([1.0, 1.0, long])
    return Solid(name, parent, "coil", (_AROUND * size,), None, place, scale, channels(SPRING))


def _along(mechanism: Mechanism, joint: Joint, name: str, size: float) -> Solid:
    """A coil that ends at the link that slides.

    It begins at the joint of the link before it where this one is its rod; else it stands where the
    coordinate grows, as a spring that pushes it down.
    """
    parent, at, axis = _carried(mechanism, joint)
    long, side = float(at.translation @ axis), -1.0
    if parent < 0 or abs(long) <= _ALONG * np.linalg.norm(at.translation[[0, 2]]):
        long = -_COIL * size
    if long > 0.0:
        side = 1.0
    place, scale = _placed(at.translation - long * axis, side * axis), np.ones(3)
    scale[2] = abs(long)
    return Solid(name, parent, "coil", (_WIRE * size,), None, place, scale, channels(SPRING),
                 joint.index, side)  # fmt: skip


def _marks(mechanism: Mechanism, found: Sequence[Solid], size: float) -> Iterator[Solid]:
    """A plate at the end of a slide, a peg beside a link on a hinge; lips have their shapes."""
    for stop in mechanism.stops:
        if stop.contact is None:
            joint = mechanism.joints[stop.index]
            own = [item for item in found if item.body == stop.index]
            mark = _peg if joint.kind == "revolute" else _plate
            yield mark(mechanism, stop, joint, own, size)


def _plate(
    mechanism: Mechanism, stop: Stop, joint: Joint, own: Sequence[Solid], size: float
) -> Solid:
    """A plate across a slide, at the smallest of the link's shapes that holds its origin."""
    parent, at, axis = _carried(mechanism, joint)
    back, edges = -stop.sense * axis, size * np.array(_PLATE)
    reaches = [float((item.corners @ at.rotation.T @ back).max())
               for item in own if item.path is None and holds(item, np.zeros(3))]  # fmt: skip
    far = min((reach for reach in reaches if reach > 0.0), default=0.0) + 0.5 * edges[2]
    place = _placed(at.translation + stop.at * axis + far * back, axis)
    return Solid(f"stop_{stop.name}", parent, "box", tuple(edges.tolist()), None, place, np.ones(3),
                 channels(STOP))  # fmt: skip


def _peg(
    mechanism: Mechanism, stop: Stop, joint: Joint, own: Sequence[Solid], size: float
) -> Solid:
    """A peg across the plane that touches the side of a link when its stop is closed."""
    parent, at, _ = _carried(mechanism, joint)
    corners = np.concatenate([item.corners for item in own])
    far = corners[np.argmax(np.hypot(corners[:, 0], corners[:, 2]))][[0, 2]]
    turn = stop.at * joint.sense + math.atan2(at.rotation[2, 0], at.rotation[0, 0])
    x, z = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]) @ far
    # Towards the side to which the link turns as its stop closes.
    side = -stop.sense * joint.sense * (_BAR + _PEG[0]) * size / math.hypot(x, z)
    place = [_STRUCK * x - side * z, corners[:, 1].mean(), _STRUCK * z + side * x]
    sizes = _PEG[0] * size, _PEG[1] * size
    return Solid(
        f"stop_{stop.name}", parent, "cylinder", sizes, None,
        _placed(at.translation + place, np.array([0.0, 1.0, 0.0])), np.ones(3), channels(STOP),
    )  # fmt: skip


def _size(mechanism: Mechanism, found: Sequence[Solid]) -> float:
    """Larger extent of places and plain shapes, all coordinates at zero [m]."""
    moved = joint_placements(mechanism.model)[1:]
    corners = [item.corners if item.body < 0 else
               item.corners @ moved[item.body].rotation.T + moved[item.body].translation
               for item in found if item.path is None]  # fmt: skip
    extents = np.ptp(np.concatenate(corners)[:, [0, 2]], axis=0).tolist() if corners else []
    return float(max([extent(mechanism), *extents]))


def _carried(mechanism: Mechanism, joint: Joint) -> tuple[int, pin.SE3, FloatArray]:
    """Link before a joint, placement of the joint in its axes at q = 0, direction of a slide."""
    model, number = mechanism.model, joint.index + 1
    parent = int(model.parents[number])
    world = joint_placements(model)
    axis = world[parent].rotation.T @ joint_axis(model, world, number)[:3]
    return parent - 1, model.jointPlacements[number], axis


def _placed(at: FloatArray, along: FloatArray) -> FloatArray:
    """Placement whose z axis has a direction in the plane, or across it, shape (4, 4)."""
    place = np.eye(4)
    aside = np.array([0.0, 1.0, 0.0]) if abs(along[1]) < 0.5 else np.array([1.0, 0.0, 0.0])
    place[:3, 2], place[:3, 1] = along, aside
    place[:3, 0] = np.cross(aside, along)
    place[:3, 3] = at
    return place
