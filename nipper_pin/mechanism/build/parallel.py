"""Stops that close together: closures and couplings tie their joints, so one freedom has them all.

The jaws that one rack moves, or the cranks of a parallelogram, may have a stop each, met at one
time. Each of these could hold the others alone, so one of them, the leader, is followed for all.
They are found by following the machine to where the leader is closed: there, and nearby, wherever
the leader's gap is zero the other's has to be zero, and both gaps have to grow together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...tolerances.hybrid import GAP_ROUND_OFF
from ...tolerances.mechanics import RANK_TOLERANCE
from ..parts import Stop
from ..scale import reach, unit_of, units_of
from .closures import PLANE
from .touch_checks import Constraints
from .tree import Tree

# Steps from the touch configuration to a closed stop, and of Newton's method in each.
_STEPS, _ITERATIONS = 12, 20
# How far the neighbours lie at which freedoms that are left must not open the other stop, and a
# step of Newton's method that leads nowhere [rad, or units].
_NEARBY, _FAR = 0.05, 100.0


def with_leaders(held: Constraints, tree: Tree) -> Constraints:
    """The same with stops that know their leader, of those that close with another.

    Of stops that close together the one with the largest restitution leads: by Newton's law it
    alone is struck where coefficients differ.

    Args:
        held: What holds the coordinates; the frames of its closures meet.
    """
    stops = held.stops
    if len(stops) < 2:
        return held
    motions = _motions(held.jacobian)
    rows = {stop.name: stop.sense * motions[stop.index] for stop in stops}
    loops: _Loops | None = None
    found: dict[str, Stop] = {}
    for stop in sorted(stops, key=lambda item: -item.restitution):
        found[stop.name] = stop
        for leader in found.values():
            if leader is stop or leader.leader or leader.law != stop.law:
                continue
            if not _alike(rows[leader.name], rows[stop.name]):
                continue
            loops = loops or _Loops(held, tree)
            ratio = loops.ratio(leader, stop)
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


class _Loops:
    """Closures and couplings of a tree away from its touch configuration, q = 0."""

    def __init__(self, held: Constraints, tree: Tree) -> None:
        """Find the frames."""
        self._model, self._couplings = tree.model, held.couplings
        self._data = tree.model.createData()
        self._pairs = [
            tuple(tree.model.getFrameId(name, pin.FrameType.BODY) for name in pair)
            for pair in ((item.frame_a, item.frame_b) for item in held.closures)
        ]
        self._units = units_of(tree.joints, unit_of(reach(tree.model, tree.joints, held.stops)))

    def ratio(self, leader: Stop, stop: Stop) -> float | None:
        """Rate of the gap of a stop by that of its leader; None if they do not close together."""
        x = np.zeros(len(self._units))
        for step in range(1, _STEPS + 1):
            closed = self._closed(x, leader, step / _STEPS)
            if closed is None:
                return None
            x = closed
        ratio = self._ratio_at(x, leader, stop)
        if ratio is None:
            return None
        rows = np.vstack([self._rows(x)[1], np.eye(len(x))[leader.index]])
        for motion in _motions(rows).T:
            nearby = self._closed(x + _NEARBY * motion, leader, 1.0)
            there = None if nearby is None else self._ratio_at(nearby, leader, stop)
            if there is None or abs(there - ratio) > RANK_TOLERANCE * ratio:
                return None
        return ratio

    def _ratio_at(self, x: FloatArray, leader: Stop, stop: Stop) -> float | None:
        """The ratio where the leader is closed; None if the other stop is not closed there."""
        if abs(stop.gap(self._units * x)) > GAP_ROUND_OFF * self._units[stop.index]:
            return None
        motions = self._units[:, None] * _motions(self._rows(x)[1])
        one, other = (item.sense * motions[item.index] for item in (leader, stop))
        return float(one @ other / (one @ one)) if _alike(one, other) else None

    def _closed(self, x: FloatArray, leader: Stop, share: float) -> FloatArray | None:
        """The nearest configuration in which a stop is at a share of its place; None if none is."""
        unit = np.eye(len(x))[leader.index]
        target = share * leader.at / self._units[leader.index]
        for _ in range(_ITERATIONS):
            gaps, jacobian = self._rows(x)
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

    def _rows(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gaps of closures and couplings, and their Jacobian by coordinates in their units."""
        model, data, q = self._model, self._data, self._units * x
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        gaps, rows = list[FloatArray](), list[FloatArray]()
        for pair in self._pairs:
            (a, b), (by_a, by_b) = (
                [data.oMf[frame].translation[list(PLANE)] for frame in pair],
                [
                    pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[list(PLANE)]
                    for frame in pair
                ],
            )
            gaps.append(b - a)
            rows.append(by_b - by_a)
        for item in self._couplings:
            row = np.zeros((1, len(q)))
            row[0, item.index], row[0, item.of] = 1.0, -item.multiplier
            gaps.append(row @ q)
            rows.append(row)
        if not rows:
            return np.empty(0), np.empty((0, len(q)))
        return np.concatenate(gaps), np.vstack(rows) * self._units
