"""Sizes of the terms in the sums of a tree's dynamics, without cancellation.

Of a chain of joints k that carries a link: its acceleration is a sum of a_k times the length of the
way from the joint, of W^2 L of all that turns and of 2 W U of what slides on it; its force is its
mass times that and weight, and the moment about a joint has the way to the joint for its lever.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism

_BODY = pin.FrameType.BODY


class ChainSizes:
    """Sizes of the terms of forces and closures."""

    def __init__(self, mechanism: Mechanism) -> None:
        """Find the chain of joints below every link and closure frame."""
        self._model = model = mechanism.model
        self._slides = np.zeros(model.nv, dtype=bool)
        for joint in mechanism.joints:
            self._slides[joint.index] = joint.kind == "prismatic"
        self._gravity = float(np.linalg.norm(model.gravity.linear))
        self._steps = [float(np.linalg.norm(p.translation)) for p in model.jointPlacements]
        self._levers = [float(np.linalg.norm(item.lever)) for item in model.inertias]
        self._chains = [[j for j in model.supports[link] if j] for link in range(model.njoints)]
        self.longest = max(map(len, self._chains))
        frames = [
            [model.frames[model.getFrameId(name, _BODY)] for name in (item.frame_a, item.frame_b)]
            for item in mechanism.closures
        ]
        self._cuts = [
            [(f.parentJoint, float(np.linalg.norm(f.placement.translation))) for f in pair]
            for pair in frames
        ]

    def reach(self, q: FloatArray) -> float:
        """Longest way from the frame to a link's centre or to a cut joint [m]."""
        ends = [(link, self._levers[link]) for link in range(1, self._model.njoints)]
        ends += [end for pair in self._cuts for end in pair]
        return max(float(self._ways(q, *end).max(initial=0.0)) for end in ends)

    def of(self, q: FloatArray, v: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Sizes at one state.

        Args:
            q: Configuration, shape (nv,).
            v: Velocity, shape (nv,).
            a: Acceleration, shape (nv,).

        Returns:
            Of the generalised forces, shape (nv,) [N m or N], and of the accelerations with which
            cut joints open, shape (m,) [m/s2].
        """
        forces = np.zeros(len(q))
        for link in range(1, self._model.njoints):
            inertia = self._model.inertias[link]
            columns, levers, moved, turned = self._point(q, v, a, link, self._levers[link])
            forces[columns] += inertia.mass * levers * (self._gravity + moved)
            forces[columns] += inertia.inertia[1, 1] * turned * ~self._slides[columns]
        opened = [sum(self._point(q, v, a, *end)[2] for end in pair) for pair in self._cuts]
        return forces, np.repeat(np.array(opened), 2)

    def still(self, q: FloatArray, a: FloatArray) -> FloatArray:
        """Accelerations as large as the largest one, shape (nv,); slides count by the reach.

        What stands still in the solution of a linear system has the round-off of what moves.
        """
        reach = max(self.reach(q), float(np.finfo(float).tiny))
        levers = np.where(self._slides, reach, 1.0)
        return np.asarray(float((np.abs(a) / levers).max(initial=0.0)) * levers)

    def _point(
        self, q: FloatArray, v: FloatArray, a: FloatArray, link: int, beyond: float
    ) -> tuple[list[int], FloatArray, float, float]:
        """Coordinates that move a point, their levers, and sizes of its accelerations."""
        columns = [self._model.idx_vs[joint] for joint in self._chains[link]]
        ways = self._ways(q, link, beyond)
        slides = self._slides[columns]
        levers = np.where(slides, 1.0, ways)
        rates, speeds = np.abs(v[columns]), np.abs(a[columns])
        turning, sliding = float(rates[~slides].sum()), float(rates[slides].sum())
        moved = float(levers @ speeds) + 2.0 * turning * sliding
        moved += turning**2 * float(ways.max(initial=0.0))
        return columns, levers, moved, float(speeds[~slides].sum())

    def _ways(self, q: FloatArray, link: int, beyond: float) -> FloatArray:
        """Lengths of the ways along the links, from each joint of a chain to its last point [m]."""
        ways = []
        for joint in reversed(self._chains[link]):
            column = self._model.idx_vs[joint]
            beyond += abs(float(q[column])) if self._slides[column] else 0.0
            ways.append(beyond)
            beyond += self._steps[joint]
        return np.array(ways[::-1])
