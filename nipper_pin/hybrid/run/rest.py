"""When stops that bounce come to rest: the limit of a series, or the threshold of the case."""

from __future__ import annotations

from collections.abc import Collection
from math import inf, tau

import numpy as np

from ...arrays import FloatArray
from ...dynamics.assembly import close_positions, close_velocities
from ...dynamics.system import System
from ...errors import ConvergenceError, ElementError, SingularConfigurationError
from ...mechanism import Stop
from ...tolerances import TIME_ROUND_OFF
from ..case import Case
from ..contact.bounce_series import BounceSeries
from ..contact.nested_series import NestedSeries
from ..state import State

# What is left of the motion is dropped. It leaves an error of the motion afterwards of order w^3,
# found to be at most 2e-3 w^3 in relative rates of inertial shafts; ``left_out.py`` tells it.
_DROPPED = 100.0
_UNKNOWN = inf, inf
# A deceleration that changes by more than this share is not taken for constant, unless no more than
# round-off of a turn is left.
_CHANGED = 0.1


def rest_of_series(
    system: System, case: Case, state: State, a: FloatArray, stop: Stop, series: BounceSeries
) -> tuple[float, float]:
    """Time at which a stop that bounces alone comes to rest, and its error.

    Args:
        system: The system.
        case: The case.
        state: State just after a bounce.
        a: Acceleration there, shape (nv,).
        stop: The stop.
        series: Its bounces.

    Returns:
        Both in [s]; infinite while not known yet.
    """
    e_N, rate, deceleration = stop.restitution, series.rates[-1], series.decelerations[-1]
    if case.rest_rate is not None:
        return (state.t if rate < case.rest_rate else inf), 0.0
    if deceleration <= 0.0 or e_N >= 1.0:
        return _UNKNOWN
    t, tolerance, period = state.t, case.resolution.tolerance, system.shaft.period
    remaining = 2.0 * rate / (deceleration * (1.0 - e_N))
    if remaining <= tolerance * period:
        # Accelerations change at the rate of the turning; a deceleration that is small beside them
        # does so faster, and near a dead centre everything does.
        changes = tau * max(2.0, float(np.abs(a).max()) / deceleration) / period * remaining
        changes += abs(_deceleration_at_rest(system, state, a, stop, remaining) / deceleration - 1)
        if changes < _CHANGED or remaining <= TIME_ROUND_OFF * period:
            return t + remaining, min(changes, 1.0) * remaining
    if rate**3 > _DROPPED * tolerance * series.fastest**3:
        return _UNKNOWN
    if system.shaft.smooth_for(t) < 2.0 * remaining:
        # What follows a knot of a drive's table is another function of time.
        return _UNKNOWN
    t_rest, error = series.limit(e_N)
    known = error <= tolerance * (t - series.start + remaining)
    if not known or _met(system, state, a, {stop.name}, t_rest):
        return _UNKNOWN
    return t_rest, error


def _deceleration_at_rest(
    system: System, state: State, a: FloatArray, stop: Stop, remaining: float
) -> float:
    """Deceleration of a stop where it will be at rest [rad/s^2 or m/s^2]; infinite if unknown."""
    phase, t = system.constraint_set(state.closed), state.t + remaining
    try:
        split = system.split(state.jacobian, phase.given, (stop.index, *phase.yielding))
        if stop.index in split.dependent:
            return inf
        q = (state.q + remaining * (state.v + 0.5 * remaining * a))[None]
        v = (state.v + remaining * a)[None]
        motion = system.shaft.driven_at(t)
        system.prescribe(motion, q, v, phase)
        q[:, stop.index], v[:, stop.index] = stop.at, 0.0
        q, jacobian = close_positions(system.body, q, split)
        there = system.accelerations(motion, q, close_velocities(v, jacobian, split), phase)
    except (ConvergenceError, ElementError, SingularConfigurationError):
        return inf
    return -stop.rate(there[0])


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
        return _UNKNOWN
    tolerance = case.resolution.tolerance
    if series.rates[-1] ** 3 > _DROPPED * tolerance * series.fastest**3:
        return _UNKNOWN
    t_rest, error = series.limit()
    if system.shaft.smooth_for(state.t) < t_rest - state.t:
        return _UNKNOWN
    if not error <= tolerance * (t_rest - series.start) or _met(system, state, a, names, t_rest):
        return _UNKNOWN
    return t_rest, error


def _met(
    system: System, state: State, a: FloatArray, bouncing: Collection[str], t_rest: float
) -> bool:
    """True if another stop may close while the bounces that are left out go on.

    It would meet a stop that still bounces, not one at rest.
    """
    left = t_rest - state.t
    return any(
        lowest_gap(stop.gap(state.q), stop.rate(state.v), stop.rate(a), left) <= 0.0
        for stop in system.mechanism.stops
        if stop.name not in state.closed and stop.name not in bouncing
    )


def lowest_gap(gap: float, rate: float, acceleration: float, left: float) -> float:
    """Lowest gap within a time that is left, at constant acceleration; a little less if that falls.

    Args:
        gap: The gap [rad or m].
        rate: Its rate.
        acceleration: Its acceleration.
        left: The time [s].
    """
    if rate < 0.0 < acceleration:
        turn = min(left, -rate / acceleration)
        return gap + turn * (rate + 0.5 * acceleration * turn)
    return gap + left * (min(rate, 0.0) + left * acceleration)
