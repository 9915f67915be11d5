"""Drive laws: the coordinate of a driven joint as a function of the cylinder angle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..units import MM_PER_M

Evaluation = tuple[FloatArray, FloatArray, FloatArray]


class DriveLaw(Protocol):
    """Anything that gives a coordinate and its first two derivatives by the cylinder angle."""

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles of one turn at which a higher derivative jumps [rad]; mostly none."""
        ...

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law.

        Args:
            psi: Cylinder angles [rad], any shape, not reduced to one turn.

        Returns:
            Coordinate [rad or m], first [.../rad] and second derivative [.../rad^2] by psi, each of
            the shape of psi.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class OscillatingGuide:
    """A crank pin that slides in a guide bar, which rocks about its own axis.

    Attributes:
        crank_radius_m: Distance of the pin from the cylinder axis [m].
        crank_axis: Cylinder axis (x, z) [m].
        guide_axis: Axis of the guide (x, z) [m].
        guide_offset_m: Distance of the bar's line from the guide axis, positive to the left of the
            direction towards the pin [m].

    Raises:
        InputError: The crank circle reaches the guide axis or its offset, so the guide would turn
            round or jam.
    """

    crank_radius_m: float
    crank_axis: tuple[float, float]
    guide_axis: tuple[float, float]
    guide_offset_m: float = 0.0
    knots_rad: ClassVar[tuple[float, ...]] = ()
    _distance: float = field(init=False, repr=False, compare=False)
    _direction: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Refuse a guide that does not oscillate and keep what does not change."""
        dx = self.crank_axis[0] - self.guide_axis[0]
        dz = self.crank_axis[1] - self.guide_axis[1]
        distance = math.hypot(dx, dz)
        if not 0.0 < self.crank_radius_m < distance:
            message = (
                f"a crank of {MM_PER_M * self.crank_radius_m:g} mm, {MM_PER_M * distance:g} mm "
                "from the guide axis, does not make the guide oscillate: the radius must be the "
                "smaller one"
            )
            raise InputError(message, crank_radius_m=self.crank_radius_m, distance_m=distance)
        if not abs(self.guide_offset_m) < distance - self.crank_radius_m:
            message = (
                f"a guide offset of {MM_PER_M * self.guide_offset_m:g} mm jams the guide: it must "
                f"be smaller than {MM_PER_M * (distance - self.crank_radius_m):g} mm, the least "
                "distance of the pin from the guide axis"
            )
            raise InputError(message, guide_offset_m=self.guide_offset_m, distance_m=distance)
        object.__setattr__(self, "_distance", distance)
        object.__setattr__(self, "_direction", math.atan2(dz, dx))

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``.

        The angle is measured from the line of centres, from which the pin never turns away by a
        right angle, so it is continuous over any number of turns.
        """
        r, d = self.crank_radius_m, self._distance
        turned = psi - self._direction
        across = r * np.sin(turned)
        along = r * np.cos(turned)
        projected = d * along
        square = (d * d + r * r) + 2.0 * projected
        value = np.arctan2(across, along + d) + self._direction
        first = (projected + r * r) / square
        second = (d * (r * r - d * d)) * across / (square * square)
        if self.guide_offset_m == 0.0:
            return value, first, second
        return self._offset(value, first, second, square, d * across, projected)

    def _offset(
        self,
        value: FloatArray,
        first: FloatArray,
        second: FloatArray,
        square: FloatArray,
        swept: FloatArray,
        projected: FloatArray,
    ) -> Evaluation:
        """Subtract the angle between the bar's line and the line to the pin, asin(offset / R)."""
        e = self.guide_offset_m
        slope = -2.0 * swept
        free = np.sqrt(square - e * e)
        value = value - np.arcsin(e / np.sqrt(square))
        first = first + 0.5 * e * slope / (square * free)
        bend = -2.0 * projected - slope * slope * (1.0 / square + 0.5 / (free * free))
        second = second + 0.5 * e * bend / (square * free)
        return value, first, second


