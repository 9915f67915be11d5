"""Steps of differences by a number of a model: absolute where it may be zero, inside its range."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray


class _Kind(NamedTuple):
    """A kind of number: what counts as one of it near zero, and what it may be."""

    ending: str
    amount: float
    unit: str
    low: float = -math.inf
    high: float = math.inf


# The first ending that fits; what is below its amount is asked for by that amount, not by percent.
_KINDS = (
    _Kind("restitution", 0.01, "0.01", 0.0, 1.0),
    _Kind("_N_per_m", 10.0, "10 N/m", 0.0),
    _Kind("_N_m_per_rad", 0.01, "0.01 N m/rad", 0.0),
    _Kind("_N_s_per_m", 0.1, "0.1 N s/m", 0.0),
    _Kind("_N_m_s_per_rad", 1e-3, "0.001 N m s/rad", 0.0),
    _Kind("_N_m", 0.01, "0.01 N m"),
    _Kind("_N", 1.0, "1 N"),
    _Kind("_kg_m2", 1e-7, "1e-7 kg m2", 0.0),
    _Kind("_kg", 1e-4, "0.1 g", 0.0),
    _Kind("_rpm", 1.0, "1 r/min", 0.0),
    _Kind("", 0.01, "0.01"),
)
# Half widths of the differences: of a length [mm], of an angle [deg]; of all others by their value,
# and no less than by their amount.
_LENGTH_OR_ANGLE = {"_mm": 0.05, "_deg": 0.05}
_BY_VALUE, _BY_AMOUNT = 2e-3, 0.02
_NOT_NEGATIVE = ("radius_mm", "gyration_mm")


@dataclass(frozen=True)
class Step:
    """How one number is varied.

    Attributes:
        unit: What "one unit more" is: "mm", "deg", "%" of the value, or near zero an amount.
        amount: The same, in the unit of the number's name.
        half_width: Half width of differences.
        sense: 0: both ways; 1 or -1: upwards or downwards alone, since the other way leaves the
            range of such numbers.
    """

    unit: str
    amount: float
    half_width: float
    sense: int

    def slope(self, function: Callable[[float], FloatArray], value: float) -> FloatArray:
        """First derivative of a function of the number.

        Args:
            function: From a value to some quantities, shape (n,).
            value: Where.

        Returns:
            Shape (n,). Differences of second order in the half width, whose error goes with its
            square.
        """
        return _difference(function, value, self.half_width, self.sense)

    def extrapolated(self, function: Callable[[float], FloatArray], value: float) -> FloatArray:
        """The same with Richardson's extrapolation from twice the half width."""
        narrow = _difference(function, value, self.half_width, self.sense)
        wide = _difference(function, value, 2.0 * self.half_width, self.sense)
        return np.asarray((4.0 * narrow - wide) / 3.0)


def step_of(path: str, value: float) -> Step:
    """Choose how a number is varied.

    Args:
        path: Its path; the ending of its name tells its kind.
    """
    for ending, width in _LENGTH_OR_ANGLE.items():
        if path.endswith(ending):
            low = 0.0 if path.endswith(_NOT_NEGATIVE) else -math.inf
            return Step(ending[1:], 1.0, width, _sense(value, width, low, math.inf))
    kind = next(kind for kind in _KINDS if path.endswith(kind.ending))
    width = max(_BY_VALUE * abs(value), _BY_AMOUNT * kind.amount)
    sense = _sense(value, width, kind.low, kind.high)
    if abs(value) < kind.amount:
        return Step(kind.unit, kind.amount, width, sense)
    return Step("%", 0.01 * value, width, sense)


def _sense(value: float, width: float, low: float, high: float) -> int:
    if value - 2.0 * width <= low:
        return 1
    return -1 if value + 2.0 * width > high else 0


def _difference(
    function: Callable[[float], FloatArray], value: float, width: float, sense: int
) -> FloatArray:
    if sense == 0:
        return np.asarray((function(value + width) - function(value - width)) / (2.0 * width))
    first, second = (function(value + k * sense * width) for k in (1.0, 2.0))
    slope = (4.0 * first - second - 3.0 * function(value)) / (2.0 * width)
    return np.asarray(sense * slope)
