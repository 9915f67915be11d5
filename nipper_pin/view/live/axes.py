"""Axes that stand still while a slider moves: they grow in round steps, and shrink when asked."""

from __future__ import annotations

import math

STEPS, DECADES = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0), (1.0, 10.0)
"""Round numbers of a decade, for linear and for logarithmic axes."""


def round_above(value: float, steps: tuple[float, ...] = STEPS) -> float:
    """The least round number that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    # Nine digits, so that a round number is not below itself by round-off.
    least = float(f"{value / power:.9g}")
    return float(f"{power * next(step for step in steps if step >= least):.12g}")


class SteadyAxis:
    """End of an axis.

    Args:
        steps: Round numbers that it may have.
        room: Room above the largest value when it has to grow.

    Attributes:
        top: The end; 1 before anything is shown.
    """

    def __init__(self, steps: tuple[float, ...] = STEPS, room: float = 1.02) -> None:
        """Begin without a length."""
        self.top = 1.0
        self._steps, self._room, self._fresh = steps, room, True

    def hold(self, needed: float) -> None:
        """Grow, if something would not fit.

        Args:
            needed: Largest value of all that is shown.
        """
        if needed > 0.0 and (self._fresh or needed > self.top):
            self.top, self._fresh = round_above(self._room * needed, self._steps), False

    def forget(self) -> None:
        """Fit what is held next, also if it is smaller."""
        self._fresh = True
