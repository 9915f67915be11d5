"""Restitution that falls from its value at a vanishing rate to a lower one at fast impacts."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..files.description import Positive, Restitution
from ..files.law_tables import RestitutionTable


@dataclass(frozen=True, kw_only=True)
class Falling:
    """e = e_fast + (e_0 - e_fast) exp(-rate / scale).

    Attributes:
        fast: e_fast, 0 to 1.
        scale: Rate by which the difference has fallen to 1/e of itself [m/s or rad/s].
    """

    fast: float
    scale: float

    def coefficient(self, e_0: float, rate: float) -> float:
        """Return the coefficient; see :meth:`RestitutionLaw.coefficient`."""
        return self.fast + (e_0 - self.fast) * math.exp(-rate / self.scale)

    def slope(self, e_0: float, rate: float) -> float:
        """Return its derivative; see :meth:`RestitutionLaw.slope`."""
        return (self.fast - e_0) / self.scale * math.exp(-rate / self.scale)


class FallingRestitution(RestitutionTable, frozen=True, kw_only=True, tag="falling"):
    """Restitution that falls, or rises, exponentially with the rate of approach.

    Attributes:
        fast: Restitution of the fastest impacts, 0 to 1.
        scale: Rate at which 1/e of the difference is left [m/s; rad/s on a hinge].
    """

    fast: Restitution
    scale: Positive

    def build(self, kind: str) -> Falling:
        """Return the law; see :meth:`RestitutionTable.build`."""
        del kind
        return Falling(fast=self.fast, scale=self.scale)
