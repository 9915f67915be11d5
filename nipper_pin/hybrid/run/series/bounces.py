"""Bounces of one stop or of several, which end at rest: at their limits, or at a threshold."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import inf, isfinite, tau
from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....dynamics import Impact, System, close_positions, close_velocities, closing_impulse
from ....errors import ConvergenceError, ElementError, ImpactError, SingularConfigurationError
from ....mechanism import Stop
from ....tolerances.hybrid import (
    CONSTANT_DECELERATION,
    DROPPED_SERIES,
    SIMULTANEOUS,
    STEADY_DECELERATION,
    TIME_ROUND_OFF,
)
from ....tolerances.mechanics import EPS
from ...case import Case
from ...contact.active_set import active_set
from ...contact.bounce_series import BounceSeries
from ...history import Closed, State

Series = tuple[BounceSeries, ...]


class ImpactOutcome(NamedTuple):
    """A collision that has been computed.

    Attributes:
        before: State just before it, with the series of bounces until then.
        after: State just after it, with those series that it does not disturb.
        hit: Names of the stops that have just closed.
        rates: Rate of every stop in contact after it, by name [rad/s or m/s].
        rebounding: The stops that have just closed and open again.
        acceleration: Acceleration of a state, shape (nv,).
    """

    system: System
    case: Case
    number: int
    before: State
    after: State
    hit: set[str]
    rates: Mapping[str, float]
    rebounding: Sequence[Stop]
    acceleration: Callable[[State], FloatArray]

    @property
    def a(self) -> FloatArray:
        """Acceleration just after it, shape (nv,): found only where a rule asks for it."""
        return self.acceleration(self.after)


class Change(NamedTuple):
    """What an event changes: a collision, a release, or a rest, the limit of a series of bounces.

    Attributes:
        t: Its time [s]; that of a limit lies beyond the state before it.
        error: Estimated error of a limit [s]; zero for others.
        stops: Names of the stops that it concerns.
        impact: Its impulses; at a limit what takes the last rates away.
        closed: Closed stops from then on.
    """

    t: float
    error: float
    stops: Sequence[str]
    impact: Impact
    closed: Closed


class Limit(NamedTuple):
    """Where a series ends.

    Attributes:
        stops: The stops that come to rest there, those that are closed already among them.
        t: Its time [s].
        error: Estimated error of that [s].
        start: Time of its first collision [s].
    """

    stops: tuple[Stop, ...]
    t: float
    error: float
    start: float

    @property
    def names(self) -> Closed:
        """Names of the stops."""
        return frozenset(stop.name for stop in self.stops)


Followed = tuple[Series, Sequence[Change]]
"""All series of bounces after a collision; and the ends that are known, in order of time."""
Rule = Callable[[ImpactOutcome], Followed]
UNKNOWN = inf, inf


def knot_between(system: System, before: float, t: float) -> bool:
    """True if the law of a drive changes its polynomial between two times [s]."""
    return before + system.shaft.smooth_for(before) < t


def other_stop_meets(struck: ImpactOutcome, bouncing: Collection[str], t_rest: float) -> bool:
    """True if another stop of their part may close while the bounces that are left out go on.

    It would meet a stop that still bounces, not one at rest.
    """
    system, state, a = struck.system, struck.after, struck.a
    left, part = t_rest - state.t, system.coupled(bouncing)
    return any(
        lowest_gap(stop.gap(state.q), stop.rate(state.v), stop.rate(a), left) <= 0.0
        for stop in system.mechanism.stops
        if stop.name in part and stop.name not in state.closed and stop.name not in bouncing
    )


def lowest_gap(gap: float, rate: float, acceleration: float, left: float) -> float:
    """Lowest gap in a time left [s], at constant acceleration; a little less if that falls."""
    if rate < 0.0 < acceleration:
        turn = min(left, -rate / acceleration)
        return gap + turn * (rate + 0.5 * acceleration * turn)
    return gap + left * (min(rate, 0.0) + left * acceleration)


def rests_of(system: System, state: State, parts: Iterable[list[Limit]]) -> list[Change]:
    """Rests at the limits of each part, in order of time; parts that move alike rest as one."""
    instant = SIMULTANEOUS * system.shaft.period
    groups: list[list[Limit]] = []
    for part in sorted(parts, key=latest):
        if groups and latest(part) - latest(groups[-1]) <= instant:
            groups[-1].extend(part)
        else:
            groups.append(part)
    rests = list[Change]()
    for group in groups:
        rest = _rest(system, state, group)
        if rest is not None:
            rests.append(rest)
            state = state._replace(v=rest.impact.v_after, closed=rest.closed)
    return rests


def _rest(system: System, state: State, limits: Sequence[Limit]) -> Change | None:
    """The rest of stops that come to rest as one; None if they are not pressed shut then."""
    stops = [stop for limit in limits for stop in limit.stops]
    names = frozenset(stop.name for stop in stops)
    part = system.coupled(names)
    shut = [stop for stop in system.constraint_set(state.closed - names).shut if stop.name in part]
    try:
        impact = closing_impulse(system, state.q, state.v, state.jacobian, [*stops, *shut])
    except (ImpactError, SingularConfigurationError):
        if len(stops) == 1:
            raise
        # Stops that depend on one another through the closures do not rest together.
        return None
    for name in state.closed - part:
        # Round-off in a part that the impact does not reach.
        impact.v_after[system.mechanism.stop(name).index] = 0.0
    after = state._replace(v=impact.v_after)
    closed = active_set(system, after, state.closed | names, names)
    if names <= closed:
        newly = sorted(names - state.closed)
        return Change(latest(limits), latest_error(limits), newly, impact, closed)
    loose = system.coupled(names - closed)
    others = [limit for limit in limits if loose.isdisjoint(limit.names)]
    return _rest(system, state, others) if others else None


def latest(limits: Sequence[Limit]) -> float:
    """Time of the last of several limits [s]."""
    return max(limit.t for limit in limits)


def latest_error(limits: Sequence[Limit]) -> float:
    """Error of that time, taken for all of them [s]."""
    return max(limit.error + (latest(limits) - limit.t) for limit in limits)


# Bounces that are followed at least, until they are small. With a restitution of 0.98 they are as
# small as one sees; with 0.9999 it would take a hundred thousand.
_MANY = 200


def bounces(struck: ImpactOutcome) -> Followed:
    """Bounces of stops, each of which has a series of its own, in the state of a run.

    A collision goes on with the series of every stop that it throws open, and ends those of the
    other stops in its part of the machine, whose motion it changes. So stops that do not touch one
    another bounce each for itself, and stops of one part that are struck together, again and again.
    """
    system, state = struck.system, struck.after
    if not struck.rebounding:
        return state.series, ()
    a = struck.a
    found: list[BounceSeries] = []
    known: list[Limit] = []
    for stop in struck.rebounding:
        own = [item for item in struck.before.series if item.stop == stop.name]
        series = own[0] if own else BounceSeries(stop.name, state.t)
        if series.times and knot_between(system, series.times[-1], state.t):
            series = series.anew()
        series = series.bounced(state.t, stop.rate(state.v), -stop.rate(a))
        found.append(series)
        t_rest, error = accumulation_point(struck, stop, series)
        if isfinite(t_rest):
            known.append(Limit((stop,), t_rest, error, series.start))
    if not known:
        return (*state.series, *found), ()
    parts: dict[frozenset[str], list[Limit]] = {}
    for limit in known:
        parts.setdefault(system.coupled(limit.names), []).append(limit)
    bouncing = {stop.name for stop in struck.rebounding}
    # Of a part all bouncing stops come to rest, as one.
    at_rest = [
        limits
        for part, limits in parts.items()
        if len(limits) == len(bouncing & part) and (len(limits) == 1 or _as_one(struck, limits))
    ]
    return (*state.series, *found), rests_of(system, state, at_rest)


def _as_one(struck: ImpactOutcome, limits: Sequence[Limit]) -> bool:
    """True if stops of one part come to rest at one time, as far as the tolerance tells."""
    case = struck.case
    if case.rest_rate is not None:
        return True
    lasts = latest(limits) - min(limit.start for limit in limits)
    shortest = TIME_ROUND_OFF * struck.system.shaft.period
    return latest_error(limits) <= max(case.resolution.tolerance * lasts, shortest)


def accumulation_point(
    struck: ImpactOutcome, stop: Stop, series: BounceSeries
) -> tuple[float, float]:
    """Time at which a bouncing stop comes to rest, and its error [s]; infinite if not known yet."""
    system, case, state = struck.system, struck.case, struck.after
    e_N, rate, deceleration = stop.restitution, series.rates[-1], series.decelerations[-1]
    if case.rest_rate is not None:
        return (state.t if rate < case.rest_rate else inf), 0.0
    if deceleration <= 0.0 or e_N >= 1.0:
        return UNKNOWN
    t, tolerance, period = state.t, case.resolution.tolerance, system.shaft.period
    remaining = 2.0 * rate / (deceleration * (1.0 - e_N))
    if remaining <= tolerance * period:
        # Accelerations change at the rate of the turning; a deceleration that is small beside them
        # does so faster, and near a dead centre everything does.
        fastest = max(2.0, float(np.abs(struck.a).max()) / deceleration)
        changes = tau * fastest / period * remaining
        changes += abs(_deceleration_at_rest(struck, stop, remaining) / deceleration - 1)
        if changes < CONSTANT_DECELERATION or remaining <= TIME_ROUND_OFF * period:
            return t + remaining, min(changes, 1.0) * remaining
    large = rate**3 > DROPPED_SERIES * tolerance * series.fastest**3
    if large and series.count < _MANY:
        return UNKNOWN
    if system.shaft.smooth_for(t) < 2.0 * remaining:
        # What follows a knot of a drive's table is another function of time.
        return UNKNOWN
    t_rest, error = series.limit(e_N)
    if series.uneven <= STEADY_DECELERATION:
        there = _deceleration_at_rest(struck, stop, remaining)
        changes = max(abs(there / deceleration - 1.0), series.uneven) + 4.0 * EPS
        # A law of the rate has e_N in the limit only.
        changes += abs(stop.coefficient(-rate) - e_N) / (1.0 - e_N)
        if changes * remaining <= error:
            t_rest, error = t + remaining, changes * remaining
    known = error <= tolerance * (t - series.start + remaining)
    bouncing = [item.name for item in struck.rebounding]
    if not known or other_stop_meets(struck, bouncing, t_rest):
        return UNKNOWN
    return t_rest, error


def _deceleration_at_rest(struck: ImpactOutcome, stop: Stop, remaining: float) -> float:
    """Deceleration of a stop where it will be at rest [rad/s^2 or m/s^2]; infinite if unknown.

    All that bounce with it will be at rest then.
    """
    system, state, a, mates = struck.system, struck.after, struck.a, struck.rebounding
    phase, t = system.constraint_set(state.closed), state.t + remaining
    columns = [item.index for item in mates]
    try:
        split = system.split(state.jacobian, phase.given, (*columns, *phase.yielding))
        if not set(columns).isdisjoint(split.dependent):
            return inf
        q = (state.q + remaining * (state.v + 0.5 * remaining * a))[None]
        v = (state.v + remaining * a)[None]
        motion = system.shaft.driven_at(t)
        system.prescribe(motion, q, v, phase)
        q[:, columns], v[:, columns] = [item.at for item in mates], 0.0
        q, jacobian = close_positions(system.body, q, split)
        there = system.accelerations(motion, q, close_velocities(v, jacobian, split), phase)
    except (ConvergenceError, ElementError, SingularConfigurationError):
        return inf
    return -stop.rate(there[0])
