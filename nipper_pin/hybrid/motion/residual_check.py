"""Checks of a panel beyond its nodes, which the force elements of a machine need.

The nodes of a panel resolve motion that is smooth. Force elements may do something between two
nodes: each kind of element that a machine has brings the check that looks for it, and a machine
without such elements has none.

A force that changes within a narrow step or spike, and changes back before the next node, leaves no
trace in the nodes; of a step that stays they show the height, not the place. So the equations of
motion are asked for where a coordinate crosses a row of its table and where it turns back, and with
struts, whose points may pass one another closely, between any two nodes.

Closer still, the line of a damper turns by half a turn in no time. Its force falls to zero there
and is afterwards what it was before: a pass that lies between two nodes is looked for itself.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...chebyshev import nodes
from ...dynamics import ConstraintSet, Elements, System
from ...tolerances.hybrid import ROUND_OFF_SAFETY, SMALLEST
from .noise_floor import roughness
from .panel import Panel, defect, nearby

_NEWTON_STEPS = 3
# Cosine of the angle by which a damper may turn from one node to the next.
_TURN = 0.5
# Share of the way between two nodes in which they do not see what happens.
_NARROW = 0.1


def shows_turns(elements: Elements, panel: Panel, tolerance: float) -> bool:
    """True if the nodes of a panel show how its dampers turn."""
    lines = elements.damper_lines(panel.q)
    if not lines.size:
        return True
    before, after = lines[:-1], lines[1:]
    if _hidden(before, after, tolerance).any():
        return False
    turned = np.argwhere(_turned(before, after))
    sigma = nodes(panel.order).sigma
    return all(
        _in_line(elements, panel, int(damper), float(sigma[node]), float(sigma[node + 1]))
        for node, damper in turned
    )


def _turned(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return whether lines (x, z) turn by too much for one interval, shape (...)."""
    along = np.einsum("...i,...i->...", before, after)
    sizes = np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1)
    return np.asarray(along < _TURN * sizes)


def _hidden(before: FloatArray, after: FloatArray, tolerance: float) -> FloatArray:
    """Return whether short lines (x, z) beside a node may turn unresolved, shape (...).

    A line of length d turns by delta within a way of about d. For so long the damper lacks a share
    sin^2 delta of its force, and its impulse that of d beside the whole way of the interval.
    """
    first, second = np.linalg.norm(before, axis=-1), np.linalg.norm(after, axis=-1)
    way, shorter = np.linalg.norm(after - before, axis=-1), np.minimum(first, second)
    across = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
    lacking = shorter * across**2 > tolerance * way * (first * second) ** 2
    return np.asarray((shorter < _NARROW * way) & lacking)


def _in_line(elements: Elements, panel: Panel, damper: int, left: float, right: float) -> bool:
    """True if the points of a damper that turns meet on the way, which needs no direction.

    The turn is halved until it is either spread over both halves or in a length that is none. The
    chord does not tell: it may meet the point that the arc over it passes by.
    """
    while True:
        sigma = np.array([left, 0.5 * (left + right), right])
        q, _ = panel.interpolate(panel.t + panel.h * sigma)
        lines = elements.damper_lines(q)[:, damper]
        if np.linalg.norm(lines[1]) <= elements.coincident_m:
            return True
        first, second = _turned(lines[:-1], lines[1:])
        if first == second or not left < sigma[1] < right:
            return False
        left, right = (left, float(sigma[1])) if first else (float(sigma[1]), right)


def shows_forces(system: System, phase: ConstraintSet, panel: Panel, tolerance: float) -> bool:
    """True if a flight panel obeys its equations between its nodes, as far as forces ask for it."""
    sigma = rows_met(system, panel)
    if system.mechanism.struts:
        sigma = np.concatenate([sigma, nodes(panel.order).between])
    return not sigma.size or _obeys(system, phase, panel, tolerance, sigma)


def shows_end(
    system: System, phase: ConstraintSet, panel: Panel, tolerance: float, t_end: float
) -> bool:
    """True if a flight panel obeys its equations where an event ends it, at t_end [s].

    Points of a strut may be at one place where a stop closes, and only there.
    """
    if not system.mechanism.struts:
        return True
    return _obeys(system, phase, panel, tolerance, np.array([(t_end - panel.t) / panel.h]))


