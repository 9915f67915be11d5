"""Ends of series of bounces: which stops come to rest, when, and by which impulse."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from ...arrays import FloatArray
from ...dynamics.impact import Impact, arrest
from ...dynamics.system import System
from ...errors import ImpactError, SingularConfigurationError
from ...mechanism import Stop
from ..case import Case
from ..contact.bounce_series import BounceSeries
from ..contact.complementarity import Closed, pressed
from ..contact.nested_series import NestedSeries
from ..state import State
from .rest import rest_of_nested, rest_of_series


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


class SeriesEnds:
    """Series of bounces of one run, and their ends.

    Args:
        system: The system.
        case: The case.
    """

    def __init__(self, system: System, case: Case) -> None:
        """Begin without any series."""
        self._system, self._case = system, case
        self._nested: dict[tuple[str, Closed], NestedSeries] = {}

    def forget(self) -> None:
        """End the series of stops that throw one another open: one of them is pressed no more."""
        self._nested.clear()

    def bounced(
        self, state: State, series: BounceSeries | None, stop: Stop, a: FloatArray
    ) -> tuple[BounceSeries, Rest | None]:
        """Add a bounce of a stop that bounces alone.

        Args:
            state: State just after the bounce.
            series: The series before it.
            stop: The stop.
            a: Acceleration there, shape (nv,).

        Returns:
            The series with this bounce, and its end once that is known.
        """
        system = self._system
        if series is None or series.stop != stop.name:
            series = BounceSeries(stop.name, state.t)
        elif series.times and self._knot_since(series.times[-1], state.t):
            series = series.anew()
        series = series.bounced(state.t, stop.rate(state.v), -stop.rate(a))
        t_rest, error = rest_of_series(system, self._case, state, a, stop, series)
        if not math.isfinite(t_rest):
            return series, None
        shut = system.constraint_set(state.closed).shut
        impact = arrest(system, state.q, state.v, state.jacobian, [stop, *shut])
        names = state.closed | {stop.name}
        closed = pressed(system, state.motion, state.q, impact.v_after, state.jacobian, names)
        if stop.name not in closed:
            return series, None
        return series, Rest(t_rest, error, [stop.name], impact, closed)

    def thrown_open(
        self, before: State, state: State, hit: set[str], rates: Mapping[str, float], a: FloatArray
    ) -> Rest | None:
        """Add a collision that throws stops open that were at rest.

        Args:
            before: State just before the collision.
            state: State just after it.
            hit: Stops that have just closed.
            rates: Rate of every stop in contact after it, by name.
            a: Acceleration after it, shape (nv,).

        Returns:
            The end of the series of such collisions once it is known.
        """
        system, names = self._system, before.closed | hit
        phase = system.constraint_set(names)
        if phase.freedom < 0:
            return None
        (name,) = hit
        key = name, before.closed
        series = self._nested.get(key, NestedSeries())
        if series.times and self._knot_since(series.times[-1], state.t):
            series = NestedSeries()
        series = series.struck(state.t, -system.mechanism.stop(name).rate(before.v))
        self._nested[key] = series
        fastest = max(rates.values())
        t_rest, error = rest_of_nested(system, self._case, state, a, names, fastest, series)
        if not math.isfinite(t_rest):
            return None
        try:
            impact = arrest(system, state.q, state.v, state.jacobian, phase.shut)
        except (ImpactError, SingularConfigurationError):
            # Stops that depend on one another through the closures do not rest together.
            return None
        stay = pressed(system, state.motion, state.q, impact.v_after, state.jacobian, names)
        if stay != names:
            return None
        return Rest(t_rest, error, sorted(names - state.closed), impact, names)

    def _knot_since(self, before: float, t: float) -> bool:
        """True if the law of a drive has changed its polynomial between two times [s]."""
        return before + self._system.shaft.smooth_for(before) < t
