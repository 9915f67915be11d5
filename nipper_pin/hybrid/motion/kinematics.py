"""Panels of phases without freedom: the drives determine the motion, node by node."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, largest, product
from ...chebyshev import nodes, tail
from ...dynamics import (
    ConstraintSet,
    Partition,
    System,
    close_positions,
    close_velocities,
    multipliers,
)
from ...errors import SingularConfigurationError
from ...tolerances.hybrid import (
    CLOCK_ROUND_OFF,
    COORDINATE_ROUND_OFF,
    ROUND_OFF_SAFETY,
    SMALLEST,
)
from ...tolerances.mechanics import EPS, MAX_CONDITION
from ..case import Resolution
from .noise_floor import of_closures, rates_of_closures
from .panel import Attempt, Begin, Panel, judged


def kinematic_panel(
    system: System,
    phase: ConstraintSet,
    split: Partition,
    begin: Begin,
    h: float,
    resolution: Resolution,
) -> Attempt:
    """Motion for a time h [s] of a phase without freedom, where the drives determine everything."""
    t, q, v, _, jacobian = begin
    times = t + h * nodes(resolution.kinematic_nodes).sigma
    guess, rates = (row[None].repeat(len(times), 0) for row in (q, v))
    motion = system.shaft.driven(times, t + 0.5 * h)
    system.prescribe(motion, guess, rates, phase)
    # The tangent at the start, along which the others follow the drives.
    guess[:, split.columns] += system.lift(jacobian, split, guess - q)[:, split.columns]
    q_nodes, jacobian = close_positions(system.body, guess, split)
    inverse = _inverses(system, jacobian, split)
    v_nodes = close_velocities(rates, jacobian, split, inverse)
    # Stops may lock links through closures, or all of them while drive trains wind up: what these
    # would have of the accelerations of the dynamics is round-off of the forces on them.
    known = phase, split, inverse
    a_nodes = system.determined_accelerations(motion, q_nodes, v_nodes, *known)
    forces = multipliers(system, motion, q_nodes, v_nodes, a_nodes, jacobian, *known).la_N
    panel = Panel(t, h, q_nodes, v_nodes, a_nodes, split, integrated=False)
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    columns = np.concatenate([q_nodes, v_nodes, a_nodes, forces], 1)
    sizes, tails = (_Columns.of(found(columns), len(q)) for found in (largest, tail))
    # What no shorter panel would resolve either must not advise one.
    round_off = _round_off(system, sizes.q, split, inverse[0])
    rough_a = _rough_accelerations(panel, sizes, tails, round_off, resolution) * phase.moving
    roughest = max(rough_a.tolist(), default=0.0)
    excess = _excess(h, sizes, tails, round_off, resolution)
    if roughest > 1.0:
        still = h * sizes.v + h**2 * sizes.a
        nothing = h * rates_of_closures(system, v_nodes)
        nothing += h**2 * of_closures(system, v_nodes, a_nodes)
        nothing += _of_drives(system, h)[1]
        rough_a[still <= ROUND_OFF_SAFETY * nothing] = 0.0
        roughest = float(rough_a.max())
    if excess > 1.0:
        clock = CLOCK_ROUND_OFF * (abs(t) + system.shaft.period) * sizes.v
        round_off += ROUND_OFF_SAFETY * (_of_drives(system, h)[0] + clock)
        excess = _excess(h, sizes, tails, round_off, resolution)
    excess = max(excess, roughest)
    if system.mechanism.struts:
        excess = max(excess, _rough_pulls(system, panel, resolution))
    return judged(panel, forces, excess, resolution.kinematic_nodes)


class _Columns(NamedTuple):
    """A number of each column of positions, velocities, accelerations and stop forces at nodes.

    Shapes (nv,) and, of forces, (closed,).
    """

    q: FloatArray
    v: FloatArray
    a: FloatArray
    forces: FloatArray

    @classmethod
    def of(cls, numbers: FloatArray, nv: int) -> _Columns:
        """Numbers found at once: the arrays are small, and each call costs more than its sums."""
        return cls(numbers[:nv], numbers[nv : 2 * nv], numbers[2 * nv : 3 * nv], numbers[3 * nv :])


def _excess(
    h: float, sizes: _Columns, tails: _Columns, round_off: FloatArray, resolution: Resolution
) -> float:
    """Unresolved parts of positions and stop forces of a panel, in units of the tolerance.

    From the largest values at its nodes and the last Chebyshev coefficients. Stop forces are second
    derivatives: they are resolved less far than positions, and their roots are polished on the
    exact motion.
    """
    left_over = np.maximum(tails.q - round_off, 0.0)
    rough = left_over / (resolution.tolerance * h * sizes.v + SMALLEST)
    rough_force = tails.forces / (math.sqrt(resolution.tolerance) * (sizes.forces + SMALLEST))
    return float(max(*rough.tolist(), *rough_force.tolist(), 0.0))


def _rough_pulls(system: System, panel: Panel, resolution: Resolution) -> float:
    """The same of forces between points, which are rough where the points pass closely."""
    pulls = system.point_forces(panel.q, panel.v).reshape(panel.order, -1)
    rough = tail(pulls) / (np.sqrt(resolution.tolerance) * np.abs(pulls).max() + SMALLEST)
    return float(rough.max())


def _rough_accelerations(
    panel: Panel, sizes: _Columns, tails: _Columns, round_off: FloatArray, resolution: Resolution
) -> FloatArray:
    """Unresolved part of the accelerations of a panel, in units of the tolerance, shape (nv,).

    They are second derivatives: they are resolved less far than positions, by what they change.
    Near a dead centre they rise within the round-off of the positions. Arguments as of
    :func:`_excess`.
    """
    h, v = panel.h, panel.v
    changed = h * sizes.v + h**2 * sizes.a + SMALLEST
    # The last coefficients of round-off may be small by chance, but rates, found without them, are
    # then not the integral of accelerations.
    apart = largest(v - v[0] - h * product(nodes(len(v)).once, panel.a))
    apart = np.maximum(h * apart - round_off, 0.0)
    left_over = np.maximum(h**2 * tails.a, apart)
    return np.asarray(left_over / (math.sqrt(resolution.tolerance) * changed))


def _inverses(system: System, jacobian: FloatArray, split: Partition) -> FloatArray:
    """Inverses of the dependent blocks of the closures at the nodes, shape (N, m, m).

    Raises:
        SingularConfigurationError: The nodes lie on both sides of a dead centre, behind which the
            links can go either way, or one is so near that rates are not determined any more.
    """
    blocks = jacobian.take(split.columns, 2)
    if not split.dependent:
        return blocks
    # On one branch the determinant of the dependent columns keeps its sign.
    volumes = np.linalg.det(blocks).tolist()
    if min(volumes) <= 0.0 <= max(volumes):
        message = (
            "the motion passes through a dead centre, behind which the links can go either "
            "way; change the dimensions or the drive"
        )
        raise SingularConfigurationError(message, volumes=volumes)
    inverses = np.linalg.inv(blocks)
    there, back = blocks, inverses
    if system.body.scaled:
        units = system.body.units.take(split.columns)
        there, back = blocks * units, inverses / units[:, None]
    # All nodes together bound the condition of each, and are found faster.
    if math.sqrt(np.vdot(there, there)) * math.sqrt(np.vdot(back, back)) < MAX_CONDITION:
        return np.asarray(inverses)
    sizes = [np.einsum("nij,nij->n", matrices, matrices) for matrices in (there, back)]
    condition = float(np.sqrt((sizes[0] * sizes[1]).max()))
    if not condition < MAX_CONDITION:
        message = (
            f"a dead centre is so near (condition {condition:.2g}) that round-off decides on the "
            "rates; change the dimensions or the drive"
        )
        raise SingularConfigurationError(message, condition=condition)
    return np.asarray(inverses)


def _of_drives(system: System, h: float) -> FloatArray:
    """Round-off that laws of drives leave where they hardly move, shape (2, nv).

    Of the coordinates, and of what their rates and accelerations add to these on a panel of the
    length h [s].
    """
    found = np.zeros((2, system.body.nv))
    at, rates, accelerations = COORDINATE_ROUND_OFF * system.shaft.sizes
    found[:, system.driven_columns] = at, h * rates + h**2 * accelerations
    return found


def _round_off(
    system: System, largest_q: FloatArray, split: Partition, inverse: FloatArray
) -> FloatArray:
    """Round-off of every coordinate on a panel, shape (nv,): less than it no panel can resolve."""
    size = largest_q + EPS
    # Near a dead centre this is large; from MAX_CONDITION on the position is refused.
    size[split.columns] += system.body.reach_m * np.abs(inverse).sum(axis=1)
    return np.asarray(COORDINATE_ROUND_OFF * size)
