"""Motion of the input shaft and of the joints it drives, as functions of time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, Times
from ..mechanism import DriveLaw, Mechanism
from ..tolerances.hybrid import KNOT_ROUND_OFF
from ..tolerances.mechanics import KNOT_ANGLE

Driven = tuple[FloatArray, FloatArray, FloatArray]
"""Coordinates, rates and accelerations of the driven joints at N times, each (N, drives)."""
# Angles of a turn at which the size of a drive is looked at, beside its knots.
_AROUND = 33


@dataclass(frozen=True)
class ShaftMotion:
    """Constant cylinder speed and the driven coordinates that follow from it.

    Attributes:
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

    def driven(self, t: Times, piece: float | None = None) -> Driven:
        """Driven coordinates, rates and accelerations.

        Args:
            piece: A time [s] on the piece of the laws, from knot to knot, that all times belong to:
                one that lies beyond its ends, by no more than round-off, does not see the next.

        Returns:
            Three arrays of shape (N, drives): [rad], [rad/s], [rad/s^2].
        """
        psi = self.start_angle_rad + self.rate * t
        if piece is None or not self.mechanism.drive_knots_rad.size:
            return self.driven_along(psi)
        return self._on_piece(psi, self.start_angle_rad + self.rate * piece)

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

    def driven_at(self, t: float, piece: float | None = None) -> Driven:
        """Return :meth:`driven` at one time [s], as one row; numbers are faster than arrays."""
        if piece is not None and self.mechanism.drive_knots_rad.size:
            return self.driven(np.array([t]), piece)
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
    def sizes(self) -> FloatArray:
        """Largest coordinates, rates and accelerations of drives in a turn, shape (3, drives).

        Coordinates are differences from their values at touch, and have the size of both.
        """
        around = np.linspace(0.0, 2.0 * np.pi, _AROUND)
        psi = np.sort(np.concatenate([around, self.mechanism.drive_knots_rad]))
        between = 0.5 * (psi[1:] + psi[:-1])
        values = np.array(self.driven_along(np.concatenate([psi, between])))
        largest = np.abs(values).max(axis=1, initial=0.0)
        return np.asarray(largest + np.abs(self.mechanism.drive_offsets[:, 0]))

    def _on_piece(self, psi: FloatArray, inside: float) -> Driven:
        """Driven coordinates at angles psi by the piece around an angle, continued beyond it.

        A law finds its pieces by angles that it reduces to one turn, each with its round-off, so
        close to a knot it is not asked.
        """
        knots, turn = self.mechanism.drive_knots_rad, 2.0 * np.pi
        margin = KNOT_ROUND_OFF * (abs(inside) + turn)
        low = inside - max(float(np.remainder(inside - knots, turn).min()) - margin, 0.0)
        high = inside + max(float(np.remainder(knots - inside, turn).min()) - margin, 0.0)
        asked = np.clip(psi, low, high)
        q, v, a = self.driven_along(asked)
        beyond = ((psi - asked) / self.rate)[:, None]
        if not beyond.any():
            return q, v, a
        return q + beyond * (v + 0.5 * beyond * a), v + beyond * a, a

    @cached_property
    def _trains(self) -> list[tuple[DriveLaw, FloatArray]]:
        """Independent laws and their factors of the motion, shape (3, 1, drives)."""
        by_rate = self.rate ** np.arange(3.0)[:, None, None]
        return [(law, ratios * by_rate) for law, ratios in self.mechanism.drive_trains]
