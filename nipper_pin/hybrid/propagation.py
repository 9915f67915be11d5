"""How a small error at the start of a flight has grown at its end: the variational equation.

A flight with one freedom has one direction n(t) in which configurations may differ, scaled to 1 in
the gap x of a stop. Neighbouring flights differ by dx, with

    ddx = A(t) dx + B(t) dx',    A = da/dx at x' held,  B = da/dx',

A and B being differences of accelerations at the nodes. Its fundamental matrix over the flight
carries (dx, dx') from start to end; (1, T; 0, 1) for a ballistic one of length T.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..dynamics.system import ConstraintSet, System
from .collocation import evaluate
from .panel import Panel
from .segment import Segment

# Flights of more panels swing to and fro; what they lose is no matter of one linear map.
_MOST_PANELS = 64
_SUBSTEPS = 16
# Steps of the differences, as a share of a radian or metre and of the largest rate.
_STEP = 1e-6


def fundamental_matrix(
    system: System, rows: ConstraintSet, segment: Segment, index: int
) -> tuple[FloatArray, FloatArray] | None:
    """Carries errors of a gap and of its rate from the start of a flight to its end.

    Args:
        system: The system.
        rows: The phase.
        segment: The flight.
        index: Coordinate of the stop that counts.

    Returns:
        The matrix, shape (2, 2), and n at the start, shape (nv,); None for a phase with another
        number of freedoms, a very long one, or one in which the coordinate does not determine the
        others.
    """
    if rows.freedom != 1 or len(segment.panels) > _MOST_PANELS:
        return None
    whole, start = np.eye(2), np.empty(0)
    for panel in segment.panels:
        found = _slopes(system, rows, panel, index)
        if found is None:
            return None
        slopes, direction = found
        if not start.size:
            start = direction
        length = min(panel.t + panel.h, segment.t_end) - panel.t
        whole = _solved(slopes, panel.h, length) @ whole
    return whole, start


def _slopes(
    system: System, rows: ConstraintSet, panel: Panel, index: int
) -> tuple[FloatArray, FloatArray] | None:
    """A and B at the nodes of a panel, shape (N, 2) [1/s^2, 1/s], and n at its start, (nv,)."""
    held = {*system.held_coordinates, *rows.stops, index}
    others = [column for column in range(system.body.nv) if column not in held]
    motion = system.shaft.driven(panel.times)

    def closed(q: FloatArray, v: FloatArray) -> FloatArray:
        _, jacobian = system.body.closures(q)
        found = v.copy()
        found[:, others] = 0.0
        left = jacobian @ found[:, :, None]
        found[:, others] = -np.linalg.solve(jacobian[:, :, others], left)[:, :, 0]
        return found

    try:
        tangent = np.zeros_like(panel.q)
        tangent[:, index] = 1.0
        tangent = closed(panel.q, tangent)
        x = _STEP / float(np.abs(tangent).max())
        w = x * max(float(np.abs(panel.v).max()), 1e-300)
        here = system.accelerations(motion, panel.q, closed(panel.q, panel.v), rows)[:, index]
        aside = panel.q + x * tangent
        moved = system.accelerations(motion, aside, closed(aside, panel.v), rows)[:, index]
        faster = panel.v + w * tangent
        hurried = system.accelerations(motion, panel.q, closed(panel.q, faster), rows)[:, index]
    except np.linalg.LinAlgError:
        return None
    slopes = np.column_stack([(moved - here) / x, (hurried - here) / w])
    return (slopes, tangent[0]) if np.isfinite(slopes).all() else None


def _solved(slopes: FloatArray, h: float, length: float) -> FloatArray:
    """Fundamental matrix over the first part of a panel, by RK4 steps."""
    places = np.linspace(0.0, length / h, 2 * _SUBSTEPS + 1)
    matrices = np.zeros((len(places), 2, 2))
    matrices[:, 0, 1] = 1.0
    matrices[:, 1] = evaluate(slopes, places, 0)
    step, found = length / _SUBSTEPS, np.eye(2)
    for left, middle, right in zip(matrices[:-1:2], matrices[1::2], matrices[2::2], strict=True):
        k1 = left @ found
        k2 = middle @ (found + 0.5 * step * k1)
        k3 = middle @ (found + 0.5 * step * k2)
        k4 = right @ (found + step * k3)
        found = found + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    return np.asarray(found)
