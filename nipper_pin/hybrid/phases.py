"""Transitions between phases, as pure functions of the set of closed stops."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

from ..arrays import FloatArray
from ..dynamics.multipliers import multipliers
from ..dynamics.shaft import Driven
from ..dynamics.system import System
from ..errors import SimulationError

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
    """Which stops at rest (zero gap and rate) stay closed: complementarity of the accelerations.

    g_N_ddot >= 0, la_N >= 0, g_N_ddot la_N = 0 for every stop at rest. The largest set that pushes
    everywhere is taken. One stop alone pushes if it would close without a force: its mass
    W M^-1 W' is positive.

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
    if len(at_rest) == 1:
        (name,) = at_rest
        free = system.constraint_set(frozenset())
        if free.freedom > 0:
            a = system.accelerations(motion, q[None], v[None], free)[0]
            return at_rest if a[system.mechanism.stop(name).index] <= 0.0 else frozenset()
    for size in range(len(at_rest), -1, -1):
        for names in combinations(sorted(at_rest), size):
            rows = system.constraint_set(frozenset(names))
            if rows.freedom < 0:
                continue
            a = system.accelerations(motion, q[None], v[None], rows)
            split = system.split(jacobian, rows.given, ())
            la_N = multipliers(system, q[None], v[None], a, jacobian[None], rows, split).la_N
            leaving = [
                a[0, system.mechanism.stop(name).index] for name in at_rest if name not in names
            ]
            if (la_N >= 0.0).all() and min(leaving, default=0.0) >= 0.0:
                return frozenset(names)
    message = (
        f"no set of the stops {sorted(at_rest)} can stay closed: each choice "
        "either pulls or penetrates; check the sides of the stops"
    )
    raise SimulationError(message, stops=sorted(at_rest))
