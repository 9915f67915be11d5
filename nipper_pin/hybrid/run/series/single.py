"""Bounces of one stop, which end at rest: at the limit of their series, or at a threshold."""

from __future__ import annotations

from math import inf, isfinite, tau

import numpy as np

from ....arrays import FloatArray
from ....dynamics.assembly import close_positions, close_velocities
from ....dynamics.impact import arrest
from ....dynamics.system import System
from ....errors import ConvergenceError, ElementError, SingularConfigurationError
from ....mechanism import Stop
from ....tolerances.hybrid import CONSTANT_DECELERATION, DROPPED_SERIES, TIME_ROUND_OFF
from ...case import Case
from ...contact.bounce_series import BounceSeries
from ...contact.complementarity import pressed
from ...state import State
from .guards import UNKNOWN, knot_between, other_stop_meets
from .struck import Rest, Struck


class SingleBounces:
    """Bounces of a stop that bounces alone, the others being open or closed all the while.

    Args:
        system: The system.
        case: The case.
    """

    name = "bounces of one stop"

    def __init__(self, system: System, case: Case) -> None:
        """The series itself is part of the state of a run."""
        self._system, self._case = system, case

    def concerns(self, struck: Struck) -> bool:
        """Return whether one stop rebounds, and no other."""
        return len(struck.rebounding) == 1

    def followed(self, struck: Struck, a: FloatArray) -> tuple[BounceSeries, Rest | None]:
        """Add a bounce; see :meth:`.SeriesRule.followed`."""
        system, state, (stop,) = self._system, struck.after, struck.rebounding
        series = struck.before.series
        if series is None or series.stop != stop.name:
            series = BounceSeries(stop.name, state.t)
        elif series.times and knot_between(system, series.times[-1], state.t):
            series = series.anew()
        series = series.bounced(state.t, stop.rate(state.v), -stop.rate(a))
        t_rest, error = rest_of_series(system, self._case, state, a, stop, series)
        if not isfinite(t_rest):
            return series, None
        shut = system.constraint_set(state.closed).shut
        impact = arrest(system, state.q, state.v, state.jacobian, [stop, *shut])
        names = state.closed | {stop.name}
        closed = pressed(system, state.motion, state.q, impact.v_after, state.jacobian, names)
        if stop.name not in closed:
            return series, None
        return series, Rest(t_rest, error, [stop.name], impact, closed)

    def forget(self) -> None:
        """Nothing is kept here."""


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
        return UNKNOWN
    t, tolerance, period = state.t, case.resolution.tolerance, system.shaft.period
    remaining = 2.0 * rate / (deceleration * (1.0 - e_N))
    if remaining <= tolerance * period:
        # Accelerations change at the rate of the turning; a deceleration that is small beside them
        # does so faster, and near a dead centre everything does.
        changes = tau * max(2.0, float(np.abs(a).max()) / deceleration) / period * remaining
        changes += abs(_deceleration_at_rest(system, state, a, stop, remaining) / deceleration - 1)
        if changes < CONSTANT_DECELERATION or remaining <= TIME_ROUND_OFF * period:
            return t + remaining, min(changes, 1.0) * remaining
    if rate**3 > DROPPED_SERIES * tolerance * series.fastest**3:
        return UNKNOWN
    if system.shaft.smooth_for(t) < 2.0 * remaining:
        # What follows a knot of a drive's table is another function of time.
        return UNKNOWN
    t_rest, error = series.limit(e_N)
    known = error <= tolerance * (t - series.start + remaining)
    if not known or other_stop_meets(system, state, a, {stop.name}, t_rest):
        return UNKNOWN
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
