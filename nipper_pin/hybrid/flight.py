"""Panels of phases with freedom: Picard iteration on nested collocation grids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition
from ..dynamics.shaft import Driven
from ..dynamics.system import ConstraintSet, System
from .case import Resolution
from .collocation import nodes, prolonged, tail
from .panel import SMALLEST, Attempt, Panel, forces_at, judged

# Sweeps start on coarse grids, nested in the finest one, and move on when they have gained what
# such a grid can hold; a short flight never needs the finest one.
_STRIDES = (4, 2, 1)
_COARSE_SWEEPS = 3
_MAX_SWEEPS = 24
_EASY_SWEEPS = 14
# The error of sweep k behaves like (L h)^k / k!, so the first sweeps may gain little; later ones
# that gain less than this show a panel too long for the iteration.
_FREE_SWEEPS = 4
_WORST_CONTRACTION = 0.5
# Below this relative change only round-off is left in the iteration.
_ITERATION_FLOOR = 1e3 * float(np.finfo(float).eps)


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
    """Motion of a phase with freedom.

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
        The panel with the stop forces, or the advice to try a shorter one.
    """
    finest = resolution.flight_nodes
    nested = resolution.adaptive and (finest - 1) % _STRIDES[0] == 0
    tolerance = resolution.tolerance if resolution.adaptive else _ITERATION_FLOOR
    times = t + h * nodes(finest).sigma
    driven = system.shaft.driven(times)
    q_line, v_line = _lines(system, driven, h, q, v)
    reach = np.abs(h * v) + SMALLEST
    none = np.empty((0, len(rows.stops)))
    a = start[None]
    sweeps = 0
    for stride in _STRIDES if nested else (1,):
        motion = (driven[0][::stride], driven[1][::stride], driven[2][::stride])
        a = prolonged(a, len(motion[0]))
        most = _MAX_SWEEPS if stride == 1 else _COARSE_SWEEPS
        lines = (q_line[::stride], v_line[::stride])
        used, converged = _iterate(system, rows, motion, lines, reach, h, a, tolerance, most)
        sweeps += used
        if stride == 1 and not converged:
            return Attempt(None, none, 0.5)
        # Two integrations divide the coefficient of degree k by about (2 k)^2.
        left_over = h**2 * tail(a) / (2.0 * len(a)) ** 2
        scale = reach + h**2 * np.abs(a).max(axis=0)
        excess = float((left_over / (tolerance * scale)).max())
        if converged and excess <= 1.0:
            break
    moving = a * system.free
    grid = nodes(len(a))
    q_nodes = lines[0] + h**2 * (grid.twice @ moving)
    v_nodes = lines[1] + h * (grid.once @ moving)
    panel = Panel(t, h, q_nodes, v_nodes, a, split, integrated=True)
    forces = forces_at(system, rows, panel, panel.times)[3].la_N if rows.stops else none
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    attempt = judged(panel, forces, excess, len(a))
    return attempt if sweeps <= _EASY_SWEEPS else replace(attempt, factor=min(attempt.factor, 1.0))


def _iterate(
    system: System,
    rows: ConstraintSet,
    motion: Driven,
    lines: tuple[FloatArray, FloatArray],
    reach: FloatArray,
    h: float,
    a: FloatArray,
    tolerance: float,
    most: int,
) -> tuple[int, bool]:
    """Sweep over one grid, in place, until the accelerations stand still.

    Args:
        system: The system.
        rows: The phase.
        motion: Driven coordinates at the nodes.
        lines: Positions and velocities at the nodes without acceleration, shape (N, nv).
        reach: Travel of each coordinate at its rate at the start, shape (nv,).
        h: Length of the panel [s].
        a: Accelerations at the nodes, shape (N, nv), the first one exact.
        tolerance: Relative change of the positions that ends the iteration.
        most: Largest number of sweeps.

    Returns:
        Sweeps used, and whether they converged.
    """
    grid = nodes(len(a))
    once, twice = h * grid.once[1:], h**2 * grid.twice[1:]
    q_line, v_line = lines[0][1:], lines[1][1:]
    motion = (motion[0][1:], motion[1][1:], motion[2][1:])
    weight: FloatArray | None = None
    change = np.inf
    for sweep in range(1, most + 1):
        moving = a * system.free
        new = system.accelerations(motion, q_line + twice @ moving, v_line + once @ moving, rows)
        if weight is None:
            weight = h**2 / (reach + h**2 * np.abs(new).max(axis=0))
        previous, change = change, float((np.abs(new - a[1:]) * weight).max())
        a[1:] = new
        if change <= tolerance:
            return sweep, True
        if sweep > _FREE_SWEEPS and change > _WORST_CONTRACTION * previous:
            return sweep, change <= _ITERATION_FLOOR
    return most, False


def _lines(
    system: System, motion: Driven, h: float, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Motion at the nodes without acceleration; held drives have theirs, exactly."""
    sigma = nodes(len(motion[0])).sigma
    q_line = q + (h * sigma)[:, None] * v
    v_line = np.repeat(v[None], len(sigma), axis=0)
    if system.held:
        q_line[:, system.driven], v_line[:, system.driven] = motion[0], motion[1]
    return q_line, v_line
