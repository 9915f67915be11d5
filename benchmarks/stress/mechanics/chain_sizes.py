"""Sizes of the terms in the sums of a tree's dynamics, without cancellation.

Of a chain of joints k that carries a link: its acceleration is a sum of a_k times the length of the
way from the joint, of W^2 L of all that turns and of 2 W U of what slides on it; its force is its
mass times that and weight, and the moment about a joint has the way to the joint for its lever.
"""

from __future__ import annotations

import numpy as np

from .model_text import Real
from .planar_tree import PlanarTree


class ChainSizes:
    """Sizes of the terms of forces and closures; states have any shape before the coordinates."""

    def __init__(self, tree: PlanarTree) -> None:
        """Find the ways below every link and closure frame."""
        self._tree, self._slides = tree, tree.slides
        self._steps = np.abs(tree.offsets)
        moved = tree.moved
        self.longest = int(moved.sum(axis=1).max())
        # Joints (last) between a joint (second) and the link (first) that it moves.
        self._between = moved[:, None, :] & moved[:-1].T & ~np.eye(tree.nv, dtype=bool)
        self._between = (self._between & moved[:, :, None]).astype(float)
        self._cuts = [frame for pair in tree.closures for frame in pair]
        ends = [(link, abs(item.com)) for link, item in enumerate(tree.links)]
        ends += [(frame.body, abs(frame.place)) for frame in self._cuts]
        self._bodies = np.array([body for body, _ in ends])
        self._beyond = np.array([beyond for _, beyond in ends])
        self._moved = moved[self._bodies].astype(float)

    def reach(self, q: Real) -> Real:
        """Longest way from the frame to a link's centre or to a cut joint [m], shape (...)."""
        return np.asarray(self._ways(q).max(axis=(-2, -1)))

    def of(self, q: Real, v: Real, a: Real) -> tuple[Real, Real]:
        """Sizes of generalised forces, shape (..., nv) [N m or N], at states of that shape.

        And of the accelerations with which cut joints open, shape (..., m) [m/s2].
        """
        ways, tree = self._ways(q), self._tree
        levers = self._moved * np.where(self._slides, 1.0, ways)
        hinges = self._moved * ~self._slides
        turning = np.abs(v) @ hinges.T
        sliding = np.abs(v) @ (self._moved * self._slides).T
        moved = (levers @ np.abs(a)[..., None])[..., 0] + 2.0 * turning * sliding
        moved += turning**2 * ways.max(axis=-1)
        turned = np.abs(a) @ hinges[: tree.nv].T
        pushed = tree.masses * (abs(tree.gravity) + moved[..., : tree.nv])
        forces = (pushed[..., None, :] @ levers[..., : tree.nv, :])[..., 0, :]
        forces += (tree.inertias * turned) @ hinges[: tree.nv]
        cuts = moved[..., tree.nv :]
        return forces, np.repeat(cuts[..., ::2] + cuts[..., 1::2], 2, axis=-1)

    def still(self, q: Real, a: Real) -> Real:
        """Accelerations as large as the largest one, shape (..., nv); slides count by the reach.

        What stands still in the solution of a linear system has the round-off of what moves.
        """
        reach = np.maximum(self.reach(q), np.finfo(float).tiny)[..., None]
        levers = np.where(self._slides, reach, 1.0)
        return np.asarray((np.abs(a) / levers).max(axis=-1, keepdims=True) * levers)

    def _ways(self, q: Real) -> Real:
        """Lengths of the ways along the links, from each joint below a point to it [m].

        Shape (..., points, nv), zero of joints that do not move it. Points are the centres of the
        links, then the frames of closures.
        """
        slid = np.abs(q) * self._slides
        ways = ((self._steps + slid) @ self._between.reshape(-1, self._tree.nv).T).reshape(
            *q.shape[:-1], *self._between.shape[:2]
        )
        ways = ways[..., self._bodies, :] + self._beyond[:, None] + slid[..., None, :]
        return np.asarray(ways * self._moved)
