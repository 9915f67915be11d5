"""Collisions that do not end: drives press a link against two stops at once.

The link flies from one stop to the other in ever shorter times, whose sum is finite, and is no
slower in the end: no motion goes on from there.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ImpactError

# As many collisions in one instant, no stop struck slower in the end but for this share, are a jam.
_JAM, _NO_SLOWER = 20, 1e-3
# Rates below this share of the fastest one are the end of a series of bounces, where round-off
# keeps times and rates from falling.
_OVER = 1e-9


@dataclass(frozen=True)
class LatestCollisions:
    """The last collisions of a run.

    Attributes:
        times: Their times [s].
        stops: Names of the stops struck.
        rates: Largest approach rate of each, positive [rad/s or m/s].
        fastest: Largest of all, those before as well [rad/s or m/s].
    """

    times: tuple[float, ...] = ()
    stops: tuple[frozenset[str], ...] = ()
    rates: tuple[float, ...] = ()
    fastest: float = 0.0

    def struck(self, t: float, stops: frozenset[str], rate: float) -> LatestCollisions:
        """Return the collisions with one more."""
        return LatestCollisions(
            (*self.times, t)[-_JAM:],
            (*self.stops, stops)[-_JAM:],
            (*self.rates, rate)[-_JAM:],
            max(self.fastest, rate),
        )

    def check(self, instant: float) -> None:
        """Refuse to go on from a jam.

        Args:
            instant: Times nearer than this are one [s].

        Raises:
            ImpactError: The last collisions are one.
        """
        if len(self.times) < _JAM or self.times[-1] - self.times[0] > instant:
            return
        stops = sorted(frozenset().union(*self.stops))
        if len(stops) > 1 and all(self._no_slower(stop) for stop in stops):
            message = (
                f"the stops {', '.join(stops)} are struck {_JAM} times within {instant:.1g} s and "
                "nothing gets slower: they jam what moves between them against its drives; give it "
                "room, or let the drives be inertial"
            )
            raise ImpactError(message, stops=stops, rates_before=list(self.rates))

    def _no_slower(self, stop: str) -> bool:
        """True if a stop was struck again and again, at a rate that does not fall."""
        rates = [rate for rate, stops in zip(self.rates, self.stops, strict=True) if stop in stops]
        least = max((1.0 - _NO_SLOWER) * rates[0], _OVER * self.fastest)
        return len(rates) > 1 and rates[-1] >= least
