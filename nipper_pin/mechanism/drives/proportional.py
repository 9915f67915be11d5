"""Shafts and slides that move in proportion to the cylinder."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ...units import M_PER_MM
from ..files.toml_types import Positive
from .law import Evaluation
from .tables import SLIDE, DriveTable, ShaftTable


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed:
    """A shaft or a slide that moves in proportion to the cylinder.

    Attributes:
        ratio: Turns of the shaft per turn of the cylinder [-], or travel of the slide [m/rad].
    """

    ratio: float
    knots_rad: ClassVar[tuple[float, ...]] = ()

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        psi = np.asarray(psi, dtype=np.float64)
        return self.ratio * psi, np.full_like(psi, self.ratio), np.zeros_like(psi)


class ConstantSpeedDrive(ShaftTable, frozen=True, kw_only=True, tag="constant_speed"):
    """A shaft that turns in proportion to the cylinder.

    Attributes:
        ratio: Turns of this shaft per turn of the cylinder [-].
    """

    ratio: float

    def build(self) -> ConstantSpeed:
        """Return the law; see :meth:`DriveTable.build`."""
        return ConstantSpeed(ratio=self.ratio)


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
