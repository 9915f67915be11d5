"""Transitions between phases, as pure functions of the set of closed stops.

Stops that lie on one another, gap and rate being round-off, take part in an impact.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from ...arrays import FloatArray, Jacobian, Vector
from ...dynamics import ConstraintSet, System
from ...dynamics.complementarity import (
    complementary,
    delassus,
    force_size,
    independent,
    inverse_mass_roots,
)
from ...errors import SimulationError
from ...mechanism import Stop
from ...tolerances.hybrid import ACCELERATION_LOOKAHEAD, ACTIVE_SET_ROUND_OFF, GAP_ROUND_OFF
from ...tolerances.mechanics import STILL_GAP_RATE
from ..history import Closed, State
from ..motion.panel import Exact, Panel, one_state_at


def active_set(
    system: System, state: State | Exact, at_rest: Closed, about: Collection[str] | None = None
) -> Closed:
    """Stops at rest (zero gap and rate) that stay closed, by complementarity of accelerations.

    g_N_ddot >= 0, la_N >= 0, g_N_ddot la_N = 0 for every stop at rest, in each part of the machine
    by itself. A stop that neither opens nor is pressed, but for round-off, stays closed; of stops
    that depend on one another as many close as can carry a force.

    Args:
        about: Names of stops whose parts are asked for, all by default; what rests in others stays
            closed.

    Raises:
        SimulationError: No set satisfies the conditions.
    """
    concerned = at_rest if about is None else at_rest & system.coupled(about)
    if not concerned:
        return at_rest
    q, v, jacobian, motion = state.q, state.v, state.jacobian, state.motion
    stops = [stop for stop in system.mechanism.stops if stop.name in concerned]
    free = system.constraint_set(frozenset())
    a = system.accelerations(motion, q[None], v[None], free)[0]
    if len(stops) == 1 and free.freedom > 0 and stops[0].rate(a) <= 0.0:
        return at_rest
    closed: list[Stop] = []
    for group in system.apart(stops):
        matrix = delassus(system, q, jacobian, group)
        size = ACTIVE_SET_ROUND_OFF * force_size(system, motion, q, v, a, group[0].index)
        nothing = size * inverse_mass_roots(system, q, [stop.index for stop in group])
        found = _of_one_part(matrix, np.array([stop.rate(a) for stop in group]), nothing)
        if found is None:
            message = (
                f"no set of the stops {sorted(concerned)} can stay closed: each choice "
                "either pulls or penetrates; check the sides of the stops"
            )
            raise SimulationError(message, stops=sorted(concerned))
        closed += [group[i] for i in found]
    return (at_rest - concerned).union(stop.name for stop in closed)


def active_set_next(
    system: System, phase: ConstraintSet, panel: Panel, t: float, about: Collection[str]
) -> Closed:
    """Closed stops that are still closed a moment after a phase, and its last panel, end at t [s].

    Where forces vanish together, so do all accelerations: what comes next tells which stops open.
    """
    later = t + ACCELERATION_LOOKAHEAD * system.shaft.period
    return active_set(system, one_state_at(system, phase, panel, later), phase.closed, about)


def _of_one_part(matrix: FloatArray, leaving: FloatArray, nothing: FloatArray) -> list[int] | None:
    """Places of the stops that stay closed.

    Args:
        leaving: g_N_ddot of each stop without any force.
        nothing: Round-off of each of these.

    Returns:
        Places; None if no forces satisfy the conditions.
    """
    forces = complementary(matrix, np.where(np.abs(leaving) <= nothing, 0.0, leaving))
    if forces is None:
        return None
    held = np.flatnonzero(forces > 0.0).tolist()
    left = np.abs(matrix @ forces + leaving) <= nothing + ACTIVE_SET_ROUND_OFF * (
        np.abs(matrix) @ forces
    )
    for place in np.flatnonzero(left).tolist():
        if place not in held and independent(matrix, held, place):
            held.append(place)
    return sorted(held)


def touching(
    system: System, q: Vector, v: Vector, stops: Iterable[Stop], known: Collection[str]
) -> list[Stop]:
    """Stops whose gap and rate are zero, but for round-off of machine and motion.

    Those that are known to be closed, or to close, are none of them.
    """
    # Few gaps are so small, and only these are worth a look at units.
    far = GAP_ROUND_OFF * max(system.body.reach_m, 1.0)
    near = [stop for stop in stops if stop.name not in known and -far <= stop.gap(q) <= far]
    if not near:
        return near
    turning, rates = system.turning, system.turns(v)
    slow = STILL_GAP_RATE * max(float(rates.max()), system.shaft.speed_rad_s)
    return [
        stop
        for stop in near
        if abs(stop.gap(q)) * turning[stop.index] <= GAP_ROUND_OFF and rates[stop.index] <= slow
    ]


def stilled(system: System, v: Vector, jacobian: Jacobian, stops: list[Stop]) -> FloatArray:
    """Velocity without the round-off of the rates of stops that touch, shape (nv,)."""
    columns = tuple(stop.index for stop in stops)
    if not np.any(v[list(columns)]):
        return v
    v = v.copy()
    v[list(columns)] = 0.0
    if not len(jacobian):
        return v
    return system.closed_velocity(
        v, jacobian, system.split(jacobian, system.held_coordinates, columns)
    )
