"""Motion of the input shaft and of the joints it drives, as functions of time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray
from ..mechanism import DriveLaw, Mechanism
from ..tolerances.mechanics import KNOT_ANGLE

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

    @cached_property
    def rate(self) -> float:
        """Rate of the cylinder angle, with its sign [rad/s]."""
        return self.mechanism.cylinder.sense * self.speed_rad_s

    @cached_property
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
        return self.driven_along(self.start_angle_rad + self.rate * t)

    def driven_along(self, psi: FloatArray) -> Driven:
        """Return :meth:`driven` at cylinder angles psi, shape (N,) [rad].

        Coordinates are the same to the last bit at any speed.
        """
        if not self._trains:
            none = np.zeros((len(psi), 0))
            return none, none, none
        values = self.mechanism.drive_offsets
        for law, factors in self._trains:
            # A product with one term a sum is faster than one of arrays of different shapes.
            values = values + np.matmul(np.array(law.evaluate(psi))[:, :, None], factors)
        return values[0], values[1], values[2]

    def driven_at(self, t: float) -> Driven:
        """Return :meth:`driven` at one time [s], as one row; numbers are faster than arrays."""
        psi = np.asarray(self.start_angle_rad + self.rate * t)
        values = self.mechanism.drive_offsets
        for law, factors in self._trains:
            values = values + np.array(law.evaluate(psi))[:, None, None] * factors
        return values[0], values[1], values[2]

    def smooth_for(self, t: float) -> float:
        """Time [s] from t to the next one at which a law changes its polynomial; often infinite."""
        knots = self.mechanism.drive_knots_rad
        if not knots.size:
            return np.inf
        sense = 1.0 if self.rate > 0.0 else -1.0
        ahead = np.remainder(sense * (knots - float(self.angle(t))), 2.0 * np.pi)
        # The computed time of a knot may be before it by round-off.
        ahead[ahead <= KNOT_ANGLE] += 2.0 * np.pi
        return float(ahead.min()) / self.speed_rad_s

    @cached_property
    def _trains(self) -> list[tuple[DriveLaw, FloatArray]]:
        """Independent laws and their factors of the motion, shape (3, 1, drives)."""
        by_rate = self.rate ** np.arange(3.0)[:, None, None]
        return [(law, ratios * by_rate) for law, ratios in self.mechanism.drive_trains]
