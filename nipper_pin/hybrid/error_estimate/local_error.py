"""Local errors of flights: the unresolved parts of positions and rates.

They come from what the dynamics say between the nodes, where the interpolant is wrong by the
Chebyshev coefficients that it lacks, from what one more sweep would change and from what the
round-off of a state does to its acceleration, more than round-off where masses differ much.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...chebyshev import nodes
from ...dynamics import ConstraintSet, Partition, System, inverted
from ...tolerances.hybrid import (
    INDEPENDENT_ROUND_OFF,
    LOCAL_ERROR_SAFETY,
    POLYNOMIAL_ROUND_OFF,
)
from ..motion.panel import Panel, defect, nearby


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


def _between(system: System, phase: ConstraintSet, panel: Panel) -> FloatArray:
    """Largest difference of the dynamics from the interpolant between the nodes, (nv,).

    The last coefficients may be small by chance; what is wrong between the nodes is not.
    """
    return np.asarray(defect(system, phase, panel, nodes(panel.order).between).max(axis=0))


def unresolved(system: System, phase: ConstraintSet, panel: Panel) -> tuple[FloatArray, FloatArray]:
    """Unresolved parts of all positions and velocities of a flight panel, each (nv,)."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times, panel.middle)
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
