"""Rules of what follows a collision, by what a machine has.

Bounces end at rest after a finite time: every machine with a stop has this rule. Two stops may also
throw one another open, jam a link between them, or bounce until nothing but round-off is left: only
a machine with two stops or more has these rules.

Jams: drives press a link against two stops at once. The link flies from one stop to the other in
ever shorter times, whose sum is finite, and is no slower in the end: no motion goes on from there.

Stops at rest that throw one another open make series of bounces that hold series themselves.

Stops of one part that strike in turns end one another's series. Where their places are not zero,
gaps lose their digits: below the round-off of the places what they do next is chance, and they may
do so for ever.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from math import inf, isfinite

from ....arrays import FloatArray
from ....dynamics import System
from ....errors import ImpactError
from ....mechanism import Mechanism, Stop
from ....tolerances.hybrid import (
    DROPPED_SERIES,
    JAM_SLOWING,
    NESTED_AT_LAST,
    SIMULTANEOUS,
    SLOWEST_JAM_RATE,
    VANISHED_REBOUND,
)
from ...case import Case
from ...contact.bounce_series import NestedSeries
from ...history import Closed, Event, EventKind, State
from .bounces import (
    UNKNOWN,
    Followed,
    ImpactOutcome,
    Limit,
    Rule,
    bounces,
    knot_between,
    other_stop_meets,
    rests_of,
)

# As many collisions in one instant are a jam if no stop is struck slower in the end.
_JAM = 20


def need_no_jam(system: System, log: Sequence[Event], number: int) -> None:
    """Refuse to go on from a jam: collisions in one instant that do not become slower.

    Raises:
        ImpactError: The last collisions, up to this number, are one.
    """
    # Times nearer than an instant are one.
    first, instant = number - _JAM, SIMULTANEOUS * system.shaft.period
    if first < 0 or log[number - 1].t - log[first].t > instant:
        return
    events, mechanism = log[:number], system.mechanism
    hits = [event for event in events[-2 * _JAM :] if event.kind is EventKind.COLLISION][-_JAM:]
    if len(hits) < _JAM or hits[-1].t - hits[0].t > instant:
        return
    stops = sorted({name for event in hits for name in event.stops})
    series = {name: _approaches(mechanism, name, hits) for name in stops}
    jammed = {name: rates for name, rates in series.items() if rates}
    fastest = (max(_approaches(mechanism, name, events)) for name in jammed)
    # Contacts without approach strike nothing.
    least = SLOWEST_JAM_RATE * max(fastest, default=0.0)
    if len(jammed) > 1 and all(
        len(rates) > 1 and rates[-1] >= max((1.0 - JAM_SLOWING) * rates[0], least)
        for rates in jammed.values()
    ):
        message = (
            f"the stops {', '.join(jammed)} are struck {_JAM} times within {instant:.1g} s and "
            "nothing gets slower: they jam what moves between them against its drives; give it "
            "room, or let the drives be inertial"
        )
        raise ImpactError(message, stops=list(jammed), rates_before=series)


def _approaches(mechanism: Mechanism, name: str, events: Iterable[Event]) -> list[float]:
    """Rates at which a stop was struck, positive [rad/s or m/s]."""
    stop = mechanism.stop(name)
    rates = (-stop.rate(event.v_before) for event in events if name in event.stops)
    return [rate for rate in rates if rate > 0.0]


# Events of a series, with those of the series inside, from which on what is left out need not be
# small, nor the limit be known as well as that of fewer.
_MANY_EVENTS = 1000


class NestedBounces:
    """Collisions, one in a part, that throw others open, which were at rest."""

    def __init__(self, system: System) -> None:
        """Begin without any series."""
        self._system = system
        self._known: dict[tuple[str, Closed], NestedSeries] = {}

    def followed(self, struck: ImpactOutcome) -> Followed:
        """Add such collisions, one a part."""
        state = struck.after
        if not any(struck.rates.get(name, 0.0) > 0.0 for name in struck.before.closed):
            return state.series, ()
        hit = [self._system.mechanism.stop(name) for name in struck.hit]
        alone = [group[0] for group in self._system.apart(hit) if len(group) == 1]
        limits = [limit for stop in alone if (limit := self._limit(struck, stop)) is not None]
        return state.series, rests_of(self._system, state, [[limit] for limit in limits])

    def _limit(self, struck: ImpactOutcome, stop: Stop) -> Limit | None:
        """Where the collisions of a stop end that throw others of its part open, once known."""
        system, before, state = self._system, struck.before, struck.after
        closed = before.closed & system.coupled([stop.name])
        names = closed | {stop.name}
        if not any(struck.rates.get(name, 0.0) > 0.0 for name in closed):
            return None
        if system.constraint_set(names | state.closed).freedom < 0:
            return None
        key = stop.name, closed
        series = self._known.get(key, NestedSeries())
        if series.times and knot_between(system, series.times[-1], state.t):
            series = NestedSeries()
        series = series.struck(state.t, -stop.rate(before.v), struck.number)
        self._known[key] = series
        t, error = _rest_of_nested(struck, names, series)
        if not isfinite(t):
            return None
        stops = tuple(item for item in system.mechanism.stops if item.name in names)
        return Limit(stops, t, error, series.start)

    def forget(self, opened: Collection[str]) -> None:
        """End the series of a part: one of its stops is pressed no more."""
        part = self._system.coupled(opened)
        self._known = {key: own for key, own in self._known.items() if key[0] not in part}


def _rest_of_nested(
    struck: ImpactOutcome, names: Closed, series: NestedSeries
) -> tuple[float, float]:
    """Time [s] at which stops that throw one another open come to rest together, and its error.

    The series has the collisions of one of them, the others having been at rest. Infinite while not
    known yet.
    """
    system, case, state = struck.system, struck.case, struck.after
    if case.rest_rate is not None:
        fastest = max(rate for name, rate in struck.rates.items() if name in names)
        return (state.t if fastest < case.rest_rate else inf), 0.0
    if any(system.mechanism.stop(name).restitution >= 1.0 for name in names):
        # One that loses nothing comes to rest by what the others lose, if at all.
        return UNKNOWN
    tolerance = case.resolution.tolerance
    large = series.rates[-1] ** 3 > DROPPED_SERIES * tolerance * series.fastest**3
    if large and series.events < _MANY_EVENTS:
        return UNKNOWN
    t_rest, error = series.limit()
    allowed = tolerance * (t_rest - series.start)
    if series.events >= _MANY_EVENTS:
        allowed = NESTED_AT_LAST * tolerance * system.shaft.period
    unknown = not error <= allowed or t_rest <= state.t
    if unknown or other_stop_meets(struck, names, t_rest):
        return UNKNOWN
    if system.shaft.smooth_for(state.t) < t_rest - state.t:
        return UNKNOWN
    return t_rest, error


def vanishing_bounces(struck: ImpactOutcome) -> Followed:
    """Rests after collisions after which no stop of a part opens further than by round-off."""
    system, state = struck.system, struck.after
    if not struck.rebounding:
        return state.series, ()
    parts = [system.coupled([group[0].name]) for group in system.apart(struck.rebounding)]
    limits = [limit for part in parts if (limit := _vanished(struck, part))]
    return state.series, rests_of(system, state, [[limit] for limit in limits])


def _vanished(struck: ImpactOutcome, part: Closed) -> Limit | None:
    """Where a part comes to rest; None if one of its open stops is still on its way."""
    system, state, a = struck.system, struck.after, struck.a
    stops = [stop for stop in system.mechanism.stops if stop.name in part]
    still = [stop for stop in stops if stop.name not in state.closed]
    if any(stop.restitution >= 1.0 for stop in still):
        # One that loses nothing rests by what the others lose, if at all.
        return None
    lasts, units = max(_lasts(stop, state, a) for stop in still), system.body.unit_of
    # Places of stops tell the round-off of all coordinates of their part.
    least = VANISHED_REBOUND * max(abs(stop.at) / units[stop.index] for stop in stops)
    if any(_rise(stop, state, a, lasts) > least * units[stop.index] for stop in still):
        return None
    return Limit(tuple(stops), state.t + lasts, lasts, state.t)


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


def series_rules(system: System, case: Case, nested: NestedBounces) -> tuple[Rule, ...]:
    """Return the rules of a machine, in the order in which they are asked."""
    if len(system.mechanism.stops) < 2:
        return (bounces,)
    if case.rest_rate is None and any(stop.at for stop in system.mechanism.stops):
        return nested.followed, vanishing_bounces, bounces
    return nested.followed, bounces
