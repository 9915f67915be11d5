"""A hydraulic damper whose oil passes an orifice: force proportional to the square of the rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ..files.description import Damping
from ..files.law_tables import SLIDE, ForceTable


@dataclass(frozen=True, kw_only=True)
class Orifice:
    """A turbulent orifice: force c x_dot |x_dot|, heat c |x_dot|^3.

    Attributes:
        c: [N s2/m2].
    """

    c: float
    knots: ClassVar[tuple[float, ...]] = ()

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Force against the coordinate; see :meth:`ForceLaw.force`."""
        del x
        return self.c * rate * np.abs(rate)

    def energy(self, x: FloatArray) -> FloatArray:
        """A damper stores nothing; see :meth:`ForceLaw.energy`."""
        return np.zeros_like(x)

    def heat(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """All work becomes heat; see :meth:`ForceLaw.heat`."""
        del x
        return self.c * np.abs(rate) ** 3


class OrificeForce(ForceTable, frozen=True, kw_only=True, tag="orifice"):
    """A hydraulic damper on a slide, whose force grows with the square of the rate.

    Attributes:
        c_N_s2_per_m2: Force at a rate of 1 m/s [N s2/m2].
    """

    c_N_s2_per_m2: Damping

    acts_on: ClassVar[tuple[str, ...]] = (SLIDE,)

    def build(self, kind: str) -> Orifice:
        """Return the law; see :meth:`ForceTable.build`."""
        del kind
        return Orifice(c=self.c_N_s2_per_m2)
