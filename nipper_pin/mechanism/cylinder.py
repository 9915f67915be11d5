"""The input shaft: angle, sense of rotation and the comber's index scale."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..units import S_PER_MIN

INDEX_PER_TURN = 40.0


def within_turn(index: float | FloatArray) -> FloatArray:
    """Indices in [0, 40), the one scale that is shown, of indices on any turn; NaN stays NaN.

    Args:
        index: Indices, of any shape.
    """
    found = np.mod(index, INDEX_PER_TURN)
    # The remainder of next to nothing below zero is rounded to a whole turn.
    return np.where(found >= INDEX_PER_TURN, 0.0, found)


def counted_from(start: float, index: FloatArray) -> FloatArray:
    """The same places as indices that count on from a start to 40 more, as means need them.

    Args:
        index: Indices, of any shape.
    """
    return start + within_turn(index - start)


def index_difference(index: float, other: float) -> float:
    """From another index to this one, the short way around the turn: from -20 to 20."""
    return math.remainder(index - other, INDEX_PER_TURN)


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
        return float(self.indices_from_angles(psi))

    def indices_from_angles(self, psi: float | FloatArray) -> FloatArray:
        """Indices in [0, 40) of cylinder angles psi [rad], of any shape."""
        turns = self.sense * (psi - self.reference_angle_rad) / math.tau
        return within_turn(self.reference_index + INDEX_PER_TURN * turns)

    def angle_from_index(self, index: float) -> float:
        """Cylinder angle psi [rad] of an index, on the turn that starts at the reference."""
        turns = (index - self.reference_index) / INDEX_PER_TURN
        return self.reference_angle_rad + self.sense * math.tau * turns
