"""Error of the time of a release, at which the force of a stop falls through zero."""

from __future__ import annotations

import numpy as np

from ...dynamics import ConstraintSet, System, multipliers
from ...tolerances.hybrid import COORDINATE_ROUND_OFF, FORCE_SLOPE_STEP
from ..motion.panel import Panel, forces_at
from .by_part import Part
from .determined import of_closures
from .freedoms import Freedoms, free_coordinates
from .local_error import unsure
from .variational import tangents
from .zonotope import Deviations


def release_error(
    system: System,
    part: Part,
    phase: ConstraintSet,
    panel: Panel,
    t: float,
    deviations: Deviations,
    index: int,
) -> float:
    """Error of the time at which a stop force vanishes: what it is wrong by over its slope.

    Args:
        phase: The phase before.
        panel: The panel on which the force vanishes.
        t: When it does so [s].
        deviations: Those of the motion there.
        index: Coordinate of the stop, a closed one.

    Returns:
        The error [s]; infinite if the force does not fall.
    """
    column, step = phase.stops.index(index), FORCE_SLOPE_STEP * min(panel.h, t - panel.t)
    if step <= 0.0:
        return np.inf
    q, v, _, forces = forces_at(system, phase, panel, np.array([t - step, t]))
    slope = float(forces.la_N[1, column] - forces.la_N[0, column]) / step
    q, v, nv, own = q[1:], v[1:], system.body.nv, part.coordinates
    free = free_coordinates(phase, panel.split) if panel.integrated else []
    along = Freedoms.of_one(system, [k for k in free if k in own], own)
    units, turned = (item[:, 0] for item in tangents(system, q, v, panel.split, along))
    x = along.steps(units[:, None])
    w = x * along.fastest(v)
    # Round-off of one coordinate, then of one rate at a time; then along the freedoms.
    by = unsure(system, panel.split)
    opened = of_closures(system, panel.split, q[0], v[0], by).T[own]
    rounded = np.diag(COORDINATE_ROUND_OFF * np.abs(v[0]))[own]
    places = [opened[:, :nv], 0.0 * rounded, x * units, 0.0 * units]
    rates = [opened[:, nv:], rounded, x * turned, w * units]
    moved, moving = q + np.vstack(places), v + np.vstack(rates)
    _, jacobian = system.body.closures(moved)
    motion = system.shaft.driven(np.full(len(moved), t))
    a = system.accelerations(motion, moved, moving, phase)
    there = multipliers(system, motion, moved, moving, a, jacobian, phase, panel.split)
    changes = there.la_N[:, column] - forces.la_N[1, column]
    wrong = float(np.abs(changes[: 2 * part.size]).sum())
    by_state = changes[2 * part.size :] / np.concatenate([x, w])[:, 0]
    rows = [part.place(k) for k in along.columns]
    rows += [part.size + place for place in rows]
    wrong += float(np.abs(by_state @ deviations.states[rows]).sum())
    return wrong / abs(slope) if slope else np.inf
