"""A shaft geared to another drive."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import FloatArray
from .law import DriveLaw, Evaluation, FollowingTable


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
        """Those of the law of the other shaft."""
        return self.of.knots_rad

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        value, first, second = self.of.evaluate(psi)
        return self.ratio * value, self.ratio * first, self.ratio * second


class GearedDrive(FollowingTable, frozen=True, kw_only=True, tag="geared"):
    """A shaft geared to another drive.

    Attributes:
        ratio: Turns of this shaft per turn of the other, negative in opposite sense [-].
    """

    ratio: float

    def build_on(self, other: DriveLaw) -> Geared:
        """Return the law; see :meth:`FollowingTable.build_on`."""
        return Geared(of=other, ratio=self.ratio)
