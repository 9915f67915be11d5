"""Points of a growing linkage over a turn of its crank, dyad by dyad, in closed form.

A dyad is two links and three joints that two links more are joined by: each letter is a pin (R) or
a slide (P). It adds no freedom, so a crank and any dyads move as the crank says. Points of the
drawing are complex numbers x + i z [mm], of shape (angles,) where they move.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.drawing import FRAME

Complex = NDArray[np.complex128]

ANGLES = np.radians(np.arange(0.0, 360.0, 3.0))
"""Angles of the crank at which the motion is tabulated [rad]."""


class NoAssemblyError(Exception):
    """A dyad does not close over the whole turn, or comes too near to a dead centre."""


@dataclass(frozen=True)
class Pose:
    """Motion of a body: one of its points [mm] and its continuous angle [rad], (angles,) each."""

    point: Complex
    angle: FloatArray

    def at(self, place: complex) -> Complex:
        """A point of the body, by its place in the body's axes [mm]; shape (angles,)."""
        return self.point + place * unit(self.angle)


@dataclass(frozen=True)
class Rod:
    """A rod that moves what a dyad moves."""

    name: str
    length: float  # [mm]
    driving: Complex  # its driven end, shape (angles,) [mm]
    # Its other end [mm], by the value that the coordinate keeps.
    held: Callable[[float], Complex | complex]


@dataclass(frozen=True)
class Output:
    """Continuous coordinate of a joint that a dyad, or its rod, moves, (angles,) [rad or mm]."""

    joint: str
    coordinate: FloatArray
    hinge: bool
    rod: Rod | None = None


def still(place: complex) -> Complex:
    """A point that does not move, shape (angles,) [mm]."""
    return np.full(len(ANGLES), place, dtype=complex)


def unit(angle: FloatArray | float) -> Complex:
    """Directions of angles [rad], of their shape."""
    return np.asarray(np.exp(1j * np.asarray(angle)))


def heading(first: Complex, second: Complex) -> FloatArray:
    """Angle of the way from one point to another, continuous, shape (angles,) [rad].

    Raises:
        NoAssemblyError: They nearly meet.
    """
    way = second - first
    if np.abs(way).min() < 0.05 * np.abs(way).max():
        raise NoAssemblyError
    return np.asarray(np.unwrap(np.angle(way)))


def two_rods(
    first: Complex, l_first: float, second: Complex, l_second: float, side: float, least: float
) -> Complex:
    """The pin of two rods of these ends and lengths, shape (angles,) [mm].

    The side is 1 to the left of the way from first to second, -1 to the right; the rods stand at an
    angle of this least sine.

    Raises:
        NoAssemblyError: They do not meet, or their angle is too flat.
    """
    way = second - first
    apart = np.abs(way)
    along = (apart**2 + l_first**2 - l_second**2) / (2.0 * np.maximum(apart, 1e-9))
    high = l_first**2 - along**2
    # Twice the triangle's area, by the rods and by its height.
    if high.min() <= 0.0 or (apart * np.sqrt(np.maximum(high, 0.0))).min() < (
        least * l_first * l_second
    ):
        raise NoAssemblyError
    return np.asarray(first + (along + 1j * side * np.sqrt(high)) * way / apart)


def rod_on_line(
    end: Complex, length: float, at: complex, along: float, side: float, least: float
) -> FloatArray:
    """Travel of a block on a still line that a rod, driven at its end, moves, (angles,) [mm].

    The line goes through a point at an angle [rad], at one to the rod of this least cosine; the
    side is 1 for the block further along it, -1 for the other one.

    Raises:
        NoAssemblyError: It does not reach the line, or stands too square to it.
    """
    seen = (end - at) * unit(-along)
    reach = length**2 - seen.imag**2
    if reach.min() < (least * length) ** 2:
        raise NoAssemblyError
    return np.asarray(seen.real + side * np.sqrt(reach))


def crossing(
    first: Complex, way_first: Complex, second: Complex, way_second: Complex, least: float
) -> tuple[FloatArray, FloatArray]:
    """Distances from a point of each of two lines to their intersection, (angles,) each [mm].

    Ways are directions of size one, ``least`` is the least sine of the angle between them.

    Raises:
        NoAssemblyError: They are too nearly parallel.
    """
    cross, apart = (way_first.conj() * way_second).imag, second - first
    if np.abs(cross).min() < least:
        raise NoAssemblyError
    to_first, to_second = ((apart.conj() * way).imag / cross for way in (way_second, way_first))
    return to_first, to_second


POSES = {FRAME: Pose(still(0j), np.zeros(len(ANGLES)))}
"""Where every linkage begins: the frame."""
