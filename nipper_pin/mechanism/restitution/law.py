"""Restitution laws."""

from __future__ import annotations

from typing import Protocol


class RestitutionLaw(Protocol):
    """A coefficient of restitution that depends on the rate of approach.

    It is a smooth function from the rate zero on: bounces that fade out go on for ever, and their
    limit is found from its value there, which is the stop's ``restitution``.
    """

    def coefficient(self, e_0: float, rate: float) -> float:
        """Return the coefficient of restitution, 0 to 1.

        Args:
            e_0: That of a vanishing rate.
            rate: Rate of approach, at least zero [m/s or rad/s].
        """
        ...

    def slope(self, e_0: float, rate: float) -> float:
        """Return its derivative by the rate [s/m or s/rad]; arguments as :meth:`coefficient`."""
        ...
