"""Panels of phases without freedom: the drives determine the motion, node by node."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition, close_positions, close_velocities
from ..dynamics.multipliers import multipliers
from ..dynamics.system import ConstraintSet, System
from .case import Resolution
from .collocation import nodes, tail
from .panel import SMALLEST, Attempt, Panel, judged

_ROUND_OFF = 1e-15


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
    motion = system.shaft.driven(times)
    system.prescribe(motion, guess, rates, rows)
    q_nodes, jacobian = close_positions(system.body, guess, split)
    v_nodes = close_velocities(rates, jacobian, split)
    a_nodes = system.accelerations(motion, q_nodes, v_nodes, rows)
    forces = multipliers(system, q_nodes, v_nodes, a_nodes, jacobian, rows, split).la_N
    panel = Panel(t, h, q_nodes, v_nodes, a_nodes, split, integrated=False)
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    moving = np.abs(h * v_nodes).max(axis=0)
    rough = tail(q_nodes) / (resolution.tolerance * moving + _ROUND_OFF)
    # Stop forces are second derivatives: they are resolved less far than positions, and their
    # roots are polished on the exact motion.
    size = np.abs(forces).max(axis=0) + SMALLEST
    rough_force = tail(forces) / (np.sqrt(resolution.tolerance) * size)
    excess = float(max(rough.max(initial=0.0), rough_force.max(initial=0.0)))
    return judged(panel, forces, excess, resolution.kinematic_nodes)