def _obeys(
    system: System, phase: ConstraintSet, panel: Panel, tolerance: float, sigma: FloatArray
) -> bool:
    """True if the dynamics at places of a panel differ from it by no more than it may leave."""
    off = phase.moving * defect(system, phase, panel, sigma)
    # What the closures determine follows from the others; where its mass is small beside theirs,
    # its acceleration is round-off of a large force.
    off[:, panel.split.columns] = 0.0
    moved = np.abs(panel.h * panel.v[0]) + panel.h**2 * np.abs(panel.a).max(axis=0) + SMALLEST
    # Two integrations divide what the interpolant misses by about (2 N)^2.
    most = (2.0 * panel.order) ** 2 * tolerance * moved / panel.h**2
    if (off <= most).all():
        return True
    return bool((off <= most + _round_off(system, phase, panel, sigma)).all())


def _round_off(system: System, phase: ConstraintSet, panel: Panel, sigma: FloatArray) -> FloatArray:
    """Round-off of the accelerations at some places of a panel, shape (K, nv)."""
    t = panel.t + panel.h * sigma
    q, v = panel.interpolate(t)
    motion = system.shaft.driven(t, panel.middle)
    there = system.accelerations(motion, q, v, phase)
    close = system.accelerations(motion, *nearby(system, q, v, panel.split), phase)
    # Of a body that hardly leaves another one the difference of two large accelerations is left.
    of_forces = roughness(system, phase, panel.t, panel.q[0], panel.v[0])
    return np.asarray(ROUND_OFF_SAFETY * np.maximum(np.abs(close - there), of_forces))


def rows_met(system: System, panel: Panel) -> FloatArray:
    """Places sigma on a panel at which coordinates of tables cross a row or turn, shape (K,)."""
    if not system.mechanism.knots:
        return np.empty(0)
    samples = nodes(panel.order).samples
    q, v = panel.interpolate(panel.t + panel.h * samples)
    found = []
    for index, rows in system.mechanism.knots:
        x, rate = q[:, index], v[:, index]
        found.append(_crossed(samples, rate))
        for row in rows:
            sigma = _crossed(samples, x - row)
            for _ in range(_NEWTON_STEPS if sigma.size else 0):
                there, speed = panel.interpolate(panel.t + panel.h * sigma)
                slope = panel.h * speed[:, index]
                step = np.divide(there[:, index] - row, slope, where=slope != 0.0,
                                 out=np.zeros_like(sigma))  # fmt: skip
                sigma = np.clip(sigma - step, 0.0, 1.0)
            found.append(sigma)
    return np.concatenate(found)


def _crossed(samples: FloatArray, values: FloatArray) -> FloatArray:
    """Places at which sampled values change their sign, by the chord."""
    left, right = values[:-1], values[1:]
    place = np.flatnonzero(left * right < 0.0)
    part = left[place] / (left[place] - right[place])
    return np.asarray(samples[place] + part * (samples[place + 1] - samples[place]))


def shows_elements(system: System, phase: ConstraintSet, panel: Panel, tolerance: float) -> bool:
    """True if the nodes of a panel show what force elements do on it; else it is made shorter.

    Forces beyond the rows of a table bend the motion to its start, however early the event is that
    ends it.
    """
    elements = system.elements
    return elements is None or (
        not elements.runs_off(panel.q)
        and shows_turns(elements, panel, tolerance)
        and (not panel.integrated or shows_forces(system, phase, panel, tolerance))
    )


def need_described(system: System, panel: Panel, t_end: float) -> None:
    """Refuse a motion up to t_end [s] that no element describes; no node may show it.

    Raises:
        ElementError: It leaves a table, or a force law, which may be a user's, takes heat for work.
    """
    elements = system.elements
    if elements is None:
        return
    if system.mechanism.tabulated_springs:
        times = panel.t + panel.h * nodes(panel.order).samples
        times = np.append(times[times < t_end], min(t_end, panel.t + panel.h))
        elements.check(panel.interpolate(times)[0], times)
    before = panel.times <= t_end
    elements.check_heat(panel.q[before], panel.v[before], panel.times[before])
