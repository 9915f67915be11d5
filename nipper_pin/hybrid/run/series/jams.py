"""Collisions that do not end: drives press a link against two stops at once.

The link flies from one stop to the other in ever shorter times, whose sum is finite, and is no
slower in the end: no motion goes on from there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from ....arrays import FloatArray
from ....dynamics import System
from ....errors import ImpactError
from ....mechanism import Mechanism
from ....tolerances.hybrid import JAM_SLOWING, SIMULTANEOUS, SLOWEST_JAM_RATE
from ...event import Event, EventKind
from .struck import Rest, Series, Struck

# As many collisions in one instant are a jam if no stop is struck slower in the end.
_JAM = 20


class Jams:
    """Collisions in one instant that do not become slower.

    Args:
        system: The system.
        events: The events of the run, as they are written down.
    """

    name = "jams between two stops"

    def __init__(self, system: System, events: Sequence[Event]) -> None:
        """Times nearer than an instant are one."""
        self._mechanism, self._events = system.mechanism, events
        self._instant = SIMULTANEOUS * system.shaft.period

    def concerns(self, struck: Struck) -> bool:
        """Return whether there are as many events within one instant."""
        first = struck.number - _JAM
        events = self._events
        return first >= 0 and events[struck.number - 1].t - events[first].t <= self._instant

    def followed(self, struck: Struck, a: FloatArray) -> tuple[Series, Sequence[Rest]]:
        """Refuse to go on from a jam.

        Raises:
            ImpactError: The last collisions are one.
        """
        del a
        check_jam(self._mechanism, self._events[: struck.number], self._instant)
        return struck.after.series, ()

    def forget(self, opened: Collection[str]) -> None:
        """Nothing is kept here."""


def check_jam(mechanism: Mechanism, events: Sequence[Event], instant: float) -> None:
    """Refuse to go on from a jam.

    Args:
        events: All events so far.
        instant: Times nearer than this are one [s].

    Raises:
        ImpactError: The last collisions are one.
    """
    latest = [event for event in events[-2 * _JAM :] if event.kind is EventKind.COLLISION][-_JAM:]
    if len(latest) < _JAM or latest[-1].t - latest[0].t > instant:
        return
    stops = sorted({name for event in latest for name in event.stops})
    series = {name: _approaches(mechanism, name, latest) for name in stops}
    struck = {name: rates for name, rates in series.items() if rates}
    fastest = (max(_approaches(mechanism, name, events)) for name in struck)
    # Contacts without approach strike nothing.
    least = SLOWEST_JAM_RATE * max(fastest, default=0.0)
    if len(struck) > 1 and all(
        len(rates) > 1 and rates[-1] >= max((1.0 - JAM_SLOWING) * rates[0], least)
        for rates in struck.values()
    ):
        message = (
            f"the stops {', '.join(struck)} are struck {_JAM} times within {instant:.1g} s and "
            "nothing gets slower: they jam what moves between them against its drives; give it "
            "room, or let the drives be inertial"
        )
        raise ImpactError(message, stops=list(struck), rates_before=series)


def _approaches(mechanism: Mechanism, name: str, events: Iterable[Event]) -> list[float]:
    """Rates at which a stop was struck, positive [rad/s or m/s]."""
    stop = mechanism.stop(name)
    rates = (-stop.rate(event.v_before) for event in events if name in event.stops)
    return [rate for rate in rates if rate > 0.0]
