"""What flights leave unresolved in positions and rates: the errors that they make of their own.

They come from what the dynamics say between the nodes, where the interpolant is wrong by the
Chebyshev coefficients that it lacks, from what one more sweep would change and from what the
round-off of a state does to its acceleration, more than round-off where masses differ much.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition, close_velocities, inverted
from ..dynamics.system import ConstraintSet, System
from .collocation import nodes
from .panel import Panel, defect, nearby

_EPS = float(np.finfo(float).eps)
# True errors were up to 4.6 times the bare estimate, over ten runs at six tolerances; with masses
# that differ by 1e8 up to 11 times.
_SAFETY = 8.0
# Step of differences of positions [rad or m].
_STEP = 1e-6
# Round-off of a polynomial, in units of that of its largest term.
_OPERATIONS = 4.0


def independent_round_off(system: System) -> float:
    """Round-off of an independent position [rad or m], of the size that closures have."""
    return 8.0 * _EPS * system.body.reach_m


def round_off(system: System, split: Partition, q: FloatArray) -> FloatArray:
    """Round-off of positions, (nv,): of dependent ones that of the closures, by their lever."""
    lever = np.ones(len(q))
    if split.dependent:
        _, jacobian = system.body.closures(q[None])
        _, inverse = inverted(jacobian[0].take(split.columns, 1))
        lever[split.columns] = np.abs(inverse).sum(axis=1)
    return np.asarray(independent_round_off(system) * lever)


def of_closures(system: System, panel: Panel, q: FloatArray, v: FloatArray) -> FloatArray:
    """Deviations by round-off of each position, with the rates that closures have at that place.

    Near a dead centre rates change with the square of what positions do.

    Args:
        system: The system.
        panel: The panel that the state lies on.
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).

    Returns:
        (dq, dv), one column a position, shape (2 nv, nv).
    """
    sizes, nv = round_off(system, panel.split, q), len(q)
    rates = np.tile(v, (nv, 1))
    _, jacobian = system.body.closures(q + _STEP * np.eye(nv))
    turned = (close_velocities(rates, jacobian, panel.split) - v) / _STEP
    return np.vstack([np.diag(sizes), turned.T * sizes])


def _between(system: System, rows: ConstraintSet, panel: Panel) -> FloatArray:
    """Largest difference of the dynamics from the interpolant between the nodes, (nv,).

    The last coefficients may be small by chance; what is wrong between the nodes is not.
    """
    return np.asarray(defect(system, rows, panel, nodes(panel.order).between).max(axis=0))


def unresolved(system: System, rows: ConstraintSet, panel: Panel) -> tuple[FloatArray, FloatArray]:
    """What a flight panel leaves unresolved in all positions and velocities, each (nv,)."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times)
    again = system.accelerations(motion, panel.q, panel.v, rows)
    swept = again - a
    there = system.accelerations(motion, *nearby(system, panel.q, panel.v, panel.split), rows)
    rough = np.abs(there - again).max(axis=0)
    missing = _between(system, rows, panel)
    if system.mechanism.tabulated_springs:
        # Across a row of a table coefficients decay by powers: of k^-3 that all follow, twice
        # integrated, a quarter of their number times the last one is missing.
        last = np.abs(grid.integrals[0][-2:] @ a).max(axis=0)
        missing = np.maximum(missing, 0.25 * panel.order * last)
    round_off = _OPERATIONS * _EPS * (np.abs(panel.v[0]) + h * np.abs(a).max(axis=0))
    position = missing / (2.0 * panel.order) ** 2 + np.abs(grid.twice @ swept).max(axis=0)
    velocity = missing / (2.0 * panel.order) + np.abs(grid.once @ swept).max(axis=0)
    return (
        _SAFETY * h**2 * (position + 0.5 * rough) + h * round_off,
        _SAFETY * h * (velocity + rough) + round_off,
    )
