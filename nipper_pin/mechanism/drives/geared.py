"""A shaft geared to another drive, in a model file."""

from __future__ import annotations

from ..files.description import Name
from ..files.law_tables import ShaftTable
from ..laws import DriveLaw, Geared


class GearedDrive(ShaftTable, frozen=True, kw_only=True, tag="geared"):
    """A shaft geared to another drive.

    Attributes:
        of: Name of the other drive.
        ratio: Turns of this shaft per turn of the other, negative in opposite sense [-].
    """

    of: Name
    ratio: float

    def build_on(self, other: DriveLaw) -> Geared:
        """Return the law on that of the other drive."""
        return Geared(of=other, ratio=self.ratio)
