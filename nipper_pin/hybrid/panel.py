"""One panel of motion: solved by collocation, or pure kinematics where no freedom is left."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition, close_positions, close_velocities
from ..dynamics.multipliers import Multipliers, multipliers
from ..dynamics.system import ConstraintSet, System
from .case import Resolution
from .collocation import evaluate, nodes, prolonged, tail

_MAX_SWEEPS = 24
# The error of sweep k behaves like (L h)^k / k!, so the first sweeps may gain little.
_FREE_SWEEPS = 4
_EASY_SWEEPS = 14
# Sweeps start on coarse grids and move on when what is left to gain is below their resolution; a
# short flight never needs the finest one.
_STRIDES = (4, 2, 1)
_COARSE = 0.1
# A sweep of Picard's iteration that gains less than this shows a panel too long for it.
_WORST_CONTRACTION = 0.5
_ROUND_OFF = 1e-15
_SMALLEST = 1e-300
# Below this relative change only round-off is left in the iteration.
_ITERATION_FLOOR = 1e3 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Attempt:
    """A panel, or why there is none, and the length that the next attempt should have.

    Attributes:
        panel: The panel; None if the nodes do not resolve it.
        forces: Stop forces at its nodes, shape (N, closed).
        factor: Ratio of the advised next length to this one.
    """

    panel: Panel | None
    forces: FloatArray
    factor: float


@dataclass(frozen=True)
class Panel:
    """Motion over [t, t + h] at its collocation nodes.

    Attributes:
        t: Start [s].
        h: Length [s].
        q: Configurations at the nodes, shape (N, nv).
        v: Velocities at the nodes, shape (N, nv).
        a: Accelerations at the nodes, shape (N, nv).
        split: Dependent and independent coordinates.
        integrated: True if the free coordinates are integrals of ``a`` from the first node; False
            if all follow from the drives, node by node.
    """

    t: float
    h: float
    q: FloatArray
    v: FloatArray
    a: FloatArray
    split: Partition
    integrated: bool

    @property
    def order(self) -> int:
        """Number of nodes."""
        return len(self.q)

    @property
    def times(self) -> FloatArray:
        """Times of the nodes [s], shape (N,)."""
        return self.t + self.h * nodes(self.order).sigma

    def shifted(self, delay: float) -> Panel:
        """Return the same motion at a later time."""
        return replace(self, t=self.t + delay)

    def interpolate(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities at times t, before the closures are met exactly.

        Args:
            t: Times within the panel, shape (K,) [s].

        Returns:
            q and v, shape (K, nv).
        """
        sigma = (t - self.t) / self.h
        if not self.integrated:
            return evaluate(self.q, sigma, 0), evaluate(self.v, sigma, 0)
        h = self.h
        q = self.q[0] + h * sigma[:, None] * self.v[0] + h**2 * evaluate(self.a, sigma, 2)
        return q, self.v[0] + h * evaluate(self.a, sigma, 1)


