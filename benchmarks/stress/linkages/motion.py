"""Points of a growing linkage over a turn of its crank, dyad by dyad, in closed form.

A dyad is two links and three joints that two links more are joined by: each letter is a pin (R) or
a slide (P). It adds no freedom, so a crank and any dyads move as the crank says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.drawing import FRAME

ANGLES = np.radians(np.arange(0.0, 360.0, 3.0))
"""Angles of the crank at which the motion is tabulated [rad]."""


class NoAssemblyError(Exception):
    """A dyad does not close over the whole turn, or comes too near to a dead centre."""


@dataclass(frozen=True)
class Pose:
    """Motion of a body.

    Attributes:
        point: Place of one of its points, shape (angles, 2) [mm].
        angle: Its angle, continuous, shape (angles,) [rad].
    """

    point: FloatArray
    angle: FloatArray

    def at(self, along: float, aside: float) -> FloatArray:
        """A point of the body, by its place in the body's axes [mm]; shape (angles, 2)."""
        return self.point + along * unit(self.angle) + aside * unit(self.angle + 0.5 * np.pi)


@dataclass(frozen=True)
class Rod:
    """A rod that moves what a dyad moves.

    Attributes:
        length: Its length [mm].
        driving: Its driven end, shape (angles, 2) [mm].
        held: Where its other end is while the coordinate that it moves keeps a value [mm].
    """

    name: str
    length: float
    driving: FloatArray
    held: Callable[[float], FloatArray]


@dataclass(frozen=True)
class Output:
    """Motion of a dyad relative to the frame or the link that carries it.

    Attributes:
        joint: Name of the joint.
        coordinate: Its coordinate, continuous, shape (angles,) [rad or mm].
        hinge: Whether it is an angle.
        rod: The rod that moves it, if there is one.
    """

    joint: str
    coordinate: FloatArray
    hinge: bool
    rod: Rod | None = None


def still(place: FloatArray) -> FloatArray:
    """A point that does not move, shape (angles, 2) [mm]."""
    return np.broadcast_to(np.asarray(place, dtype=np.float64), (len(ANGLES), 2))


def unit(angle: FloatArray | float) -> FloatArray:
    """Directions of angles [rad], shape (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def heading(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angle of the way from one point to another, continuous, shape (angles,) [rad].

    Raises:
        NoAssemblyError: They nearly meet.
    """
    way = second - first
    size = np.linalg.norm(way, axis=1)
    if size.min() < 0.05 * size.max():
        raise NoAssemblyError
    return np.asarray(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))


def two_rods(
    first: FloatArray,
    l_first: float,
    second: FloatArray,
    l_second: float,
    side: float,
    least: float,
) -> FloatArray:
    """The pin of two rods, shape (angles, 2) [mm].

    Args:
        first: End of the first rod, shape (angles, 2) [mm].
        l_first: Its length [mm].
        second: End of the second rod, shape (angles, 2) [mm].
        l_second: Its length [mm].
        side: 1 to the left of the way from first to second, -1 to the right.
        least: Least sine of the angle between the rods.

    Raises:
        NoAssemblyError: They do not meet, or their angle is too flat.
    """
    way = second - first
    apart = np.linalg.norm(way, axis=1)
    along = (apart**2 + l_first**2 - l_second**2) / (2.0 * np.maximum(apart, 1e-9))
    high = l_first**2 - along**2
    # Twice the triangle's area, by the rods and by its height.
    if high.min() <= 0.0 or (apart * np.sqrt(np.maximum(high, 0.0))).min() < (
        least * l_first * l_second
    ):
        raise NoAssemblyError
    ahead = way / apart[:, None]
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    return np.asarray(first + along[:, None] * ahead + side * np.sqrt(high)[:, None] * left)


def rod_on_line(
    end: FloatArray, length: float, at: FloatArray, along: float, side: float, least: float
) -> FloatArray:
    """Travel of a block on a still line that a rod moves, shape (angles,) [mm].

    Args:
        end: The rod's driven end, shape (angles, 2) [mm].
        length: Its length [mm].
        at: A point of the line, shape (2,) [mm].
        along: The line's angle [rad].
        side: 1 for the block further along the line, -1 for the other one.
        least: Least cosine of the angle between rod and line.

    Raises:
        NoAssemblyError: It does not reach the line, or stands too square to it.
    """
    foot = (end - at) @ unit(along)
    aside = (end - at) @ unit(along + 0.5 * np.pi)
    reach = length**2 - aside**2
    if reach.min() < (least * length) ** 2:
        raise NoAssemblyError
    return np.asarray(foot + side * np.sqrt(reach))


def crossing(
    first: FloatArray,
    way_first: FloatArray,
    second: FloatArray,
    way_second: FloatArray,
    least: float,
) -> tuple[FloatArray, FloatArray]:
    """Distances along two lines to their intersection, each of shape (angles,) [mm].

    Args:
        first: A point of the first line, shape (angles, 2) [mm].
        way_first: Its direction, unit vectors.
        second: A point of the second line, shape (angles, 2) [mm].
        way_second: Its direction, unit vectors.
        least: Least sine of the angle between them.

    Raises:
        NoAssemblyError: They are too nearly parallel.
    """
    cross = _cross(way_first, way_second)
    if np.abs(cross).min() < least:
        raise NoAssemblyError
    return _cross(second - first, way_second) / cross, _cross(second - first, way_first) / cross


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


GROUND = Pose(still(np.zeros(2)), np.zeros(len(ANGLES)))
"""The frame."""

POSES = {FRAME: GROUND}
"""Where every linkage begins."""
