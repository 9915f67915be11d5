"""Stops at rest that throw one another open: series of bounces that hold series themselves."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf, isfinite

from ....arrays import FloatArray
from ....dynamics.impact import arrest
from ....dynamics.system import System
from ....errors import ImpactError, SingularConfigurationError
from ....tolerances.hybrid import DROPPED_SERIES
from ...case import Case
from ...contact.complementarity import Closed, pressed
from ...contact.nested_series import NestedSeries
from ...state import State
from .guards import UNKNOWN, knot_between, other_stop_meets
from .struck import Rest, Series, Struck


class NestedBounces:
    """Collisions at one stop that throw others open, which were at rest.

    Args:
        system: The system.
        case: The case.
    """

    name = "stops that throw one another open"

    def __init__(self, system: System, case: Case) -> None:
        """Begin without any series."""
        self._system, self._case = system, case
        self._known: dict[tuple[str, Closed], NestedSeries] = {}

    def concerns(self, struck: Struck) -> bool:
        """Return whether a collision at one stop opens others."""
        closed, rates = struck.before.closed, struck.rates
        return len(struck.hit) == 1 and any(rates.get(name, 0.0) > 0.0 for name in closed)

    def followed(self, struck: Struck, a: FloatArray) -> tuple[Series, Sequence[Rest]]:
        """Add such a collision; see :meth:`.SeriesRule.followed`."""
        rest = self._followed(struck, a)
        return struck.after.series, () if rest is None else (rest,)

    def _followed(self, struck: Struck, a: FloatArray) -> Rest | None:
        """The rest of all these stops, once it is known."""
        system, before, state = self._system, struck.before, struck.after
        names = before.closed | struck.hit
        phase = system.constraint_set(names)
        if phase.freedom < 0:
            return None
        (name,) = struck.hit
        part = system.coupled(struck.hit)
        key = name, before.closed & part
        series = self._known.get(key, NestedSeries())
        if series.times and knot_between(system, series.times[-1], state.t):
            series = NestedSeries()
        series = series.struck(state.t, -system.mechanism.stop(name).rate(before.v))
        self._known[key] = series
        fastest = max(struck.rates.values())
        t_rest, error = rest_of_nested(system, self._case, state, a, names, fastest, series)
        if not isfinite(t_rest):
            return None
        try:
            shut = [stop for stop in phase.shut if stop.name in part]
            impact = arrest(system, state.q, state.v, state.jacobian, shut)
        except (ImpactError, SingularConfigurationError):
            # Stops that depend on one another through the closures do not rest together.
            return None
        stay = pressed(system, state.motion, state.q, impact.v_after, state.jacobian, names)
        if stay != names:
            return None
        return Rest(t_rest, error, sorted(names - state.closed), impact, names)

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
        system: The system.
        case: The case.
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
    if series.rates[-1] ** 3 > DROPPED_SERIES * tolerance * series.fastest**3:
        return UNKNOWN
    t_rest, error = series.limit()
    if system.shaft.smooth_for(state.t) < t_rest - state.t:
        return UNKNOWN
    if not error <= tolerance * (t_rest - series.start) or other_stop_meets(
        system, state, a, names, t_rest
    ):
        return UNKNOWN
    return t_rest, error