def state_at(
    system: System, rows: ConstraintSet, panel: Panel, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Exact states on a panel: prescribed motion and closures are met to round-off.

    Args:
        system: The system.
        rows: The phase.
        panel: The panel.
        t: Times within it, shape (K,) [s].

    Returns:
        q, v of shape (K, nv) and the closure Jacobian, shape (K, m, nv).
    """
    q, v = panel.interpolate(t)
    system.prescribe(t, q, v, rows)
    q, jacobian = close_positions(system.body, q, panel.split)
    return q, close_velocities(v, jacobian, panel.split), jacobian


def forces_at(
    system: System,
    rows: ConstraintSet,
    panel: Panel,
    t: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, Multipliers]:
    """Exact states with accelerations and forces of constraint; arguments as :func:`state_at`.

    Returns:
        q, v, a of shape (K, nv) and the forces of constraint.
    """
    q, v, jacobian = state_at(system, rows, panel, t)
    a = system.accelerations(system.shaft.driven(t), q, v, rows)
    return q, v, a, multipliers(system, q, v, a, jacobian, rows, panel.split)


def kinematic_panel(
    system: System,
    rows: ConstraintSet,
    split: Partition,
    t: float,
    h: float,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    resolution: Resolution,
) -> Attempt:
    """Motion of a phase without freedom, where the drives determine everything.

    Args:
        system: The system.
        rows: The phase.
        split: Dependent and independent coordinates.
        t: Start [s].
        h: Length [s].
        q: Configuration at the start, shape (nv,); with v and a the guess for the nodes.
        v: Velocity there.
        a: Acceleration there.
        resolution: Number of nodes, and what they may leave unresolved.

    Returns:
        The panel with the stop forces, or the advice to try a shorter one.
    """
    grid = nodes(resolution.kinematic_nodes)
    tau = (h * grid.sigma)[:, None]
    guess = q + tau * v + 0.5 * tau**2 * a
    times = t + h * grid.sigma
    rates = np.repeat(v[None], len(times), axis=0)
    system.prescribe(times, guess, rates, rows)
    q_nodes, jacobian = close_positions(system.body, guess, split)
    v_nodes = close_velocities(rates, jacobian, split)
    a_nodes = system.accelerations(system.shaft.driven(times), q_nodes, v_nodes, rows)
    forces = multipliers(system, q_nodes, v_nodes, a_nodes, jacobian, rows, split).la_N
    panel = Panel(t, h, q_nodes, v_nodes, a_nodes, split, integrated=False)
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    moving = np.abs(h * v_nodes).max(axis=0)
    rough = tail(q_nodes) / (resolution.tolerance * moving + _ROUND_OFF)
    # Stop forces are second derivatives: they are resolved less far than positions, and their
    # roots are polished on the exact motion.
    size = np.abs(forces).max(axis=0) + _SMALLEST
    rough_force = tail(forces) / (np.sqrt(resolution.tolerance) * size)
    excess = float(max(rough.max(initial=0.0), rough_force.max(initial=0.0)))
    return _judged(panel, forces, excess, resolution.kinematic_nodes)


def _judged(panel: Panel, forces: FloatArray, excess: float, order: int) -> Attempt:
    """Accept a panel whose unresolved part is at most 1 in units of the tolerance."""
    factor = 0.9 * max(excess, _SMALLEST) ** (-1.0 / order)
    factor = min(max(factor, 0.2), 2.0)
    if excess <= 1.0:
        return Attempt(panel, forces, factor)
    return Attempt(None, forces, min(factor, 0.7))


def flight_panel(
    system: System,
    rows: ConstraintSet,
    split: Partition,
    t: float,
    h: float,
    q: FloatArray,
    v: FloatArray,
    start: FloatArray,
    resolution: Resolution,
) -> Attempt:
    """Motion of a phase with freedom, by Picard iteration on the collocation nodes.

    Args:
        system: The system.
        rows: The phase.
        split: Dependent and independent coordinates.
        t: Start [s].
        h: Length [s].
        q: Closed configuration at the start, shape (nv,).
        v: Closed velocity at the start, shape (nv,).
        start: Acceleration there, shape (nv,); the one node that is known beforehand.
        resolution: Number of nodes and relative accuracy of the positions.

    Returns:
        The panel, or the advice to try a shorter one.
    """
    finest = resolution.flight_nodes
    nested = resolution.adaptive and (finest - 1) % _STRIDES[0] == 0
    tolerance = resolution.tolerance if resolution.adaptive else _ITERATION_FLOOR
    none = np.empty((0, len(rows.stops)))
    all_times = t + h * nodes(finest).sigma
    all_motion = system.shaft.driven(all_times)
    a = start[None]
    sweeps = 0
    for stride in _STRIDES if nested else (1,):
        last = stride == 1
        times = all_times[::stride]
        count = len(times)
        motion = (all_motion[0][::stride], all_motion[1][::stride], all_motion[2][::stride])
        rest = (motion[0][1:], motion[1][1:], motion[2][1:])
        straight = q + (times - t)[:, None] * v
        a = prolonged(a, count)
        change = np.inf
        while True:
            q_nodes, v_nodes = _integrated(system, motion, straight, v, h, a)
            new = system.accelerations(rest, q_nodes[1:], v_nodes[1:], rows)
            scale = np.abs(h * v) + h**2 * np.abs(new).max(axis=0) + _SMALLEST
            previous, change = change, float((h**2 * np.abs(new - a[1:]) / scale).max())
            a[1:] = new
            sweeps += 1
            # Two integrations divide the coefficient of degree k by about (2 k)^2.
            left_over = h**2 * tail(a) / (2.0 * count) ** 2
            excess = float((left_over / (tolerance * scale)).max())
            if change <= tolerance or (not last and change <= _COARSE * tolerance * excess):
                break
            if sweeps > _FREE_SWEEPS and change > _WORST_CONTRACTION * previous:
                if change <= _ITERATION_FLOOR:
                    break
                return Attempt(None, none, 0.5)
            if sweeps >= _MAX_SWEEPS:
                return Attempt(None, none, 0.5)
        if excess <= 1.0 and change <= max(tolerance, _ITERATION_FLOOR):
            break
    q_nodes, v_nodes = _integrated(system, motion, straight, v, h, a)
    panel = Panel(t, h, q_nodes, v_nodes, a, split, integrated=True)
    forces = forces_at(system, rows, panel, times)[3].la_N if rows.stops else none
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    attempt = _judged(panel, forces, excess, count)
    return attempt if sweeps <= _EASY_SWEEPS else replace(attempt, factor=min(attempt.factor, 1.0))


def _integrated(
    system: System,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    straight: FloatArray,
    v: FloatArray,
    h: float,
    a: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Positions and velocities at the nodes that belong to accelerations there."""
    grid = nodes(len(a))
    q_nodes = straight + h**2 * (grid.twice @ a)
    v_nodes = v + h * (grid.once @ a)
    if system.held:
        q_nodes[:, system.driven], v_nodes[:, system.driven] = motion[0], motion[1]
    return q_nodes, v_nodes
