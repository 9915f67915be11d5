"""Local errors of flights: the unresolved parts of positions and rates.

They come from what the dynamics say between the nodes, where the interpolant is wrong by the
Chebyshev coefficients that it lacks, from what one more sweep would change and from what the
round-off of a state does to its acceleration, more than round-off where masses differ much.

A state that drives and closures determine has round-off alone, and no history. A closure that is
open, by round-off or because its iteration ended, moves all dependent positions together, and rates
are those of that place: near a dead centre they change with the square of what positions do. A row
of G v = 0 is a sum of levers times rates, each of which is rounded, however small the rates are
that follow.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Vector
from ...chebyshev import nodes
from ...dynamics import ConstraintSet, Partition, System, close_velocities, inverted
from ...tolerances.hybrid import (
    ANGLE_ROUND_OFF,
    DIFFERENCE_STEP,
    INDEPENDENT_ROUND_OFF,
    LENGTH_ROUND_OFF,
    LEVER_ROUND_OFF,
    LOCAL_ERROR_SAFETY,
    POLYNOMIAL_ROUND_OFF,
    RATE_ROUND_OFF,
)
from ..history import Segment, State
from ..motion.panel import Panel, defect, nearby, one_state_at
from .zonotope import Zonotope


def unsure(system: System, split: Partition) -> FloatArray:
    """Round-off of independent positions, of closures in the places of dependent ones, (nv,)."""
    found = INDEPENDENT_ROUND_OFF * system.mechanism.extents
    found[split.columns] = INDEPENDENT_ROUND_OFF * system.body.reach_m
    return found


def round_off(system: System, split: Partition, q: FloatArray) -> FloatArray:
    """Round-off of positions, (nv,): of dependent ones that of the closures, by their lever."""
    found = unsure(system, split)
    if split.dependent:
        _, jacobian = system.body.closures(q[None])
        found[split.columns] *= np.abs(opened(jacobian[0], split)).sum(axis=1)
    return found


def opened(jacobian: FloatArray, split: Partition) -> FloatArray:
    """Dependent positions by what closures are open by, shape (m, m)."""
    return inverted(jacobian.take(split.columns, 1))[1]


def unresolved(system: System, phase: ConstraintSet, panel: Panel) -> tuple[FloatArray, FloatArray]:
    """Unresolved parts of all positions and velocities of a flight panel, each (nv,)."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times, panel.middle)
    again = system.accelerations(motion, panel.q, panel.v, phase)
    swept = again - a
    there = system.accelerations(motion, *nearby(system, panel.q, panel.v, panel.split), phase)
    rough = np.abs(there - again).max(axis=0)
    # The last coefficients may be small by chance; what is wrong between the nodes is not.
    missing = defect(system, phase, panel, grid.between).max(axis=0)
    if system.mechanism.knots:
        # Across a row of a table coefficients decay by powers: of k^-3 that all follow, twice
        # integrated, a quarter of their number times the last one is missing.
        last = np.abs(grid.integrals[0][-2:] @ a).max(axis=0)
        missing = np.maximum(missing, 0.25 * panel.order * last)
    round_off = POLYNOMIAL_ROUND_OFF * (np.abs(panel.v[0]) + h * np.abs(a).max(axis=0))
    position = missing / (2.0 * panel.order) ** 2 + np.abs(grid.twice @ swept).max(axis=0)
    velocity = missing / (2.0 * panel.order) + np.abs(grid.once @ swept).max(axis=0)
    return (
        LOCAL_ERROR_SAFETY * h**2 * (position + 0.5 * rough) + h * round_off,
        LOCAL_ERROR_SAFETY * h * (velocity + rough) + round_off,
    )


def at_start(system: System, state: State, split: Partition | None = None) -> Zonotope:
    """Deviations of a state with which a motion begins."""
    q, split = state.q, _split(system, state) if split is None else split
    # In the touch configuration nothing is turned, and only lengths and their sums are rounded.
    length = INDEPENDENT_ROUND_OFF if q.any() else LENGTH_ROUND_OFF
    # The independent ones are given.
    by = np.zeros(len(q))
    by[split.columns] = length * system.body.reach_m
    found = of_closures(system, split, q, state.v, by)
    return of_rates(system, state, split).joined(Zonotope.of(found))


def at_end(system: System, segment: Segment) -> Zonotope:
    """Deviations at the end of a segment without freedom, which forgets those before.

    A state between the nodes of a panel is taken from its interpolant where the closures are open
    there by no more than their iteration leaves.
    """
    panel, t = segment.panels[-1], segment.t_end
    q, v, *_ = one_state_at(system, system.constraint_set(segment.closed), panel, t)
    by = unsure(system, panel.split)
    by[panel.split.columns] += np.abs(system.body.closures(q[None])[0][0])
    found = of_closures(system, panel.split, q, v, by)
    state = State.at(system, t, q, v, segment.closed)
    return of_rates(system, state, panel.split).joined(Zonotope.of(found))


def of_rates(system: System, state: State, split: Partition | None = None) -> Zonotope:
    """Round-off of rates that follow from drives and closures.

    That of the rates of drives, which the others follow; of the terms of the closure rates; and
    what the round-off of the cylinder angle does to all: with accelerations a and cylinder speed W
    it is a dpsi / W, also where a rate passes through zero.
    """
    shaft, (t, q, v, jacobian, *_), nv = system.shaft, state, len(state.q)
    split = _split(system, state) if split is None else split
    phase, motion = system.constraint_set(state.closed), shaft.driven(np.array([t]))
    a = system.accelerations(motion, q[None], v[None], phase)[0]
    shifted = ANGLE_ROUND_OFF * max(abs(float(shaft.angle(t))), 1.0) / shaft.speed_rad_s
    following = np.diag(RATE_ROUND_OFF * np.abs(v))
    if split.dependent:
        by_closures, free = opened(jacobian, split), np.array(split.independent, dtype=np.intp)
        terms = LEVER_ROUND_OFF * (np.abs(jacobian) @ np.abs(v))
        following[np.ix_(split.columns, free)] = -by_closures @ jacobian @ following[:, free]
        following[np.ix_(split.columns, split.columns)] = by_closures * terms
    turned = shifted * np.concatenate([v, a])[:, None]
    return Zonotope.of(np.hstack([np.vstack([np.zeros((nv, nv)), following]), turned]))


def of_closures(
    system: System, split: Partition, q: Vector, v: Vector, by: FloatArray
) -> FloatArray:
    """Deviations by open closures and by the round-off of positions, with the rates of the place.

    Args:
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


def _split(system: System, state: State) -> Partition:
    phase = system.constraint_set(state.closed)
    return system.split(state.jacobian, phase.given, phase.yielding)
