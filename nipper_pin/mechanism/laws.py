"""Laws of drives, force elements and restitution, as the rooms that compute with them see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..arrays import FloatArray

Evaluation = tuple[FloatArray, FloatArray, FloatArray]


class DriveLaw(Protocol):
    """Anything that gives a coordinate and its first two derivatives by the cylinder angle."""

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles of one turn at which a higher derivative jumps [rad]; mostly none."""

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law.

        Args:
            psi: Cylinder angles [rad], any shape, not reduced to one turn.

        Returns:
            Coordinate [rad or m], first [.../rad] and second derivative [.../rad^2] by psi, each of
            the shape of psi.
        """


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


class ForceLaw(Protocol):
    """Anything that gives the force of an element by a coordinate x and its rate.

    Force, energy and heat belong together: at every state
    force * rate = d(energy)/dt + heat, with heat of at least zero.
    """

    @property
    def knots(self) -> tuple[float, ...]:
        """Coordinates at which a derivative of the force jumps [m or rad]; mostly none."""

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Force against the coordinate [N or N m].

        Args:
            x: Coordinates [m or rad], shape (N,).
            rate: Their rates [m/s or rad/s], shape (N,).

        Returns:
            Shape (N,).
        """

    def energy(self, x: FloatArray) -> FloatArray:
        """Energy stored [J], shape (N,); arguments as :meth:`force`."""

    def heat(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Power that becomes heat [W], shape (N,); arguments as :meth:`force`."""


@dataclass(frozen=True, kw_only=True)
class JointForce:
    """A force element on one coordinate.

    Attributes:
        name: Name of the element.
        kind: Name of its law in the model file.
        index: Place of the coordinate in q and v.
    """

    name: str
    kind: str
    index: int
    law: ForceLaw


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

    def slope(self, e_0: float, rate: float) -> float:
        """Return its derivative by the rate [s/m or s/rad]; arguments as :meth:`coefficient`."""
