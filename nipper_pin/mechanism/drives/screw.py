"""A slide that a screw moves, in a model file."""

from __future__ import annotations

import math
from typing import ClassVar

from ...units import M_PER_MM
from ..files.description import Positive
from ..files.law_tables import SLIDE, DriveTable
from .constant_speed import ConstantSpeed


class ScrewDrive(DriveTable, frozen=True, kw_only=True, tag="screw"):
    """A slide that a screw moves in proportion to the cylinder.

    Attributes:
        lead_mm_per_turn: Travel per turn of the cylinder [mm].
        reflected_mass_kg: Inertia of the drive train seen at the slide [kg].
    """

    lead_mm_per_turn: float
    reflected_mass_kg: Positive | None = None

    moves: ClassVar[tuple[str, ...]] = (SLIDE,)

    def build(self) -> ConstantSpeed:
        """Return the law; see :meth:`DriveTable.build`."""
        return ConstantSpeed(ratio=M_PER_MM * self.lead_mm_per_turn / math.tau)
