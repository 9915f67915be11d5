"""Bounces of several stops that have become lower than the round-off of their coordinates.

Stops of one part that strike in turns end one another's series. Where their places are not zero,
gaps lose their digits: below the round-off of the places what they do next is chance, and they may
do so for ever.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ....arrays import FloatArray
from ....dynamics import System
from ....mechanism import Stop
from ....tolerances.hybrid import VANISHED_REBOUND
from ...case import Case
from ...contact.complementarity import Closed
from ...state import State
from .shut import shut_together
from .struck import Rest, Series, Struck


class VanishingBounces:
    """Collisions after which no stop of a part opens further than by round-off."""

    name = "bounces lower than round-off"

    def __init__(self, system: System, case: Case) -> None:
        """Places of stops tell the round-off of all coordinates of their part."""
        self._system, self._case = system, case
        units = system.body.unit_of
        self._least: dict[str, float] = {}
        for group in system.apart(system.mechanism.stops):
            farthest = max(abs(stop.at) / units[stop.index] for stop in group)
            for stop in group:
                self._least[stop.name] = VANISHED_REBOUND * farthest * units[stop.index]

    def concerns(self, struck: Struck) -> bool:
        """Return whether a stop rebounds."""
        return bool(struck.rebounding) and self._case.rest_rate is None

    def followed(self, struck: Struck, a: FloatArray) -> tuple[Series, Sequence[Rest]]:
        """End the bounces of a part; see :meth:`.SeriesRule.followed`."""
        state, rests = struck.after, list[Rest]()
        for group in self._system.apart(struck.rebounding):
            rest = self._rest(state, a, self._system.coupled([group[0].name]))
            if rest is not None:
                rests.append(rest)
                state = state._replace(v=rest.impact.v_after, closed=rest.closed)
        return struck.after.series, sorted(rests, key=lambda rest: rest.t)

    def _rest(self, state: State, a: FloatArray, part: Closed) -> Rest | None:
        """The rest of all open stops of a part; None if one of them is still on its way."""
        system = self._system
        stops = [
            stop
            for stop in system.mechanism.stops
            if stop.name in part and stop.name not in state.closed
        ]
        if any(stop.restitution >= 1.0 for stop in stops):
            # One that loses nothing rests by what the others lose, if at all.
            return None
        lasts = max(_lasts(stop, state, a) for stop in stops)
        if any(_rise(stop, state, a, lasts) > self._least[stop.name] for stop in stops):
            return None
        names = frozenset(stop.name for stop in stops) | (state.closed & part)
        return shut_together(system, state, names, state.t + lasts, lasts)

    def forget(self, opened: Collection[str]) -> None:
        """Nothing is kept here."""


def _lasts(stop: Stop, state: State, a: FloatArray) -> float:
    """How long a stop bounces that is pressed shut by itself [s]; of others the part decides."""
    deceleration = -stop.rate(a)
    if deceleration <= 0.0:
        return 0.0
    return 2.0 * abs(stop.rate(state.v)) / (deceleration * (1.0 - stop.restitution))


def _rise(stop: Stop, state: State, a: FloatArray, lasts: float) -> float:
    """Gap that a stop opens to [rad or m], at most for the time that the others bounce."""
    gap, rate, deceleration = stop.gap(state.q), max(stop.rate(state.v), 0.0), -stop.rate(a)
    return gap + rate * min(lasts, 0.5 * rate / deceleration if deceleration > 0.0 else lasts)
