"""How people read a number: its words, its unit and its digits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeVar

from ..arrays import FloatArray
from ..units import (
    DEG_PER_RAD,
    M_PER_MM,
    MDEG_PER_DEG,
    MJ_PER_J,
    MM_PER_M,
    MS_PER_S,
    UM_PER_M,
)

Number = TypeVar("Number", float, FloatArray)

# Unit that people read and its number in one unit of files; units left out stay as they are.
_UNITS = {
    "s": ("ms", MS_PER_S),
    "J": ("mJ", MJ_PER_J),
    "m": ("mm", MM_PER_M),
    "m/s": ("mm/s", MM_PER_M),
    "rad": ("deg", DEG_PER_RAD),
    "N/m": ("N/mm", M_PER_MM),
}
# The same of rebounds, which are a hundredth of the coordinate's range or less.
_SMALL = {
    "rad": ("mdeg", MDEG_PER_DEG * DEG_PER_RAD),
    "m": ("um", UM_PER_M),
}


@dataclass(frozen=True, kw_only=True)
class Shown:
    """How people read one quantity.

    Attributes:
        words: What it is.
        unit: Unit that people read; empty for a number without one.
        factor: Number of these units in one unit of files.
        decimals: Decimals; None for four significant digits.
    """

    words: str
    unit: str = ""
    factor: float = 1.0
    decimals: int | None = None

    @property
    def label(self) -> str:
        """Words and unit, for axes and headings."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    def of(self, owner: str) -> Shown:
        """The same with its stop, drive or collision behind the words."""
        return self.called(f"{self.words} {owner}")

    def called(self, words: str) -> Shown:
        """The same with other words."""
        return replace(self, words=words)

    def value(self, number: Number) -> Number:
        """A value, or an array of any shape, in the unit that people read."""
        return self.factor * number

    def text(self, number: float | None) -> str:
        """The digits of a value; a dash for a missing one."""
        if number is None or math.isnan(number):
            return "-"
        value = self.factor * number
        return digits(value) if self.decimals is None else fixed(value, self.decimals)

    def phrase(self, number: float | None) -> str:
        """Digits and unit of a value."""
        return f"{self.text(number)} {self.unit}".rstrip()


def shown_in(unit: str, *, small: bool = False, share: bool = False) -> tuple[str, float]:
    """The unit in which people read numbers of a unit of files, and its number in one of those.

    Args:
        unit: Unit of files; empty for a number without one.
        small: Whether it is one of rebounds, which are small.
        share: Whether it is a share, read in per cent.
    """
    if share:
        return "%", 100.0
    return (
        _SMALL.get(unit, _UNITS.get(unit, (unit, 1.0))) if small else _UNITS.get(unit, (unit, 1.0))
    )


def digits(value: float | None) -> str:
    """Four significant digits, without losing any to a column; a dash for a missing value."""
    if value is None:
        return "-"
    if value == 0.0:
        return "0"
    if 1e-3 <= abs(value) < 1e6:
        return f"{value:.{max(0, 3 - math.floor(math.log10(abs(value))))}f}"
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def counted(number: int, noun: str) -> str:
    """A number of things whose plural ends in s: 1 start, 12,000 starts."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def fixed(value: float, decimals: int) -> str:
    """Fixed decimals; round-off below zero does not show as minus zero."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
