"""Variational equation: deviations at the end of a panel, linear in those at its start.

The free independent coordinates y of a panel tell the others, q(y) and v(y, y'). Neighbouring
motions differ in them by dy, with

    ddy = A(t) dy + B(t) dy',    A = da/dy at y' held,  B = da/dy',

A and B being differences of accelerations at the nodes. The collocation that integrates the panel
solves this linear equation, too: for the accelerations of dy at the nodes, a small linear system.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics.assembly import Partition, close_velocities
from ...dynamics.constraint_set import ConstraintSet
from ...dynamics.system import System
from ...tolerances.hybrid import DIFFERENCE_STEP, SMALLEST
from ..motion.chebyshev import evaluate_motion, nodes
from ..motion.panel import Panel


def free_coordinates(phase: ConstraintSet, split: Partition) -> list[int]:
    """Independent coordinates that forces move: one for each freedom of a phase."""
    return [k for k in split.independent if phase.moving[k]]


def lifts(jacobian: FloatArray, split: Partition, columns: list[int]) -> FloatArray:
    """Derivatives dq/dy of all coordinates by the independent ones, at N states.

    Args:
        jacobian: Closure Jacobians G, shape (N, m, nv).
        split: Dependent and independent coordinates.
        columns: The independent ones that count, K of them.

    Returns:
        Shape (K, N, nv): one after another.
    """
    shape = len(columns), len(jacobian), jacobian.shape[2]
    units = np.zeros(shape)
    units[range(len(columns)), :, columns] = 1.0
    repeated = np.tile(jacobian, (len(columns), 1, 1))
    return close_velocities(units.reshape(-1, shape[2]), repeated, split).reshape(shape)


def steps(system: System, units: FloatArray, columns: list[int]) -> FloatArray:
    """Steps of difference quotients by the independent coordinates, shape (K,).

    Args:
        system: The system.
        units: What :func:`lifts` gives, shape (K, N, nv).
        columns: The independent ones that count, K of them.
    """
    sizes = np.abs(units / system.body.units).max(axis=(1, 2), initial=0.0)
    return np.asarray(DIFFERENCE_STEP / np.maximum(sizes, 1.0 / system.body.units[columns]))


def fastest(system: System, v: FloatArray) -> float:
    """Largest rate in units of its coordinate [1/s], and never zero."""
    return max(float(np.abs(v / system.body.units).max()), SMALLEST)


def tangents(
    system: System, q: FloatArray, v: FloatArray, split: Partition, columns: list[int]
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of all coordinates and rates by the independent ones, at N states.

    Args:
        system: The system.
        q: Configurations, shape (N, nv).
        v: Velocities, shape (N, nv).
        split: Dependent and independent coordinates.
        columns: The independent ones that count, K of them.

    Returns:
        dq/dy = dv/dy' and dv/dy at independent rates held, shapes (K, N, nv).
    """
    units = lifts(system.body.closures(q)[1], split, columns)
    step = steps(system, units, columns)[:, None, None]
    moved = (q + step * units).reshape(-1, q.shape[1])
    rates = np.tile(v, (len(columns), 1))
    followed = close_velocities(rates, system.body.closures(moved)[1], split)
    return units, (followed - rates).reshape(units.shape) / step


def flight_map(
    system: System, phase: ConstraintSet, panel: Panel, length: float
) -> tuple[FloatArray, FloatArray]:
    """Carries deviations of positions and velocities over the first part of a flight panel.

    Args:
        system: The system.
        phase: The phase.
        panel: The panel.
        length: How much of it belongs to the segment [s].

    Returns:
        Deviations (dq, dv) at the end by those at the start, shape (2 nv, 2 nv); and by dy and dy'
        at the end, shape (2 nv, 2 f).

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
    """
    free = free_coordinates(phase, panel.split)
    end = panel.interpolate(np.array([panel.t + length]))
    q, v = (np.vstack(pair) for pair in zip((panel.q, panel.v), end, strict=True))
    units, turned = tangents(system, q, v, panel.split, free)
    slopes = _slopes(system, phase, panel, free, (units[:, :-1], turned[:, :-1]))
    flat = _variations(slopes, panel.h).reshape(panel.order, -1)
    f, nv = len(free), system.body.nv
    integrals = evaluate_motion(flat, np.array([length / panel.h]))
    twice, once = (integral.reshape(f, 2 * f) for integral in integrals)
    one = np.eye(f)
    found = np.block([[one, length * one], [np.zeros((f, f)), one]])
    found += np.vstack([panel.h**2 * twice, panel.h * once])
    unit, turn = units[:, -1].T, turned[:, -1].T
    lifted = np.block([[unit, np.zeros((nv, f))], [turn, unit]])
    whole = np.zeros((2 * nv, 2 * nv))
    whole[:, [*free, *(nv + k for k in free)]] = lifted @ found
    return whole, lifted


def _slopes(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    free: list[int],
    along: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """A and B at the nodes of a panel, each of shape (N, f, f) [1/s^2, 1/s]."""
    count, f, nv = panel.order, len(free), system.body.nv
    units, turned = along
    x = steps(system, units, free)
    w = x * fastest(system, panel.v)
    aside, hurried = x[:, None, None] * units, w[:, None, None] * units
    still = np.zeros((1, count, nv))
    q = panel.q + np.concatenate([still, aside, 0.0 * units])
    v = panel.v + np.concatenate([still, x[:, None, None] * turned, hurried])
    # One call for all; the forces of the drives are those of the nodes.
    motion = system.shaft.driven(panel.times, panel.middle)
    forcing = np.tile(system.forcing(motion, phase), (2 * f + 1, 1))
    a = system.respond(forcing, q.reshape(-1, nv), v.reshape(-1, nv), phase)
    a = a[:, free].reshape(2 * f + 1, count, f)
    differences = np.moveaxis(a[1:] - a[0], 0, 2)
    return differences[:, :, :f] / x, differences[:, :, f:] / w


def _variations(slopes: tuple[FloatArray, FloatArray], h: float) -> FloatArray:
    """Accelerations of dy at the nodes for unit dy and dy' at the start, shape (N, f, 2 f)."""
    places, rates = slopes
    count, f = places.shape[:2]
    grid = nodes(count)
    matrix = np.eye(count * f).reshape(count, f, count, f)
    matrix -= h**2 * np.einsum("jik,jl->jilk", places, grid.twice)
    matrix -= h * np.einsum("jik,jl->jilk", rates, grid.once)
    later = h * grid.sigma[:, None, None] * places + rates
    right = np.concatenate([places, later], axis=2)
    found = np.linalg.solve(matrix.reshape(count * f, -1), right.reshape(count * f, -1))
    return np.asarray(found.reshape(count, f, 2 * f))
