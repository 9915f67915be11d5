"""Panels of phases with freedom: Picard iteration on nested collocation grids."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...chebyshev import prolonged
from ...dynamics import ConstraintSet, Partition, System
from ...errors import SimulationError
from ...tolerances.hybrid import ITERATION_FLOOR
from ..case import Resolution
from .panel import Attempt, Begin, Panel, forces_at, judged, shorter
from .sweeps import Sweeps

# Sweeps start on coarse grids, nested in the finest one, and move on when they have gained what
# such a grid can hold; a short flight never needs the finest one.
_COARSE_STRIDES = (4, 2)
_COARSE_SWEEPS = 2
_MAX_SWEEPS = 24
_EASY_SWEEPS = 14
# What a coarse grid foretells of the finest one is an estimate, and has to be so much too large.
_FORESEEN_ROUGH = 8.0
# Growth of panels as long as they do not need the finest grid.
_LONGER = 2.0
# Motion on one panel [rad or m] beyond which inertia could no longer be neglected beside that of a
# held shaft.
_RUN_AWAY = 1e9


def flight_panel(
    system: System,
    phase: ConstraintSet,
    split: Partition,
    begin: Begin,
    h: float,
    resolution: Resolution,
) -> Attempt:
    """Motion of a phase with freedom.

    Args:
        begin: Where it begins; its acceleration is that of the first node.
        h: Length [s].
        resolution: Number of nodes and relative accuracy of the positions.

    Returns:
        The panel with the stop forces, or the advice to try a shorter one.

    Raises:
        SimulationError: A link has run away, as one does that a turning shaft throws outwards.
    """
    finest = resolution.flight_nodes
    nested = resolution.adaptive and (finest - 1) % _COARSE_STRIDES[0] == 0
    tolerance = resolution.tolerance if resolution.adaptive else ITERATION_FLOOR
    if h * h * np.vdot(begin.v, begin.v) > _RUN_AWAY**2:
        raise _run_away(system, h * begin.v)
    sweeps = Sweeps(system, phase, begin, h, finest, tolerance, nested)
    none = np.empty((0, len(phase.stops)))
    a, left_over = _swept(sweeps, begin.a[None], finest, tolerance, nested)
    if a is None:
        return Attempt(None, none, left_over)
    moved = sweeps.motion(a)
    q_nodes, v_nodes = moved[0], moved[1]
    panel = Panel(begin.t, h, q_nodes, v_nodes, a, split, integrated=True)
    forces = forces_at(system, phase, panel, panel.times)[3].la_N if phase.stops else none
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    hard = sweeps.count > _EASY_SWEEPS
    if left_over > tolerance and sweeps.allows_round_off():
        left_over = sweeps.left_over(a)
        if left_over <= tolerance:
            # No shorter panel would resolve it either.
            return Attempt(panel, forces, 1.0 if hard else _LONGER)
    if len(a) < finest and not hard:
        # A coarse grid was enough, and a panel that only just suits it would stay short for ever.
        return Attempt(panel, forces, _LONGER)
    attempt = judged(panel, forces, left_over / tolerance, len(a))
    return attempt._replace(factor=min(attempt.factor, 1.0)) if hard else attempt


def _swept(
    sweeps: Sweeps, a: FloatArray, finest: int, tolerance: float, nested: bool
) -> tuple[FloatArray, float] | tuple[None, float]:
    """Sweep over one grid after the other, until one of them resolves the motion.

    Args:
        a: Acceleration at the first node, shape (1, nv).
        finest: Number of nodes of the finest grid.
        tolerance: Relative accuracy of the positions.
        nested: True if there are coarser grids.

    Returns:
        Accelerations at the nodes and what they leave over; or None and the ratio of the length of
        the next attempt.
    """
    for stride in _COARSE_STRIDES if nested else ():
        a = prolonged(a, (finest - 1) // stride + 1)
        if sweeps.converges(a, stride, _COARSE_SWEEPS) or (
            sweeps.nearly(a) and sweeps.converges(a, stride, 1)
        ):
            left_over = sweeps.left_over(a)
            if left_over <= tolerance:
                return a, left_over
        elif stride == _COARSE_STRIDES[-1]:
            foreseen = sweeps.foreseen(a)
            if foreseen > _FORESEEN_ROUGH * tolerance:
                return None, shorter(foreseen / tolerance, finest)
    a = prolonged(a, finest)
    if not sweeps.converges(a, 1, _MAX_SWEEPS):
        if sweeps.too_rough:
            return None, shorter(sweeps.left_over(a) / tolerance, finest)
        if not (sweeps.allows_round_off() and sweeps.settled):
            return None, 0.5
    return a, sweeps.left_over(a)


def _run_away(system: System, moved: FloatArray) -> SimulationError:
    """The error of a coordinate that moves too far on one panel."""
    fastest = int(np.argmax(np.abs(moved)))
    name = system.mechanism.joints[fastest].name
    message = (
        f"joint {name} runs away: it moves by {abs(moved[fastest]):.2g} (rad or m) in one step "
        "and nothing holds it; give it a stop or a spring, or simulate a shorter time"
    )
    return SimulationError(message, joint=name, moved=float(moved[fastest]))
