"""The judge's own equations of motion, and what round-off makes of their solution.

One linear system of accelerations and closure forces is laid out and solved here, without the
constrained dynamics that solutions are computed with. What it and any other way of computing may be
off by follows from it, too: the inverse carries the round-off of each equation to accelerations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nipper_pin.hybrid import Solution

from ...tolerances import EPS, ROUNDINGS_PER_LINK
from .applied_forces import AppliedForces
from .chain_sizes import ChainSizes
from .model_text import Real
from .planar_tree import PlanarTree


class _Solved(NamedTuple):
    """The linear systems of states, for n unknowns: accelerations that are loose, closure forces.

    Accelerations are all, the inverse holds sizes of elements, the Jacobian is that of the closures
    and applied is the size of what the applied forces are sums of, shape (..., nv).
    """

    a: Real
    loose: list[int]
    unknowns: Real
    matrix: Real
    inverse: Real
    jacobian: Real
    applied: Real


class Equations:
    """Equations of motion of the machine of a solution.

    States have any shape before that of the coordinates; each is solved by itself. Of the solution
    its model, springs, drives and stops are taken, not its motion.
    """

    def __init__(self, solution: Solution) -> None:
        """Lay out the links and the forces on them."""
        self._mechanism, self._held = solution.mechanism, solution.system.held
        self.tree = PlanarTree.of(solution.mechanism)
        self._sizes = ChainSizes(self.tree)
        self.forces = AppliedForces(solution, self.tree, self._sizes)
        self._driven, self.nv = self.forces.driven, self.tree.nv
        self._rows = 2 * len(self.tree.closures)

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

    def opened(self, q: Real, closed: frozenset[str]) -> Real:
        """Errors of coordinates for closure gaps of round-off size, shape (..., nv)."""
        gaps, jacobian = self.closures(q)
        loose = self.loose(closed)
        off = np.zeros(q.shape)
        # A closure gap has the round-off of the places whose difference it is.
        open_by = np.abs(gaps) + self._roundings() * self._sizes.reach(q)[..., None]
        off[..., loose] = _times(np.abs(np.linalg.pinv(jacobian[..., loose])), open_by)
        return off

    def closures(self, q: Real) -> tuple[Real, Real]:
        """Gaps of the cut joints in world axes, (..., m) [m], and their Jacobian, (..., m, nv)."""
        nothing = np.zeros(q.shape)
        gaps = self.tree.closure(q, nothing, nothing, world=True)[0]
        return gaps, self.tree.closure_jacobian(q, world=True)

    def condition(self, q: Real, closed: frozenset[str]) -> Real:
        """Condition of G M^-1 G' with closures and closed stops, each scaled to the size of one.

        Forces of constraint lose that many digits: the closures' own, and those by which bodies of
        very different mass pull at one another. The two rows of a pin have one unit and one scale,
        so that the directions of axes do not count.
        """
        held = self._driven if self._held else []
        moving = [place for place in range(self.nv) if place not in held]
        stops = np.eye(self.nv)[[s.index for s in self._mechanism.stops if s.name in closed]]
        pins = self.tree.closure_jacobian(q, world=True)
        stops = np.broadcast_to(stops, (*q.shape[:-1], *stops.shape))
        rows = np.concatenate([pins, stops], axis=-2)[..., moving]
        found = np.full(q.shape[:-1], 1.0)
        if not rows.shape[-2]:
            return found
        matrix = rows @ np.linalg.solve(_square(self._mass(q), moving), np.swapaxes(rows, -1, -2))
        diagonal = np.diagonal(matrix, axis1=-2, axis2=-1).copy()
        possible = (diagonal > 0.0).all(axis=-1)
        pairs = diagonal[..., : self._rows]
        diagonal[..., : self._rows] = np.repeat(0.5 * (pairs[..., ::2] + pairs[..., 1::2]), 2, -1)
        size = np.sqrt(diagonal[possible])
        scaled = matrix[possible] / size[..., None] / size[..., None, :]
        found[possible], found[~possible] = np.linalg.cond(scaled), np.inf
        return found

    def sizes(self, q: Real) -> Real:
        """Sums of the terms of the coordinates with alternating signs, shape (..., nv).

        The length of a strut is a difference of places, which have the round-off of the reach.
        """
        reach = self._sizes.reach(q)[..., None] if self._mechanism.struts else 0.0
        return np.asarray((-1.0) ** np.arange(self.nv) * (np.abs(q) + reach))

    def accelerations(self, t: Real, q: Real, v: Real, closed: frozenset[str]) -> Real:
        """Solve M a + h = tau + G' la, G a + G_dot v = 0 with what is prescribed, shape (..., nv).

        Times t have shape (...), configurations and velocities (..., nv); ``closed`` are stops.
        """
        return self._solve(t, q, v, closed).a

    def round_off(self, t: Real, q: Real, v: Real, closed: frozenset[str]) -> Real:
        """Errors of the accelerations by round-off in the equations; arguments as there."""
        found = self._solve(t, q, v, closed)
        count, loose = len(found.loose), found.loose
        forces, opened = self._sizes.of(q, v, found.a)
        pulled = _times(np.swapaxes(np.abs(found.jacobian), -1, -2),
                        np.abs(found.unknowns[..., count:]))  # fmt: skip
        # In one linear system coordinates at rest have the round-off of moving ones.
        opened = np.ones(opened.shape) * opened.max(axis=-1, keepdims=True, initial=0.0)
        pushed = (forces + found.applied + pulled)[..., loose]
        # Closures may be met by forces, as the difference of what these and the others do alone.
        moved = _times(np.abs(np.linalg.pinv(found.matrix[..., :count, :count])), pushed)
        opened += _times(np.abs(found.jacobian[..., loose]), moved)
        wrong = np.concatenate([pushed, opened], axis=-1)
        # Gaussian elimination of n unknowns: that of equations off by 3 n roundings (Higham, 2002).
        eliminated = 1.5 * EPS * wrong.shape[-1]
        wrong = self._roundings() * wrong
        wrong += eliminated * _times(np.abs(found.matrix), np.abs(found.unknowns))
        unsure = eliminated * self._sizes.still(q, found.a)
        unsure[..., self.prescribed(closed)] = 0.0
        unsure[..., loose] += _times(found.inverse, wrong)[..., :count]
        return np.asarray(unsure)

    def _solve(self, t: Real, q: Real, v: Real, closed: frozenset[str]) -> _Solved:
        given = np.zeros(q.shape)
        tau, size = self.forces.of_elements(q, v)
        if self._held:
            given[..., self._driven] = self.forces.laws(t)[2]
        else:
            torques, sizes = self.forces.of_trains(t, q, v)
            tau[..., self._driven] += torques
            size[..., self._driven] += sizes
        loose = self.loose(closed)
        mass, jacobian = self._mass(q), self.tree.closure_jacobian(q, world=True)
        drawn = self.tree.inverse_dynamics(q, v, np.zeros(q.shape))
        opening = self.tree.closure(q, v, np.zeros(q.shape), world=True)[2]
        count, rows = len(loose), opening.shape[-1]
        matrix = np.zeros((*q.shape[:-1], count + rows, count + rows))
        matrix[..., :count, :count] = _square(mass, loose)
        matrix[..., count:, :count] = jacobian[..., loose]
        matrix[..., :count, count:] = np.swapaxes(jacobian[..., loose], -1, -2)
        pushes = (tau - drawn - _times(mass, given))[..., loose]
        right = np.concatenate([pushes, -opening - _times(jacobian, given)], axis=-1)
        solution, inverse = _solved(matrix, right)
        a = given.copy()
        a[..., loose] = solution[..., :count]
        return _Solved(a, loose, solution, matrix, inverse, jacobian, size)

    def _roundings(self) -> float:
        """Relative round-off of what is added up from link to link along the longest chain."""
        return 0.5 * EPS * ROUNDINGS_PER_LINK * (self._sizes.longest + 2.0)

    def _mass(self, q: Real) -> Real:
        mass = self.tree.mass_matrix(q)
        if not self._held:
            mass[..., self._driven, self._driven] += self.forces.inertia
        return mass


def _times(matrices: Real, vectors: Real) -> Real:
    return np.asarray((matrices @ vectors[..., None])[..., 0])


def _square(matrices: Real, places: list[int]) -> Real:
    return matrices[..., places, :][..., places]


def _solved(matrix: Real, right: Real) -> tuple[Real, Real]:
    """Solutions, refined once, and the sizes of the elements of the inverses."""
    # Rows and columns of masses and of metres are brought to one size first.
    size = np.sqrt(np.maximum(np.abs(matrix).max(axis=-1), np.finfo(float).tiny))
    both = size[..., None] * size[..., None, :]
    inverse = np.linalg.inv(matrix / both) / both
    solution = _times(inverse, right)
    solution = solution + _times(inverse, right - _times(matrix, solution))
    return solution, np.abs(inverse)
