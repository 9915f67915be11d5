"""Transitions between phases, as pure functions of the set of closed stops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...dynamics.constraint_set import ConstraintSet
from ...dynamics.multipliers import multipliers
from ...dynamics.shaft import Driven
from ...dynamics.system import System
from ...errors import SimulationError, SingularConfigurationError
from ...mechanism import Stop
from ...tolerances.hybrid import ACCELERATION_LOOKAHEAD, ACTIVE_SET_ROUND_OFF
from ..motion.panel import Panel, one_state_at

Closed = frozenset[str]


def after_release(closed: Closed, released: Iterable[str]) -> Closed:
    """Closed stops after the forces of some have fallen to zero."""
    return closed - frozenset(released)


def after_collision(closed: Closed, rates: dict[str, float]) -> Closed:
    """Stops that may be closed after a collision: those in contact that do not separate.

    Args:
        closed: Closed stops before.
        rates: Rate of every stop in contact after the impact, by name.
    """
    return frozenset(name for name, rate in rates.items() if rate == 0.0) | (closed - rates.keys())


def pressed(
    system: System,
    motion: Driven,
    q: FloatArray,
    v: FloatArray,
    jacobian: FloatArray,
    at_rest: Closed,
) -> Closed:
    """Stops at rest (zero gap and rate) that stay closed, by complementarity of accelerations.

    g_N_ddot >= 0, la_N >= 0, g_N_ddot la_N = 0 for every stop at rest, solved by trying the sets of
    stops that can stay closed together, the largest ones first: with W M^-1 W' positive definite
    only one satisfies it. One stop alone pushes if it would close without a force.

    Args:
        system: The system.
        motion: Driven coordinates at this time, as one row.
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).
        jacobian: Closure Jacobian, shape (m, nv).
        at_rest: Names of the stops at rest.

    Returns:
        Names of the stops that stay closed.

    Raises:
        SimulationError: No set satisfies the conditions.
    """
    stops = [stop for stop in system.mechanism.stops if stop.name in at_rest]
    if len(stops) == 1:
        free = system.constraint_set(frozenset())
        if free.freedom > 0:
            a = system.accelerations(motion, q[None], v[None], free)[0]
            return at_rest if stops[0].rate(a) <= 0.0 else frozenset()
    tried: list[_Held] = []
    for size in range(len(stops), -1, -1):
        for chosen in combinations(stops, size):
            names = frozenset(stop.name for stop in chosen)
            found = _held(system, motion, q, v, jacobian, names, stops)
            if found is None:
                continue
            if min(found.forces.min(initial=0.0), found.leaving.min(initial=0.0)) >= 0.0:
                return names
            tried.append(found)
    if tried:
        force, leaving = (
            ACTIVE_SET_ROUND_OFF * np.abs(values).max(axis=0)
            for values in ([item.forces for item in tried], [item.leaving for item in tried])
        )
        for item in tried:
            if (item.forces >= -force).all() and (item.leaving >= -leaving).all():
                return item.names
    message = (
        f"no set of the stops {sorted(at_rest)} can stay closed: each choice "
        "either pulls or penetrates; check the sides of the stops"
    )
    raise SimulationError(message, stops=sorted(at_rest))


def pressed_next(system: System, phase: ConstraintSet, panel: Panel, t: float) -> Closed:
    """Closed stops that are still closed a moment later.

    Where forces vanish together, so do all accelerations: what comes next tells which stops open.

    Args:
        system: The system.
        phase: The phase that ends.
        panel: Its last panel.
        t: Its end [s].

    Returns:
        Names of the stops that stay closed.

    Raises:
        SimulationError: No set satisfies the conditions.
    """
    later = t + ACCELERATION_LOOKAHEAD * system.shaft.period
    q, v, jacobian, motion = one_state_at(system, phase, panel, later)
    return pressed(system, motion, q, v, jacobian, phase.closed)


class _Held(NamedTuple):
    """Forces and accelerations of the stops at rest for one choice of closed stops.

    Attributes:
        names: The stops that are held closed.
        forces: la_N of every stop at rest, zero of those that are not held, shape (stops,).
        leaving: g_N_ddot likewise, zero of those that are held, shape (stops,).
    """

    names: Closed
    forces: FloatArray
    leaving: FloatArray


def _held(
    system: System,
    motion: Driven,
    q: FloatArray,
    v: FloatArray,
    jacobian: FloatArray,
    names: Closed,
    stops: Sequence[Stop],
) -> _Held | None:
    """Try one choice; None if these stops depend on one another, so that fewer hold as much."""
    phase = system.constraint_set(names)
    if phase.freedom < 0:
        return None
    try:
        split = system.split(jacobian, phase.given, phase.yielding)
    except SingularConfigurationError:
        return None
    a = system.accelerations(motion, q[None], v[None], phase)
    la_N = multipliers(system, motion, q[None], v[None], a, jacobian[None], phase, split).la_N[0]
    held = np.array([stop.name in names for stop in stops], dtype=bool)
    forces = np.zeros(len(stops))
    forces[held] = la_N
    leaving = np.where(held, 0.0, [stop.rate(a[0]) for stop in stops])
    return _Held(names, forces, leaving)
