"""Stops at rest that throw one another open: series of bounces that hold series themselves."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf, isfinite
from typing import NamedTuple

from ....arrays import FloatArray
from ....dynamics import System
from ....mechanism import Stop
from ....tolerances.hybrid import DROPPED_SERIES, NESTED_AT_LAST, SIMULTANEOUS
from ...case import Case
from ...contact.complementarity import Closed
from ...contact.nested_series import NestedSeries
from ...state import State
from .guards import UNKNOWN, knot_between, other_stop_meets
from .shut import shut_together
from .struck import Rest, Series, Struck, as_one

# Events of a series, with those of the series inside, from which on what is left out need not be
# small, nor the limit be known as well as that of fewer.
_MANY = 1000


class _Limit(NamedTuple):
    """When collisions end that throw stops open [s], the error of that [s], and all these stops."""

    t: float
    error: float
    names: Closed


class NestedBounces:
    """Collisions, one in a part, that throw others open, which were at rest."""

    name = "stops that throw one another open"

    def __init__(self, system: System, case: Case) -> None:
        """Begin without any series."""
        self._system, self._case = system, case
        self._known: dict[tuple[str, Closed], NestedSeries] = {}

    def concerns(self, struck: Struck) -> bool:
        """Return whether collisions open other stops, which were at rest."""
        return any(struck.rates.get(name, 0.0) > 0.0 for name in struck.before.closed)

    def followed(self, struck: Struck, a: FloatArray) -> tuple[Series, Sequence[Rest]]:
        """Add such collisions, one a part; see :meth:`.SeriesRule.followed`."""
        system, state, rests = self._system, struck.after, list[Rest]()
        hit = [system.mechanism.stop(name) for name in struck.hit]
        alone = [group[0] for group in system.apart(hit) if len(group) == 1]
        limits = [limit for stop in alone if isfinite((limit := self._limit(struck, a, stop)).t)]
        for together in as_one([[limit] for limit in limits], SIMULTANEOUS * system.shaft.period):
            names = frozenset().union(*(limit.names for limit in together))
            t = max(limit.t for limit in together)
            error = max(limit.error + (t - limit.t) for limit in together)
            rest = shut_together(system, state, names, t, error)
            if rest is not None:
                rests.append(rest)
                state = state._replace(v=rest.impact.v_after, closed=rest.closed)
        return struck.after.series, rests

    def _limit(self, struck: Struck, a: FloatArray, stop: Stop) -> _Limit:
        """Where the collisions of a stop end that throw others of its part open."""
        system, before, state = self._system, struck.before, struck.after
        closed = before.closed & system.coupled([stop.name])
        names = closed | {stop.name}
        unknown = _Limit(inf, inf, names)
        if not any(struck.rates.get(name, 0.0) > 0.0 for name in closed):
            return unknown
        if system.constraint_set(names | state.closed).freedom < 0:
            return unknown
        key = stop.name, closed
        series = self._known.get(key, NestedSeries())
        if series.times and knot_between(system, series.times[-1], state.t):
            series = NestedSeries()
        series = series.struck(state.t, -stop.rate(before.v), struck.number)
        self._known[key] = series
        fastest = max(rate for name, rate in struck.rates.items() if name in names)
        return _Limit(*rest_of_nested(system, self._case, state, a, names, fastest, series), names)

    def forget(self, opened: Collection[str]) -> None:
        """End the series of a part: one of its stops is pressed no more."""
        part = self._system.coupled(opened)
        self._known = {key: own for key, own in self._known.items() if key[0] not in part}


def rest_of_nested(
    system: System,
    case: Case,
    state: State,
    a: FloatArray,
    names: Collection[str],
    fastest: float,
    series: NestedSeries,
) -> tuple[float, float]:
    """Time at which stops that throw one another open come to rest together, and its error.

    Args:
        state: State just after a collision at one of them, the others having been at rest.
        a: Acceleration there, shape (nv,).
        names: Names of all of them.
        fastest: Largest rate at which one of them opens [rad/s or m/s].
        series: The collisions of that one.

    Returns:
        Both in [s]; infinite while not known yet.
    """
    if case.rest_rate is not None:
        return (state.t if fastest < case.rest_rate else inf), 0.0
    if any(system.mechanism.stop(name).restitution >= 1.0 for name in names):
        # One that loses nothing comes to rest by what the others lose, if at all.
        return UNKNOWN
    tolerance = case.resolution.tolerance
    large = series.rates[-1] ** 3 > DROPPED_SERIES * tolerance * series.fastest**3
    if large and series.events < _MANY:
        return UNKNOWN
    t_rest, error = series.limit()
    allowed = tolerance * (t_rest - series.start)
    if series.events >= _MANY:
        allowed = NESTED_AT_LAST * tolerance * system.shaft.period
    unknown = not error <= allowed or t_rest <= state.t
    if unknown or other_stop_meets(system, state, a, names, t_rest):
        return UNKNOWN
    if system.shaft.smooth_for(state.t) < t_rest - state.t:
        return UNKNOWN
    return t_rest, error
