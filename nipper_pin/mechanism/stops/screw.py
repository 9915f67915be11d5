"""A stop that a screw adjusts."""

from __future__ import annotations

from ...errors import InputError
from ...units import M_PER_MM
from ..files.law_tables import StopTable


class ScrewStop(StopTable, frozen=True, kw_only=True, tag="screw"):
    """A stop of a slide on a screw, at zero_mm + pitch_mm * turns.

    Attributes:
        pitch_mm: Travel of the stop per turn of the screw [mm].
        turns: Turns of the screw [-].
        zero_mm: Coordinate of the slide at which the stop is closed before the first turn [mm].
    """

    pitch_mm: float
    turns: float
    zero_mm: float = 0.0

    def place(self, kind: str) -> float:
        """Return the coordinate [m]; see :meth:`StopTable.place`."""
        if kind != "prismatic":
            message = "a slide (prismatic joint): a screw adjusts no stop of a hinge"
            raise InputError(message, key="pitch_mm")
        return M_PER_MM * (self.zero_mm + self.pitch_mm * self.turns)
