"""Drive laws, and laws that are geared to another one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ...arrays import FloatArray

Evaluation = tuple[FloatArray, FloatArray, FloatArray]


class DriveLaw(Protocol):
    """Anything that gives a coordinate and its first two derivatives by the cylinder angle."""

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles of one turn at which a higher derivative jumps [rad]; mostly none."""
        ...

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law.

        Args:
            psi: Cylinder angles [rad], any shape, not reduced to one turn.

        Returns:
            Coordinate [rad or m], first [.../rad] and second derivative [.../rad^2] by psi, each of
            the shape of psi.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Geared:
    """A law multiplied by a gear ratio.

    Attributes:
        of: The law of the other shaft.
        ratio: Turns of this shaft per turn of the other, negative in opposite sense.
    """

    of: DriveLaw
    ratio: float

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles at which a higher derivative of the other shaft's law jumps [rad]."""
        return self.of.knots_rad

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        value, first, second = self.of.evaluate(psi)
        return self.ratio * value, self.ratio * first, self.ratio * second
