"""Motion of the input shaft and of the joints it drives, as functions of time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray
from ..mechanism import DriveLaw, Geared, Mechanism

Driven = tuple[FloatArray, FloatArray, FloatArray]
"""Coordinates, rates and accelerations of the driven joints at N times, each (N, drives)."""


@dataclass(frozen=True)
class ShaftMotion:
    """Constant cylinder speed and the driven coordinates that follow from it.

    Attributes:
        mechanism: The mechanism.
        speed_rad_s: Cylinder speed, positive [rad/s].
        start_angle_rad: Cylinder angle psi at time zero [rad].
    """

    mechanism: Mechanism
    speed_rad_s: float
    start_angle_rad: float

    @property
    def indices(self) -> list[int]:
        """Places of the driven coordinates in q."""
        return [drive.index for drive in self.mechanism.drives]

    @property
    def rate(self) -> float:
        """Rate of the cylinder angle, with its sign [rad/s]."""
        return self.mechanism.cylinder.sense * self.speed_rad_s

    @property
    def period(self) -> float:
        """Time of one turn [s]."""
        return float(2.0 * np.pi / self.speed_rad_s)

    def angle(self, t: FloatArray | float) -> FloatArray:
        """Cylinder angle psi [rad] at times t [s]."""
        return np.asarray(self.start_angle_rad + self.rate * np.asarray(t))

    def driven(self, t: FloatArray) -> Driven:
        """Driven coordinates, rates and accelerations.

        Args:
            t: Times, shape (N,) [s].

        Returns:
            Three arrays of shape (N, drives): [rad], [rad/s], [rad/s^2].
        """
        psi, rate = self.angle(t), self.rate
        values = np.empty((3, len(psi), len(self.mechanism.drives)))
        for law, geared in self._trains:
            value, slope, curvature = law.evaluate(psi)
            for column, ratio, at_touch in geared:
                values[0, :, column] = ratio * value - at_touch
                values[1, :, column] = (ratio * rate) * slope
                values[2, :, column] = (ratio * rate**2) * curvature
        return values[0], values[1], values[2]

    @cached_property
    def _trains(self) -> list[tuple[DriveLaw, list[tuple[int, float, float]]]]:
        """Laws that stand on their own, each with the drives geared to it: place, ratio, offset."""
        trains: dict[int, tuple[DriveLaw, list[tuple[int, float, float]]]] = {}
        for column, drive in enumerate(self.mechanism.drives):
            law: DriveLaw = drive.law
            ratio = 1.0
            while isinstance(law, Geared):
                ratio *= law.ratio
                law = law.of
            trains.setdefault(id(law), (law, []))[1].append((column, ratio, drive.law_at_touch))
        return list(trains.values())
