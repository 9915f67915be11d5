"""Axes that stand still while a slider moves: they grow in round steps, and shrink when asked."""

from __future__ import annotations

import math
from collections.abc import Iterable

_STEPS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
# Room above the largest value when an axis has to grow.
_ROOM = 1.02


def round_above(value: float) -> float:
    """The least round number that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    # Nine digits, so that a round number is not below itself by round-off.
    least = float(f"{value / power:.9g}")
    return float(f"{power * next(step for step in _STEPS if step >= least):.12g}")


class SteadyAxis:
    """Upper end of an axis that begins at zero.

    Attributes:
        top: The end; 1 before anything is shown.
    """

    def __init__(self) -> None:
        """Begin without a length."""
        self.top = 1.0
        self._fresh = True

    def hold(self, needed: float) -> None:
        """Grow, if something would not fit.

        Args:
            needed: Largest value of all that is shown.
        """
        if needed > 0.0 and (self._fresh or needed > self.top):
            self.top, self._fresh = round_above(_ROOM * needed), False

    def forget(self) -> None:
        """Fit what is held next, also if it is smaller."""
        self._fresh = True


class SteadyDecades:
    """Ends of a logarithmic axis, which are powers of ten.

    Attributes:
        ends: Lower and upper end.
    """

    def __init__(self) -> None:
        """Begin with one decade."""
        self.ends = (0.1, 1.0)
        self._fresh = True

    def hold(self, values: Iterable[float]) -> None:
        """Grow, if one of these positive values would not fit."""
        logs = [math.log10(value) for value in values]
        if not logs:
            return
        low, high = math.floor(min(logs)), math.ceil(max(logs))
        if self._fresh:
            self.ends, self._fresh = (10.0**low, 10.0 ** max(high, low + 1)), False
        self.ends = (min(self.ends[0], 10.0**low), max(self.ends[1], 10.0**high))

    def forget(self) -> None:
        """Fit what is held next, also if it is less."""
        self._fresh = True
