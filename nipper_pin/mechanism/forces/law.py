"""Force laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ...arrays import FloatArray


class ForceLaw(Protocol):
    """Anything that gives the force of an element by a coordinate x and its rate.

    Force, energy and heat belong together: at every state
    force * rate = d(energy)/dt + heat, with heat of at least zero.
    """

    @property
    def knots(self) -> tuple[float, ...]:
        """Coordinates at which a derivative of the force jumps [m or rad]; mostly none."""
        ...

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Force against the coordinate [N or N m].

        Args:
            x: Coordinates [m or rad], shape (N,).
            rate: Their rates [m/s or rad/s], shape (N,).

        Returns:
            Shape (N,).
        """
        ...

    def energy(self, x: FloatArray) -> FloatArray:
        """Energy stored [J], shape (N,); arguments as :meth:`force`."""
        ...

    def heat(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Power that becomes heat [W], shape (N,); arguments as :meth:`force`."""
        ...


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
