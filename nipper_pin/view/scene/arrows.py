"""Arrows of impulses: stops that have one, place, size and duration."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arrays import FloatArray
from ...hybrid import Solution
from ...hybrid.result.quantities import force_unit
from ...mechanism import Mechanism, Stop, joint_axis, joint_placements
from .pace import Pace

_HELD = 0.6  # seconds of playback that the arrow of an impulse is shown in full
_FADE = 0.4  # seconds after that in which it shrinks to nothing
JUMP = 1e-3  # seconds in which something changes at once
_LENGTH = 0.18  # of the reach of the mechanism, for the largest impulse
_HEAD = 0.28  # of the length
_THICK = 0.022  # of the length
_WIDE = 3.0  # of the thickness


def arrow_stops(mechanism: Mechanism) -> tuple[Stop, ...]:
    """Stops whose impulses are drawn: all whose impulse is a force by time, and not a moment."""
    return tuple(stop for stop in mechanism.stops if force_unit(mechanism, stop) == "N")


def arrow_shares(solution: Solution, pace: Pace) -> Iterator[tuple[Stop, FloatArray, FloatArray]]:
    """Size of each arrow along a film: as the impulse for a moment after a collision, else nothing.

    Yields:
        The stop; times on the viewer's clock, shape (K,) [s]; sizes there by that of the largest
        arrow, shape (K,), with straight lines between them.
    """
    stops = arrow_stops(solution.mechanism)
    names = {stop.name for stop in stops}
    hits = [hit for hit in solution.collisions if hit.t <= pace.machine[-1] and hit.stop in names]
    largest = max((hit.impulse for hit in hits), default=0.0)
    end = float(pace.playback[-1])
    for stop in stops:
        keys = [(0.0, 0.0)]
        for hit in hits:
            if hit.stop != stop.name or largest <= 0.0:
                continue
            start, size = float(pace.playback_at(hit.t)), hit.impulse / largest
            # A new collision takes the arrow over from the one before it.
            before = max(start - JUMP, 0.0)
            left = float(np.interp(before, *np.transpose(keys)))
            keys = [key for key in keys if key[0] < before] or [(0.0, 0.0)]
            keys += [(before, left), (start, size), (start + _HELD, size),
                     (start + _HELD + _FADE, 0.0)]  # fmt: skip
        keys = [*(key for key in keys if key[0] < end), (end, 0.0)]
        times, sizes = np.transpose(keys)
        yield stop, times, sizes


def arrow_body(mechanism: Mechanism, stop: Stop) -> int:
    """Place in ``mechanism.joints`` of the link that carries the arrow of a stop, or ``FIXED``."""
    return int(mechanism.model.parents[stop.index + 1]) - 1


def arrow_place(mechanism: Mechanism, stop: Stop) -> FloatArray:
    """Placement of an arrow in the link that carries it, shape (4, 4) [m].

    The arrow points along its y axis: for a contact of lips the way of the impulse on the opening
    lip, for a stop along a slide the way of the impulse on the child link.
    """
    model, joint = mechanism.model, stop.index + 1
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
