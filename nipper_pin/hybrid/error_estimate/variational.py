"""Variational equation: deviations at the end of a panel, linear in those at its start.

The free independent coordinates y of a panel tell the others, q(y) and v(y, y'). Neighbouring
motions differ in them by dy, with

    ddy = A(t) dy + B(t) dy',    A = da/dy at y' held,  B = da/dy',

A and B being differences of accelerations at the nodes. The collocation that integrates the panel
solves this linear equation, too: for the accelerations of dy at the nodes, a small linear system of
each part of the machine.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, Vectors
from ...chebyshev import evaluate_motion, nodes
from ...dynamics import ConstraintSet, Partition, System, close_velocities
from ..motion.panel import Panel
from .freedoms import Freedoms, free_coordinates


def lifts(jacobian: FloatArray, split: Partition, directions: FloatArray) -> FloatArray:
    """Derivatives of all coordinates along independent ones, at N states.

    Args:
        jacobian: Closure Jacobians G, shape (N, m, nv).
        directions: How fast independent coordinates move, shape (C, nv).

    Returns:
        Shape (C, N, nv): one after another.
    """
    shape = len(directions), len(jacobian), jacobian.shape[2]
    units = np.zeros(shape)
    units[:] = directions[:, None]
    repeated = np.tile(jacobian, (len(directions), 1, 1))
    return close_velocities(units.reshape(-1, shape[2]), repeated, split).reshape(shape)


def tangents(
    system: System, q: Vectors, v: Vectors, split: Partition, along: Freedoms
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of all coordinates and rates along freedoms, at N states.

    Args:
        along: Independent coordinates that count, moved in C directions.

    Returns:
        dq/dy = dv/dy' and dv/dy at independent rates held, shapes (C, N, nv).
    """
    units = lifts(system.body.closures(q)[1], split, along.directions)
    step = along.spread(along.steps(units))
    moved = (q + step * units).reshape(-1, q.shape[1])
    rates = np.tile(v, (len(units), 1))
    followed = close_velocities(rates, system.body.closures(moved)[1], split)
    # No coordinate of a part without freedom moves.
    return units, (followed - rates).reshape(units.shape) / np.where(step > 0.0, step, 1.0)


def flight_map(
    system: System, phase: ConstraintSet, panel: Panel, length: float
) -> tuple[FloatArray, FloatArray]:
    """Carries deviations of a state over the first part of a flight panel, of a length [s].

    Returns:
        Deviations (dq, dv) at the end by those at the start, shape (2 nv, 2 nv); and by dy and dy'
        at the end, shape (2 nv, 2 f), in the order of the free coordinates. Neither has anything
        where one part of the machine would move another one.

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
    """
    along = Freedoms.of(system, free_coordinates(phase, panel.split))
    end = panel.interpolate(np.array([panel.t + length]))
    q, v = (np.vstack(pair) for pair in zip((panel.q, panel.v), end, strict=True))
    units, turned = tangents(system, q, v, panel.split, along)
    changes = _Changes.of(system, phase, panel, along, (units[:, :-1], turned[:, :-1]))
    found = _propagated(changes, panel, length, along)
    f, nv, each = len(along.columns), system.body.nv, list(along.direction)
    unit, turn = (np.where(along.own, part[each, -1].T, 0.0) for part in (units, turned))
    lifted = np.block([[unit, np.zeros((nv, f))], [turn, unit]])
    whole = np.zeros((2 * nv, 2 * nv))
    whole[:, [*along.columns, *(nv + k for k in along.columns)]] = lifted @ found
    return whole, lifted


class _Changes(NamedTuple):
    """Accelerations at the nodes of a panel beside those of the motion.

    Attributes:
        by_places: Along each direction at its places, shape (N, nv, C).
        by_rates: At its rates, shape (N, nv, C).
        aside: How far aside the places are, in each part, shape (C, parts).
        faster: How much the rates differ, in each part, shape (C, parts).
    """

    by_places: FloatArray
    by_rates: FloatArray
    aside: FloatArray
    faster: FloatArray

    @classmethod
    def of(
        cls,
        system: System,
        phase: ConstraintSet,
        panel: Panel,
        along: Freedoms,
        tangent: tuple[FloatArray, FloatArray],
    ) -> _Changes:
        """Beside the motion of a panel, with what :func:`tangents` gives at its nodes."""
        units, turned = tangent
        count, nv, nodes_of = len(units), system.body.nv, panel.order
        x = along.steps(units)
        w = x * along.fastest(panel.v)
        still = np.zeros((1, nodes_of, nv))
        q = panel.q + np.concatenate([still, along.spread(x) * units, 0.0 * units])
        v = panel.v + np.concatenate([still, along.spread(x) * turned, along.spread(w) * units])
        # One call for all; the forces of the drives are those of the nodes.
        motion = system.shaft.driven(panel.times, panel.middle)
        forcing = np.tile(system.forcing(motion, phase), (2 * count + 1, 1))
        a = system.respond(forcing, q.reshape(-1, nv), v.reshape(-1, nv), phase)
        a = a.reshape(2 * count + 1, nodes_of, nv)
        differences = np.moveaxis(a[1:] - a[0], 0, 2)
        return cls(differences[:, :, :count], differences[:, :, count:], x, w)

    def slopes(
        self, parts: NDArray[np.intp], free: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray]:
        """A and B of parts with f free coordinates each, (P, f): (P, N, f, f) [1/s^2, 1/s]."""
        f = free.shape[1]
        places = self.by_places[:, free, :f] / self.aside[:f, parts].T[:, None]
        rates = self.by_rates[:, free, :f] / self.faster[:f, parts].T[:, None]
        return np.moveaxis(places, 1, 0), np.moveaxis(rates, 1, 0)


def _propagated(changes: _Changes, panel: Panel, length: float, along: Freedoms) -> FloatArray:
    """Deviations dy, dy' after a length [s] by those at the start of a panel, (2 f, 2 f)."""
    count, columns = len(along.columns), np.array(along.columns, dtype=np.intp)
    whole = np.zeros((2 * count, 2 * count))
    for parts, places in along.alike():
        number, f = places.shape
        slopes = changes.slopes(parts, columns[places])
        flat = np.moveaxis(_variations(slopes, panel.h), 1, 0).reshape(panel.order, -1)
        integrals = evaluate_motion(flat, np.array([length / panel.h]))
        twice, once = (integral.reshape(number, f, 2 * f) for integral in integrals)
        one = np.eye(f)
        found = np.block([[one, length * one], [np.zeros((f, f)), one]])
        found = found + np.concatenate([panel.h**2 * twice, panel.h * once], axis=1)
        rows = np.concatenate([places, count + places], axis=1)
        whole[rows[:, :, None], rows[:, None]] = found
    return whole


def _variations(slopes: tuple[FloatArray, FloatArray], h: float) -> FloatArray:
    """Accelerations of dy at the nodes for unit dy and dy' at the start, (P, N, f, 2 f)."""
    places, rates = slopes
    number, count, f = places.shape[:3]
    grid = nodes(count)
    matrix = np.eye(count * f).reshape(count, f, count, f)
    matrix = matrix - h**2 * np.einsum("pjik,jl->pjilk", places, grid.twice)
    matrix -= h * np.einsum("pjik,jl->pjilk", rates, grid.once)
    later = h * grid.sigma[:, None, None] * places + rates
    right = np.concatenate([places, later], axis=3).reshape(number, count * f, -1)
    found = np.linalg.solve(matrix.reshape(number, count * f, -1), right)
    return np.asarray(found.reshape(number, count, f, 2 * f))
