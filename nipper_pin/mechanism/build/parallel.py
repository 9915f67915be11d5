"""Stops that close together: closures and couplings tie their joints, so one freedom has them all.

The jaws that one rack moves, or the cranks of a parallelogram, may have a stop each, met at one
time. Each of these could hold the others alone, so one of them, the leader, is followed for all.
They are found by following the machine to where the leader is closed: there, and nearby, wherever
the leader's gap is zero the other's has to be zero, and both gaps have to grow together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from ...tolerances.hybrid import GAP_ROUND_OFF
from ...tolerances.mechanics import RANK_TOLERANCE
from ..parts import Stop
from .touch_checks import Constraints, Loops

# Steps from the touch configuration to a closed stop, and of Newton's method in each.
_STEPS, _ITERATIONS = 12, 20
# How far the neighbours lie at which freedoms that are left must not open the other stop, and a
# step of Newton's method that leads nowhere [rad, or units].
_NEARBY, _FAR = 0.05, 100.0


def with_leaders(held: Constraints) -> Constraints:
    """The same with stops that know their leader, of those that close with another.

    Of stops that close together the one with the largest restitution leads: by Newton's law it
    alone is struck where coefficients differ.
    """
    stops = held.stops
    if len(stops) < 2:
        return held
    motions = _motions(held.jacobian)
    rows = {stop.name: stop.sense * motions[stop.index] for stop in stops}
    found: dict[str, Stop] = {}
    for stop in sorted(stops, key=lambda item: -item.restitution):
        found[stop.name] = stop
        for leader in found.values():
            if leader is stop or leader.leader or leader.law != stop.law:
                continue
            if not _alike(rows[leader.name], rows[stop.name]):
                continue
            ratio = _ratio(held.loops, leader, stop)
            if ratio is not None:
                found[stop.name] = replace(stop, leader=leader.name, ratio=ratio)
                break
    return held._replace(stops=tuple(found[stop.name] for stop in stops))


def _motions(jacobian: FloatArray) -> FloatArray:
    """Motions that closures and couplings leave, as columns of length one, shape (nv, free)."""
    rows = len(jacobian)
    motions: FloatArray = np.linalg.svd(jacobian)[2][rows:].T if rows else np.eye(jacobian.shape[1])
    return motions


def _alike(one: FloatArray, other: FloatArray) -> bool:
    """Whether two gaps grow together, by their rates in each motion."""
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return size > 0.0 and float(one @ other) > (1.0 - RANK_TOLERANCE) * size


def _ratio(loops: Loops, leader: Stop, stop: Stop) -> float | None:
    """Rate of the gap of a stop by that of its leader; None if they do not close together."""
    x = np.zeros(len(loops.units))
    for step in range(1, _STEPS + 1):
        closed = _closed(loops, x, leader, step / _STEPS)
        if closed is None:
            return None
        x = closed
    ratio = _ratio_at(loops, x, leader, stop)
    if ratio is None:
        return None
    rows = np.vstack([loops.rows(x)[1], np.eye(len(x))[leader.index]])
    for motion in _motions(rows).T:
        nearby = _closed(loops, x + _NEARBY * motion, leader, 1.0)
        there = None if nearby is None else _ratio_at(loops, nearby, leader, stop)
        if there is None or abs(there - ratio) > RANK_TOLERANCE * ratio:
            return None
    return ratio


def _ratio_at(loops: Loops, x: FloatArray, leader: Stop, stop: Stop) -> float | None:
    """The ratio where the leader is closed; None if the other stop is not closed there."""
    if abs(stop.gap(loops.units * x)) > GAP_ROUND_OFF * loops.units[stop.index]:
        return None
    motions = loops.units[:, None] * _motions(loops.rows(x)[1])
    one, other = (item.sense * motions[item.index] for item in (leader, stop))
    return float(one @ other / (one @ one)) if _alike(one, other) else None


def _closed(loops: Loops, x: FloatArray, leader: Stop, share: float) -> FloatArray | None:
    """The nearest configuration in which a stop is at a share of its place; None if none is."""
    unit = np.eye(len(x))[leader.index]
    target = share * leader.at / loops.units[leader.index]
    for _ in range(_ITERATIONS):
        gaps, jacobian = loops.rows(x)
        left = np.append(gaps, x[leader.index] - target)
        step = np.linalg.lstsq(np.vstack([jacobian, unit]), left)[0]
        x = x - step
        size = float(np.abs(step).max())
        # The error that is left is the square of that step, or round-off.
        if size <= GAP_ROUND_OFF * max(1.0, float(np.abs(x).max())):
            x[leader.index] = target
            return x
        if not size < _FAR:
            break
    return None
