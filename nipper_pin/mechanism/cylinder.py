"""The input shaft: angle, sense of rotation and the comber's index scale."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..units import S_PER_MIN

INDEX_PER_TURN = 40.0


def rad_s_from_rpm(speed_rpm: float) -> float:
    """Convert a speed from r/min to rad/s."""
    return speed_rpm * math.tau / S_PER_MIN


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """The cylinder shaft.

    Attributes:
        angle_at_touch_rad: Angle psi in the touch configuration, counter-clockwise from x [rad].
        sense: +1 if psi grows with time, -1 if it falls.
        rated_speed_rpm: Rated speed, positive [r/min].
        reference_angle_rad: Angle psi at ``reference_index`` [rad].
        reference_index: Index there (nipper foremost: 24).
    """

    angle_at_touch_rad: float
    sense: int
    rated_speed_rpm: float
    reference_angle_rad: float
    reference_index: float

    def index_from_angle(self, psi: float) -> float:
        """Index in [0, 40) of the cylinder angle psi [rad]."""
        turns = self.sense * (psi - self.reference_angle_rad) / math.tau
        index = (self.reference_index + INDEX_PER_TURN * turns) % INDEX_PER_TURN
        # The remainder of next to nothing below zero is rounded to a whole turn.
        return 0.0 if index >= INDEX_PER_TURN else index

    def angle_from_index(self, index: float) -> float:
        """Cylinder angle psi [rad] of an index, on the turn that starts at the reference."""
        turns = (index - self.reference_index) / INDEX_PER_TURN
        return self.reference_angle_rad + self.sense * math.tau * turns
