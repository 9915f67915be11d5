"""Round-off of states that drives and closures determine, and what their closures are open by.

Such a state has no history. A closure that is open, by round-off or because its iteration ended,
moves all dependent positions together, and rates are those of that place: near a dead centre they
change with the square of what positions do. A row of G v = 0 is a sum of levers times rates, each
of which is rounded, however small the rates are that follow.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics import Partition, System, close_velocities
from ...tolerances.hybrid import (
    ANGLE_ROUND_OFF,
    DIFFERENCE_STEP,
    INDEPENDENT_ROUND_OFF,
    LENGTH_ROUND_OFF,
    LEVER_ROUND_OFF,
    RATE_ROUND_OFF,
)
from ..motion.panel import one_state_at
from ..segment import Segment
from .local_error import opened, unsure
from .zonotope import Deviations


def at_start(
    system: System,
    closed: frozenset[str],
    t: float,
    q: FloatArray,
    v: FloatArray,
    split: Partition | None = None,
) -> Deviations:
    """Deviations of a state with which a motion begins.

    Args:
        t: When [s].
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).
        split: Dependent and independent coordinates, where they are known.
    """
    split = _split(system, closed, q) if split is None else split
    # In the touch configuration nothing is turned, and only lengths and their sums are rounded.
    length = INDEPENDENT_ROUND_OFF if q.any() else LENGTH_ROUND_OFF
    # The independent ones are given.
    by = np.zeros(len(q))
    by[split.columns] = length * system.body.reach_m
    found = of_closures(system, split, q, v, by)
    return of_rates(system, closed, t, q, v, split).joined(Deviations.of(found))


def at_end(system: System, segment: Segment) -> Deviations:
    """Deviations at the end of a segment without freedom, which forgets those before.

    A state between the nodes of a panel is taken from its interpolant where the closures are open
    there by no more than their iteration leaves.
    """
    panel, t = segment.panels[-1], segment.t_end
    q, v, *_ = one_state_at(system, system.constraint_set(segment.closed), panel, t)
    by = unsure(system, panel.split)
    by[panel.split.columns] += np.abs(system.body.closures(q[None])[0][0])
    found = of_closures(system, panel.split, q, v, by)
    return of_rates(system, segment.closed, t, q, v, panel.split).joined(Deviations.of(found))


def of_rates(
    system: System,
    closed: frozenset[str],
    t: float,
    q: FloatArray,
    v: FloatArray,
    split: Partition | None = None,
) -> Deviations:
    """Round-off of rates that follow from drives and closures; arguments as :func:`at_start`.

    That of the rates of drives, which the others follow; of the terms of the closure rates; and
    what the round-off of the cylinder angle does to all: with accelerations a and cylinder speed W
    it is a dpsi / W, also where a rate passes through zero.
    """
    shaft, nv = system.shaft, len(q)
    split = _split(system, closed, q) if split is None else split
    phase, motion = system.constraint_set(closed), shaft.driven(np.array([t]))
    a = system.accelerations(motion, q[None], v[None], phase)[0]
    shifted = ANGLE_ROUND_OFF * max(abs(float(shaft.angle(t))), 1.0) / shaft.speed_rad_s
    following = np.diag(RATE_ROUND_OFF * np.abs(v))
    if split.dependent:
        _, (jacobian,) = system.body.closures(q[None])
        by_closures, free = opened(jacobian, split), np.array(split.independent, dtype=np.intp)
        terms = LEVER_ROUND_OFF * (np.abs(jacobian) @ np.abs(v))
        following[np.ix_(split.columns, free)] = -by_closures @ jacobian @ following[:, free]
        following[np.ix_(split.columns, split.columns)] = by_closures * terms
    turned = shifted * np.concatenate([v, a])[:, None]
    return Deviations.of(np.hstack([np.vstack([np.zeros((nv, nv)), following]), turned]))


def of_closures(
    system: System, split: Partition, q: FloatArray, v: FloatArray, by: FloatArray
) -> FloatArray:
    """Deviations by open closures and by the round-off of positions, with the rates of the place.

    Args:
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).
        by: By how much closures are open, in the places of the dependent coordinates, and
            round-off of the independent positions, shape (nv,) [m, rad or m].

    Returns:
        (dq, dv), one column a closure or an independent position, shape (2 nv, nv).
    """
    nv = len(q)
    moved = np.eye(nv)
    if split.dependent:
        _, (jacobian,) = system.body.closures(q[None])
        moved[np.ix_(split.columns, split.columns)] = opened(jacobian, split)
    steps = DIFFERENCE_STEP * system.body.units
    _, jacobians = system.body.closures(q + np.diag(steps))
    turned = (close_velocities(np.tile(v, (nv, 1)), jacobians, split) - v).T / steps
    return np.vstack([moved, turned @ moved]) * by


def _split(system: System, closed: frozenset[str], q: FloatArray) -> Partition:
    phase, (_, jacobians) = system.constraint_set(closed), system.body.closures(q[None])
    return system.split(jacobians[0], phase.given, phase.yielding)
