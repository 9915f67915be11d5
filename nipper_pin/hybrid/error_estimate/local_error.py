"""Local errors of flights: the unresolved parts of positions and rates.

They come from what the dynamics say between the nodes, where the interpolant is wrong by the
Chebyshev coefficients that it lacks, from what one more sweep would change and from what the
round-off of a state does to its acceleration, more than round-off where masses differ much.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics.assembly import Partition, close_velocities, inverted
from ...dynamics.constraint_set import ConstraintSet
from ...dynamics.system import System
from ...tolerances.hybrid import (
    DIFFERENCE_STEP,
    INDEPENDENT_ROUND_OFF,
    LOCAL_ERROR_SAFETY,
    POLYNOMIAL_ROUND_OFF,
)
from ..motion.chebyshev import nodes
from ..motion.panel import Panel, defect, nearby


def independent_round_off(system: System) -> FloatArray:
    """Round-off of an independent position, of the size that closures have, (nv,) [rad or m]."""
    return INDEPENDENT_ROUND_OFF * system.mechanism.extents


def round_off(system: System, split: Partition, q: FloatArray) -> FloatArray:
    """Round-off of positions, (nv,): of dependent ones that of the closures, by their lever."""
    found = independent_round_off(system)
    if split.dependent:
        _, jacobian = system.body.closures(q[None])
        lever = np.abs(_opened(jacobian[0], split)).sum(axis=1)
        found[split.columns] = INDEPENDENT_ROUND_OFF * system.body.reach_m * lever
    return found


def of_closures(system: System, panel: Panel, q: FloatArray, v: FloatArray) -> FloatArray:
    """Deviations by round-off of closures and of positions, with the rates of the place.

    Each closure that is open moves all dependent positions together. Near a dead centre rates
    change with the square of what positions do.

    Args:
        system: The system.
        panel: The panel that the state lies on.
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).

    Returns:
        (dq, dv), one column a closure or an independent position, shape (2 nv, nv).
    """
    split, nv = panel.split, len(q)
    # A closure is open by as much as a slide; a hinge, in radians, by that in units of length.
    moved = np.diag(system.body.units / system.mechanism.unit_m)
    if split.dependent:
        _, jacobian = system.body.closures(q[None])
        moved[np.ix_(split.columns, split.columns)] = _opened(jacobian[0], split)
    steps = DIFFERENCE_STEP * system.body.units
    _, jacobian = system.body.closures(q + np.diag(steps))
    turned = (close_velocities(np.tile(v, (nv, 1)), jacobian, split) - v).T / steps
    round_off = INDEPENDENT_ROUND_OFF * system.body.reach_m
    return np.vstack([moved, turned @ moved]) * round_off


def _opened(jacobian: FloatArray, split: Partition) -> FloatArray:
    """Dependent positions by what closures are open by, shape (m, m)."""
    return inverted(jacobian.take(split.columns, 1))[1]


def _between(system: System, phase: ConstraintSet, panel: Panel) -> FloatArray:
    """Largest difference of the dynamics from the interpolant between the nodes, (nv,).

    The last coefficients may be small by chance; what is wrong between the nodes is not.
    """
    return np.asarray(defect(system, phase, panel, nodes(panel.order).between).max(axis=0))


def unresolved(system: System, phase: ConstraintSet, panel: Panel) -> tuple[FloatArray, FloatArray]:
    """Unresolved parts of all positions and velocities of a flight panel, each (nv,)."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times)
    again = system.accelerations(motion, panel.q, panel.v, phase)
    swept = again - a
    there = system.accelerations(motion, *nearby(system, panel.q, panel.v, panel.split), phase)
    rough = np.abs(there - again).max(axis=0)
    missing = _between(system, phase, panel)
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
