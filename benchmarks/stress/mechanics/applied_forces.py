"""Forces of springs, dampers and drive trains from their numbers, and the sizes of their terms."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import NamedTuple

import numpy as np

from nipper_pin.hybrid import Solution
from nipper_pin.mechanism import Strut

from ...tolerances import EPS
from .chain_sizes import ChainSizes
from .model_text import Real
from .planar_tree import Complex, PlanarTree


class Pull(NamedTuple):
    """Tension [N] of a strut at states of any shape (...), line from its first point to its second.

    The line [m], its length, which is not zero, and its Jacobian, shape (..., nv), go with it.
    """

    strut: Strut
    tension: Real
    line: Complex
    length: Real
    jacobian: Complex


class AppliedForces:
    """Forces that depend on state and time alone.

    Of the solution its elements, drives and shaft are taken, not its motion.
    """

    def __init__(self, solution: Solution, tree: PlanarTree, chains: ChainSizes) -> None:
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

    def of_elements(self, q: Real, v: Real) -> tuple[Real, Real]:
        """Forces of springs and dampers, shape (..., nv), and the size of what they are sums of."""
        tau, size = np.zeros(q.shape), np.zeros(q.shape)
        for spring in self._machine.springs:
            x = q[..., spring.index]
            tau[..., spring.index] -= spring.stiffness * (spring.preload + x)
            size[..., spring.index] += spring.stiffness * (abs(spring.preload) + np.abs(x))
        for damper in self._machine.dampers:
            pull = damper.damping * v[..., damper.index]
            tau[..., damper.index] -= pull
            size[..., damper.index] += np.abs(pull)
        for table in self._machine.tabulated_springs:
            x = np.ravel(q[..., table.index])
            pull, beside = (
                table.characteristic.forces(factor * x).reshape(q.shape[:-1])
                for factor in (1.0, 1.0 + EPS)
            )
            tau[..., table.index] -= pull
            size[..., table.index] += np.abs(pull) + np.abs(beside - pull) / EPS
        reach = self._chains.reach(q) if self._machine.struts else 0.0
        for strut, tension, line, length, jacobian in self.pulls(q, v):
            along = (line / length)[..., None]
            tau -= tension[..., None] * (along.conj() * jacobian).real
            # A length is a difference of places, and so is the direction of its line.
            levers = np.maximum(np.abs(jacobian.real), np.abs(jacobian.imag))
            rate = strut.damping * (levers * np.abs(v)).sum(axis=-1)
            stretched = strut.stiffness * (reach + strut.free_length)
            sizes = stretched + rate + (np.abs(tension) + rate) * reach / length
            size += sizes[..., None] * levers
        return tau, size

    def pulls(self, q: Real, v: Real) -> Iterator[Pull]:
        """Springs and dampers between two points."""
        if not self._machine.struts:
            return
        motion = self._tree.motion(q, v, np.zeros(q.shape))
        for strut in self._machine.struts:
            ends = [self._tree.frames[name] for name in (strut.frame_a, strut.frame_b)]
            (place, speed, _), columns = motion.points(ends), self._tree.jacobian(motion, ends)
            line, moving = place[..., 1] - place[..., 0], speed[..., 1] - speed[..., 0]
            length = np.maximum(np.abs(line), np.finfo(float).tiny)
            rate = (line.conj() * moving).real / length
            tension = strut.stiffness * (length - strut.free_length) + strut.damping * rate
            jacobian = columns[..., 1, :] - columns[..., 0, :]
            yield Pull(strut, tension, line, length, jacobian)

    def of_trains(self, t: Real, q: Real, v: Real) -> tuple[Real, Real]:
        """Torques of elastic drive trains, shape (..., drives), and the size of their terms."""
        q_law, v_law, a_law = self.laws(t)
        parts = (
            self.inertia * a_law,
            self.stiffness * q_law, -self.stiffness * q[..., self.driven],
            self._damping * v_law, -self._damping * v[..., self.driven],
        )  # fmt: skip
        return np.sum(parts, axis=0), np.sum(np.abs(parts), axis=0)

    def laws(self, t: Real) -> tuple[Real, Real, Real]:
        """Driven coordinates, rates and accelerations at times (...), shape (..., drives) each."""
        q, v, a = (x.reshape(*np.shape(t), -1) for x in self._shaft.driven(np.ravel(t)))
        return q, v, a

    def tension(self, q: Real, v: Real) -> float:
        """Largest pull of a strut at some states, shape (N, nv) each [N]."""
        return max((float(np.abs(p.tension).max()) for p in self.pulls(q, v)), default=0.0)
