"""A shaft geared to another drive, in a model file."""

from __future__ import annotations

from .law import DriveLaw, Geared
from .tables import FollowingTable


class GearedDrive(FollowingTable, frozen=True, kw_only=True, tag="geared"):
    """A shaft geared to another drive.

    Attributes:
        ratio: Turns of this shaft per turn of the other, negative in opposite sense [-].
    """

    ratio: float

    def build_on(self, other: DriveLaw) -> Geared:
        """Return the law; see :meth:`FollowingTable.build_on`."""
        return Geared(of=other, ratio=self.ratio)
