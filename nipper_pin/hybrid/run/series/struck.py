"""A collision as it is passed to the rules of series, and their result."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple, Protocol, TypeVar

from ....arrays import FloatArray
from ....dynamics import Impact
from ....mechanism import Stop
from ...contact.bounce_series import BounceSeries
from ...contact.complementarity import Closed
from ...state import State

Series = tuple[BounceSeries, ...]


class Struck(NamedTuple):
    """A collision that has been computed.

    Attributes:
        number: Number of its event.
        before: State just before it, with the series of bounces until then.
        after: State just after it, with those series that it does not disturb.
        hit: Names of the stops that have just closed.
        rates: Rate of every stop in contact after it, by name [rad/s or m/s].
        rebounding: The stops that have just closed and open again.
    """

    number: int
    before: State
    after: State
    hit: set[str]
    rates: Mapping[str, float]
    rebounding: Sequence[Stop]


class Rest(NamedTuple):
    """The limit of a series of bounces.

    Attributes:
        t: Its time [s].
        error: Estimated error of that [s].
        stops: Names of the stops that come to rest.
        impact: What takes their last rates away.
        closed: Closed stops from then on.
    """

    t: float
    error: float
    stops: list[str]
    impact: Impact
    closed: Closed


class Limit(Protocol):
    """Where a series ends."""

    @property
    def t(self) -> float:
        """Its time [s]."""
        ...


_Ends = TypeVar("_Ends", bound=Limit)


def as_one(parts: Iterable[list[_Ends]], instant: float) -> list[list[_Ends]]:
    """Limits by parts, in order of time; parts that move alike come to rest as one.

    Args:
        parts: The limits.
        instant: Times nearer than this are one [s].
    """
    groups: list[list[_Ends]] = []
    for part in sorted(parts, key=_latest):
        if groups and _latest(part) - _latest(groups[-1]) <= instant:
            groups[-1].extend(part)
        else:
            groups.append(part)
    return groups


def _latest(limits: Sequence[Limit]) -> float:
    return max(limit.t for limit in limits)


class SeriesRule(Protocol):
    """One kind of series."""

    @property
    def name(self) -> str:
        """Its name."""
        ...

    def concerns(self, struck: Struck) -> bool:
        """Return whether a collision may belong to such a series."""
        ...

    def followed(self, struck: Struck, a: FloatArray) -> tuple[Series, Sequence[Rest]]:
        """Add a collision to its series.

        Args:
            a: Acceleration just after it, shape (nv,).

        Returns:
            All series of bounces after it; and the ends of those whose end is known, in order of
            time.
        """
        ...

    def forget(self, opened: Collection[str]) -> None:
        """End the series of stops that stay in contact, where one of these is pressed no more."""
        ...