@dataclass(frozen=True, kw_only=True)
class Geared:
    """A law multiplied by a gear ratio.

    Attributes:
        of: The law of the other shaft.
        ratio: Turns of this shaft per turn of the other, negative in opposite sense.
    """

    of: DriveLaw
    ratio: float

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Those of the law of the other shaft."""
        return self.of.knots_rad

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        value, first, second = self.of.evaluate(psi)
        return self.ratio * value, self.ratio * first, self.ratio * second


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed:
    """A shaft or a slide that moves in proportion to the cylinder.

    Attributes:
        ratio: Turns of the shaft per turn of the cylinder [-], or travel of the slide [m/rad].
    """

    ratio: float
    knots_rad: ClassVar[tuple[float, ...]] = ()

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        psi = np.asarray(psi, dtype=np.float64)
        return self.ratio * psi, np.full_like(psi, self.ratio), np.zeros_like(psi)


@dataclass(frozen=True, kw_only=True)
class Fourier:
    """A Fourier series in the cylinder angle.

    Attributes:
        mean: Mean value [rad or m].
        cosine: Coefficients of cos psi, cos 2 psi, ... [rad or m].
        sine: Coefficients of sin psi, sin 2 psi, ... [rad or m].
    """

    mean: float
    cosine: tuple[float, ...] = ()
    sine: tuple[float, ...] = ()
    knots_rad: ClassVar[tuple[float, ...]] = ()
    _orders: FloatArray = field(init=False, repr=False, compare=False)
    _weights: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Lay out the coefficients of the value and both derivatives as one matrix."""
        count = max(len(self.cosine), len(self.sine))
        c, s = np.zeros(count), np.zeros(count)
        c[: len(self.cosine)] = self.cosine
        s[: len(self.sine)] = self.sine
        n = np.arange(1.0, count + 1.0)
        weights = np.vstack(
            [np.hstack([c, s]), np.hstack([n * s, -n * c]), np.hstack([-n * n * c, -n * n * s])]
        )
        object.__setattr__(self, "_orders", n)
        object.__setattr__(self, "_weights", weights.T.copy())

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        angles = np.multiply.outer(psi, self._orders)
        sums = np.concatenate([np.cos(angles), np.sin(angles)], axis=-1) @ self._weights
        return sums[..., 0] + self.mean, sums[..., 1], sums[..., 2]


@dataclass(frozen=True, kw_only=True)
class Table:
    """A periodic quintic spline (four continuous derivatives) through a table over one turn.

    Attributes:
        cylinder_angle_rad: Angles, rising over exactly one turn, at least seven [rad].
        coordinate: Coordinate at each angle, equal at both ends [rad or m].

    Raises:
        InputError: The table is not one turn of a periodic function.
    """

    cylinder_angle_rad: tuple[float, ...]
    coordinate: tuple[float, ...]
    _splines: tuple[Callable[[FloatArray], FloatArray], ...] = field(
        init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        """Check the table and fit the spline."""
        from scipy.interpolate import make_interp_spline

        check_table(self.cylinder_angle_rad, self.coordinate)
        angles = np.array(self.cylinder_angle_rad)
        values = np.array(self.coordinate)
        # The ends agree only to the accuracy of the check; the periodic spline needs them equal.
        angles[-1] = angles[0] + math.tau
        values[-1] = values[0]
        spline = make_interp_spline(angles, values, k=5, bc_type="periodic")
        object.__setattr__(self, "_splines", (spline, spline.derivative(1), spline.derivative(2)))

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles of the rows: the spline changes its polynomial there [rad]."""
        return self.cylinder_angle_rad[1:]

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        start = self.cylinder_angle_rad[0]
        reduced = start + np.remainder(np.subtract(psi, start), math.tau)
        value, first, second = (spline(reduced) for spline in self._splines)
        return value, first, second


def check_table(cylinder_angle_rad: Sequence[float], coordinate: Sequence[float]) -> None:
    """Refuse a table that is not one turn of a periodic function.

    Args:
        cylinder_angle_rad: Angles [rad].
        coordinate: Coordinate at each angle [rad or m].

    Raises:
        InputError: Says in which row (from 1) and why.
    """
    angles = np.asarray(cylinder_angle_rad, dtype=np.float64)
    values = np.asarray(coordinate, dtype=np.float64)
    message = ""
    if angles.shape != values.shape or angles.size < 7:
        message = (
            f"a drive table needs at least 7 rows with an angle and a coordinate each; found "
            f"{angles.size} angles and {values.size} coordinates"
        )
    elif not (np.isfinite(angles) & np.isfinite(values)).all():
        row = int(np.argmin(np.isfinite(angles) & np.isfinite(values)))
        message = f"row {row + 1} of the drive table holds a value that is not a finite number"
    elif (np.diff(angles) <= 0.0).any():
        row = int(np.argmax(np.diff(angles) <= 0.0)) + 1
        message = (
            f"the cylinder angle must rise from row to row; row {row + 1} of the drive table has "
            f"{math.degrees(angles[row]):g} after {math.degrees(angles[row - 1]):g} deg"
        )
    elif abs(angles[-1] - angles[0] - math.tau) > 1e-9:
        message = (
            "a drive table must span exactly one turn, first and last row 360 deg apart; it spans "
            f"{math.degrees(angles[-1] - angles[0]):g} deg"
        )
    elif abs(values[-1] - values[0]) > 1e-9:
        message = (
            "the first and the last row of a drive table are the same position and need the same "
            f"coordinate; found {values[0]:g} and {values[-1]:g} [rad or m]"
        )
    if message:
        raise InputError(message, rows=int(angles.size))
