"""A shaft or a slide that moves in proportion to the cylinder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ..files.law_tables import ShaftTable
from ..laws import Evaluation


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
