"""Forces of springs, dampers and drive trains from their numbers, and the sizes of their terms."""

from __future__ import annotations

from math import pi

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid.result.solution import Solution

from ...tolerances import EPS
from .chain_sizes import ChainSizes
from .plain_tree import PlainTree


class AppliedForces:
    """Forces that depend on state and time alone.

    Args:
        solution: The solution; its elements, drives and shaft are taken, not its motion.
        tree: Its links.
        chains: How long their chains are.
    """

    def __init__(self, solution: Solution, tree: PlainTree, chains: ChainSizes) -> None:
        """Read the numbers of the drive trains."""
        self._machine, self._shaft = solution.mechanism, solution.shaft
        self._tree, self._chains = tree, chains
        drives = solution.mechanism.drives
        self.driven = [drive.index for drive in drives]
        self.inertia = np.array([drive.reflected_inertia for drive in drives])
        turning = 2.0 * pi * np.array([drive.shaft_frequency_hz for drive in drives])
        ratio = np.array([drive.shaft_damping_ratio for drive in drives])
        self.stiffness = self.inertia * turning**2
        self._damping = 2.0 * ratio * turning * self.inertia

    def of_elements(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Forces of springs and dampers, shape (nv,), and the size of what they are sums of."""
        tau, size = np.zeros(len(q)), np.zeros(len(q))
        for spring in self._machine.springs:
            x = float(q[spring.index])
            tau[spring.index] -= spring.stiffness * (spring.preload + x)
            size[spring.index] += spring.stiffness * (abs(spring.preload) + abs(x))
        for damper in self._machine.dampers:
            pull = damper.damping * float(v[damper.index])
            tau[damper.index] -= pull
            size[damper.index] += abs(pull)
        for table in self._machine.tabulated_springs:
            x = float(q[table.index])
            found = table.characteristic.forces(np.array([x, (1.0 + EPS) * x]))
            pull, beside = found.tolist()
            tau[table.index] -= pull
            size[table.index] += abs(pull) + abs(beside - pull) / EPS
        for strut, tension, line, length, jacobian in self._tree.pulls(q, v):
            tau -= tension * (line / length @ jacobian)
            # A length is a difference of places, and so is the direction of its line.
            reach, levers = self._chains.reach(q), np.abs(jacobian).max(axis=0)
            rate = strut.damping * float(levers @ np.abs(v))
            stretched = strut.stiffness * (reach + strut.free_length)
            size += (stretched + rate + (abs(tension) + rate) * reach / length) * levers
        return tau, size

    def of_trains(self, t: float, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Torques of elastic drive trains, shape (drives,), and the size of their terms."""
        q_law, v_law, a_law = self.laws(t)
        parts = (
            self.inertia * a_law,
            self.stiffness * q_law, -self.stiffness * q[self.driven],
            self._damping * v_law, -self._damping * v[self.driven],
        )  # fmt: skip
        return np.sum(parts, axis=0), np.sum(np.abs(parts), axis=0)

    def laws(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Driven coordinates, rates and accelerations, shape (drives,) each."""
        q_law, v_law, a_law = self._shaft.driven(np.array([t]))
        return q_law[0], v_law[0], a_law[0]

    def tension(self, q: FloatArray, v: FloatArray) -> float:
        """Largest pull of a strut at some states, shape (N, nv) each [N]."""
        states = zip(q, v, strict=True)
        pulls = [abs(pull.tension) for state in states for pull in self._tree.pulls(*state)]
        return max(pulls, default=0.0)
