"""Arrows of impulses: stops that have one, place, size and duration."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...hybrid import Collision, Solution
from ...hybrid.result.quantities import force_unit
from ...mechanism import Mechanism, Stop, joint_axis, joint_placements
from .solids import FIXED

HELD = 0.6  # seconds of playback that the arrow of an impulse is shown in full
FADE = 0.4  # seconds after that in which it shrinks to nothing
_LENGTH = 0.18  # of the reach of the mechanism, for the largest impulse
_HEAD = 0.28  # of the length
_THICK = 0.022  # of the length
_WIDE = 3.0  # of the thickness


def arrow_stops(mechanism: Mechanism) -> tuple[Stop, ...]:
    """Stops whose impulses are drawn: all whose impulse is a force by time, and not a moment."""
    return tuple(stop for stop in mechanism.stops if force_unit(mechanism, stop) == "N")


def drawn_collisions(solution: Solution, end: float) -> list[Collision]:
    """Collisions whose impulses are drawn until a time [s]; the largest has the whole arrow."""
    drawn = {stop.name for stop in arrow_stops(solution.mechanism)}
    return [item for item in solution.collisions if item.t <= end and item.stop in drawn]


def arrow_body(mechanism: Mechanism, stop: Stop) -> int:
    """Place in ``mechanism.joints`` of the link that carries the arrow of a stop, or ``FIXED``."""
    model = mechanism.model
    parent = model.parents[_joint(mechanism, stop)]
    order = [model.getJointId(joint.name) for joint in mechanism.joints]
    return order.index(parent) if parent else FIXED


def arrow_place(mechanism: Mechanism, stop: Stop) -> FloatArray:
    """Placement of an arrow in the link that carries it, shape (4, 4) [m].

    The arrow points along its y axis: for a contact of lips the way of the impulse on the opening
    lip, for a stop along a slide the way of the impulse on the child link.
    """
    model, joint = mechanism.model, _joint(mechanism, stop)
    world = joint_placements(model)
    if stop.contact is not None:
        point, direction = stop.contact.point, stop.contact.normal
    else:
        axis = joint_axis(model, world, joint)
        point, direction = world[joint].translation, stop.sense * axis[:3]
    place = np.eye(4)
    place[:3, 1] = direction / np.linalg.norm(direction)
    place[:3, 2] = (0.0, 1.0, 0.0)
    place[:3, 0] = np.cross(place[:3, 1], place[:3, 2])
    place[:3, 3] = point
    return np.asarray(world[model.parents[joint]].inverse().homogeneous @ place)


def arrow_sizes(mechanism: Mechanism) -> tuple[float, float, float, float]:
    """Length and radius of the shaft, length and radius of the head of the largest arrow [m]."""
    long = _LENGTH * mechanism.reach_m
    thick = _THICK * long
    return (1.0 - _HEAD) * long, thick, _HEAD * long, _WIDE * thick


def arrow_scale(share: FloatArray | float) -> FloatArray:
    """Scale of an arrow in its own axes.

    Args:
        share: Impulse by the largest one of the film, shape () or (K,) [-].

    Returns:
        Scale, shape (3,) or (K, 3) [-].
    """
    # A scale of zero would make a singular matrix.
    long = np.maximum(share, 1e-6)
    # Length shows the impulse; width shrinks less, so that small arrows stay arrows.
    return np.stack([np.sqrt(long), long, np.sqrt(long)], axis=-1)


def _joint(mechanism: Mechanism, stop: Stop) -> int:
    """Identity of the joint that a stop acts on in Pinocchio's model."""
    name = next(joint.name for joint in mechanism.joints if joint.index == stop.index)
    return int(mechanism.model.getJointId(name))
