"""The judge's own equations of motion, and what round-off makes of their solution.

One linear system of accelerations and closure forces is laid out and solved here, without the
constrained dynamics that solutions are computed with. What it and any other way of computing may be
off by follows from it, too: the inverse carries the round-off of each equation to accelerations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid.result.solution import Solution

from ...tolerances import EPS, ROUNDINGS_PER_LINK
from .applied_forces import AppliedForces
from .chain_sizes import ChainSizes
from .plain_tree import PlainTree


class _Solved(NamedTuple):
    """The linear system at one state: accelerations that nothing prescribes, closure forces.

    Attributes:
        a: All accelerations, shape (nv,).
        loose: Coordinates that nothing prescribes.
        unknowns: Their accelerations and the closure forces.
        matrix: Of the system.
        inverse: Sizes of the elements of its inverse.
        jacobian: Of the closures, shape (m, nv).
        applied: Size of what the applied forces are sums of, shape (nv,).
    """

    a: FloatArray
    loose: list[int]
    unknowns: FloatArray
    matrix: FloatArray
    inverse: FloatArray
    jacobian: FloatArray
    applied: FloatArray


class Equations:
    """Equations of motion of the machine of a solution.

    Args:
        solution: The solution; its model, springs, drives and stops are taken, not its motion.
    """

    def __init__(self, solution: Solution) -> None:
        """Lay out the links and the forces on them."""
        self._mechanism, self._held = solution.mechanism, solution.system.held
        self._sizes = ChainSizes(solution.mechanism)
        self.tree = PlainTree(solution.mechanism)
        self.forces = AppliedForces(solution, self.tree, self._sizes)
        self._driven, self.nv = self.forces.driven, self.tree.nv
        self._rows = 2 * len(solution.mechanism.closures)

    def prescribed(self, closed: frozenset[str]) -> list[int]:
        """Coordinates that held drives and closed stops prescribe."""
        stops = [stop.index for stop in self._mechanism.stops if stop.name in closed]
        return [*(self._driven if self._held else []), *stops]

    def freedom(self, closed: frozenset[str]) -> int:
        """Coordinates less closures, held drives and closed stops."""
        return self.nv - self._rows - len(self.prescribed(closed))

    def loose(self, closed: frozenset[str]) -> list[int]:
        """Coordinates that nothing prescribes."""
        given = self.prescribed(closed)
        return [place for place in range(self.nv) if place not in given]

    def opened(self, q: FloatArray, closed: frozenset[str]) -> FloatArray:
        """Errors of coordinates for closure gaps of round-off size, shape (nv,)."""
        gaps, jacobian = self.tree.closures(q)
        loose = self.loose(closed)
        off = np.zeros(self.nv)
        # A closure gap has the round-off of the places whose difference it is.
        open_by = np.abs(gaps) + self._roundings() * self._sizes.reach(q)
        off[loose] = np.abs(np.linalg.pinv(jacobian[:, loose])) @ open_by
        return off

    def condition(self, q: FloatArray, closed: frozenset[str]) -> float:
        """Condition of G M^-1 G' with closures and closed stops, each scaled to the size of one.

        Forces of constraint lose that many digits: the closures' own, and those by which bodies of
        very different mass pull at one another. The two rows of a pin have one unit and one scale,
        so that the directions of axes do not count.
        """
        held = self._driven if self._held else []
        moving = [place for place in range(self.nv) if place not in held]
        stops = [stop.index for stop in self._mechanism.stops if stop.name in closed]
        rows = np.vstack([self.tree.closures(q)[1], np.eye(self.nv)[stops]])[:, moving]
        if not len(rows):
            return 1.0
        mass = self._mass(q)[np.ix_(moving, moving)]
        matrix = rows @ np.linalg.solve(mass, rows.T)
        diagonal = np.diag(matrix)
        if not (diagonal > 0.0).all():
            return np.inf
        pins = diagonal[: self._rows].reshape(-1, 2).mean(axis=1)
        size = np.sqrt(np.concatenate([np.repeat(pins, 2), diagonal[self._rows :]]))
        return float(np.linalg.cond(matrix / size / size[:, None]))

    def sizes(self, q: FloatArray) -> FloatArray:
        """Sums of the terms of the coordinates with alternating signs, shape (nv,).

        The length of a strut is a difference of places, which have the round-off of the reach.
        """
        size = np.abs(q) + (self._sizes.reach(q) if self._mechanism.struts else 0.0)
        return np.asarray((-1.0) ** np.arange(self.nv) * size)

    def accelerations(
        self, t: float, q: FloatArray, v: FloatArray, closed: frozenset[str]
    ) -> FloatArray:
        """Solve M a + h = tau + G' la, G a + G_dot v = 0 with what is prescribed, shape (nv,).

        Args:
            t: Time [s].
            q: Configuration, shape (nv,).
            v: Velocity, shape (nv,).
            closed: Names of the closed stops.
        """
        return self._solve(t, q, v, closed).a

    def round_off(
        self, t: float, q: FloatArray, v: FloatArray, closed: frozenset[str]
    ) -> FloatArray:
        """Errors of the accelerations by round-off in the equations; arguments as there."""
        found = self._solve(t, q, v, closed)
        count, loose = len(found.loose), found.loose
        forces, opened = self._sizes.of(q, v, found.a)
        pulled = np.abs(found.jacobian.T) @ np.abs(found.unknowns[count:])
        # In one linear system coordinates at rest have the round-off of moving ones.
        opened = np.full(len(opened), opened.max(initial=0.0))
        pushed = (forces + found.applied + pulled)[loose]
        # Closures may be met by forces, as the difference of what these and the others do alone.
        moved = np.abs(np.linalg.pinv(found.matrix[:count, :count])) @ pushed
        opened += np.abs(found.jacobian[:, loose]) @ moved
        wrong = np.concatenate([pushed, opened])
        # Gaussian elimination of n unknowns: that of equations off by 3 n roundings (Higham, 2002).
        eliminated = 1.5 * EPS * len(wrong)
        wrong = self._roundings() * wrong
        wrong += eliminated * np.abs(found.matrix) @ np.abs(found.unknowns)
        unsure = eliminated * self._sizes.still(q, found.a)
        unsure[self.prescribed(closed)] = 0.0
        unsure[loose] += (found.inverse @ wrong)[:count]
        return unsure

    def _solve(self, t: float, q: FloatArray, v: FloatArray, closed: frozenset[str]) -> _Solved:
        given = np.zeros(self.nv)
        tau, size = self.forces.of_elements(q, v)
        if self._held:
            given[self._driven] = self.forces.laws(t)[2]
        else:
            torques, sizes = self.forces.of_trains(t, q, v)
            tau[self._driven] += torques
            size[self._driven] += sizes
        loose = self.loose(closed)
        mass, (_, jacobian) = self._mass(q), self.tree.closures(q)
        drawn, opening = self.tree.held_back(q, v), self.tree.opening(q, v)
        count, rows = len(loose), len(opening)
        matrix = np.zeros((count + rows, count + rows))
        matrix[:count, :count] = mass[np.ix_(loose, loose)]
        matrix[count:, :count] = jacobian[:, loose]
        matrix[:count, count:] = jacobian[:, loose].T
        right = np.concatenate([(tau - drawn - mass @ given)[loose], -opening - jacobian @ given])
        solution, inverse = _solved(matrix, right)
        a = given.copy()
        a[loose] = solution[:count]
        return _Solved(a, loose, solution, matrix, inverse, jacobian, size)

    def _roundings(self) -> float:
        """Relative round-off of what is added up from link to link along the longest chain."""
        return 0.5 * EPS * ROUNDINGS_PER_LINK * (self._sizes.longest + 2.0)

    def _mass(self, q: FloatArray) -> FloatArray:
        mass = self.tree.mass(q)
        if not self._held:
            mass[self._driven, self._driven] += self.forces.inertia
        return mass


def _solved(matrix: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Solution, refined once, and the sizes of the elements of the inverse."""
    # Rows and columns of masses and of metres are brought to one size first.
    size = np.sqrt(np.maximum(np.abs(matrix).max(axis=1), np.finfo(float).tiny))
    inverse = np.linalg.inv(matrix / size / size[:, None]) / size / size[:, None]
    solution = inverse @ right
    solution = solution + inverse @ (right - matrix @ solution)
    return np.asarray(solution), np.abs(inverse)
