"""One panel of motion: what it holds, and exact states and forces at any time on it.

The motion of a panel does not depend on the choice of independent coordinates, but what closes the
loops at any of its times does: where the closures cease to determine the dependent coordinates,
their rates there become what round-off and tolerance make of them. That is no dead centre as long
as others will do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, Vectors, product
from ...chebyshev import evaluate, evaluate_motion, motion_weights, nodes, value_weights
from ...dynamics import (
    ConstraintSet,
    Driven,
    Partition,
    System,
    close_positions,
    close_velocities,
    inverses,
    multipliers,
    partition,
)
from ...dynamics.assembly import same_sign
from ...dynamics.system import Multipliers
from ...errors import SingularConfigurationError
from ...tolerances.hybrid import COORDINATE_ROUND_OFF, SMALLEST


class Begin(NamedTuple):
    """Time [s], q, v, a (nv,) and closure Jacobian (m, nv) where a panel starts, right limits."""

    t: float
    q: FloatArray
    v: FloatArray
    a: FloatArray
    jacobian: FloatArray


class Attempt(NamedTuple):
    """A panel, or why there is none, and the length that the next attempt should have.

    Attributes:
        panel: The panel; None if the nodes do not resolve it.
        forces: Stop forces at its nodes, shape (N, closed).
        factor: Ratio of the advised next length to this one.
    """

    panel: Panel | None
    forces: FloatArray
    factor: float


@dataclass(frozen=True, eq=False)
class Panel:
    """Motion over [t, t + h] at its collocation nodes.

    Attributes:
        t: Start [s].
        h: Length [s].
        q: Configurations at the nodes, shape (N, nv).
        v: Velocities at the nodes, shape (N, nv).
        a: Accelerations at the nodes, shape (N, nv).
        integrated: True if the free coordinates are integrals of ``a`` from the first node; False
            if all follow from the drives, node by node.
    """

    t: float
    h: float
    q: FloatArray
    v: FloatArray
    a: FloatArray
    split: Partition
    integrated: bool

    @property
    def order(self) -> int:
        """Number of nodes."""
        return len(self.q)

    @property
    def times(self) -> FloatArray:
        """Times of the nodes [s], shape (N,)."""
        return self.t + self.h * nodes(self.order).sigma

    @property
    def middle(self) -> float:
        """Time in the middle [s]: it lies on the piece of the drives that the panel lies on."""
        return self.t + 0.5 * self.h

    def shifted(self, delay: float, wound: FloatArray) -> Panel:
        """Return the same motion at a later time; it shares its accelerations with this one.

        Args:
            delay: How much later [s].
            wound: What is added to the coordinates, shape (nv,).
        """
        q = self.q + wound if wound.any() else self.q
        return replace(self, t=self.t + delay, q=q)

    def interpolate(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities, (K, nv), at times t [s], before the closures are met."""
        sigma = (t - self.t) / self.h
        if not self.integrated:
            return evaluate(self.q, sigma, 0), evaluate(self.v, sigma, 0)
        h = self.h
        twice, once = evaluate_motion(self.a, sigma)
        q = self.q[0] + (h * sigma)[:, None] * self.v[0] + h**2 * twice
        return q, self.v[0] + h * once

    def interpolate_at(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Position and velocity at one time t [s], each (nv,); otherwise as :meth:`interpolate`."""
        if t == self.t:
            # Collisions in one instant: of the integrals round-off would be left.
            return self.q[0].copy(), self.v[0].copy()
        h = self.h
        sigma = (t - self.t) / h
        if not self.integrated:
            weights = value_weights(self.order, sigma)
            return product(weights, self.q), product(weights, self.v)
        moved = product(motion_weights(self.order, sigma), self.a)
        return self.q[0] + (h * sigma) * self.v[0] + h**2 * moved[0], self.v[0] + h * moved[1]


class Exact(NamedTuple):
    """States on a panel in which prescribed motion and closures are met to round-off.

    Attributes:
        q: Configurations, shape (K, nv); of one state (nv,).
        v: Velocities, likewise.
        jacobian: Closure Jacobians, shape (K, m, nv); of one state (m, nv).
        motion: Driven coordinates, rates and accelerations, always one row a state.
    """

    q: FloatArray
    v: FloatArray
    jacobian: FloatArray
    motion: Driven


def state_at(
    system: System, phase: ConstraintSet, panel: Panel, t: FloatArray
) -> tuple[Exact, FloatArray]:
    """Exact states at times t of a panel, (K,) [s], and the :func:`inverses` behind their rates."""
    q, v = panel.interpolate(t)
    motion = system.shaft.driven(t, panel.middle)
    system.prescribe(motion, q, v, phase)
    q, jacobian = close_positions(system.body, q, panel.split)
    inverse = inverses(jacobian, panel.split)
    return Exact(q, close_velocities(v, jacobian, panel.split, inverse), jacobian, motion), inverse


def one_state_at(
    system: System, phase: ConstraintSet, panel: Panel, t: float, *, anew: bool = False
) -> Exact:
    """The exact state at a time t [s] of a panel, ready for the impact that follows.

    Another way than :func:`state_at` has less to do; ``anew`` as in :func:`close_positions`.
    """
    q, v = panel.interpolate_at(t)
    motion = system.shaft.driven_at(t, panel.middle)
    guess = q[None]
    system.prescribe(motion, guess, v[None], phase)
    closed, jacobians = close_positions(system.body, guess, panel.split, anew=anew)
    jacobian = jacobians[0]
    return Exact(closed[0], system.closed_velocity(v, jacobian, panel.split), jacobian, motion)


def forces_at(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    t: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, Multipliers]:
    """Exact states with accelerations and forces of constraint; arguments as :func:`state_at`.

    Returns:
        q, v, a of shape (K, nv) and the forces of constraint.
    """
    exact, inverse = state_at(system, phase, panel, t)
    return _forces(system, phase, panel, exact, inverse)


def stop_forces_at(system: System, phase: ConstraintSet, panel: Panel, t: float) -> FloatArray:
    """Forces of the closed stops at a time t [s], to round-off of the motion itself.

    What the interpolated positions leave of the closures would show near a dead centre.

    Returns:
        Shape (closed,) [N m or N], in the order of ``ConstraintSet.stops``.
    """
    q, v, jacobian, motion = one_state_at(system, phase, panel, t, anew=True)
    exact = Exact(q[None], v[None], jacobian[None], motion)
    inverse = inverses(exact.jacobian, panel.split)
    la_N: FloatArray = _forces(system, phase, panel, exact, inverse)[3].la_N[0]
    return la_N


def _forces(
    system: System, phase: ConstraintSet, panel: Panel, exact: Exact, inverse: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, Multipliers]:
    """Accelerations and forces of constraint of exact states; value as of :func:`forces_at`."""
    q, v, jacobian, motion = exact
    known = phase, panel.split, inverse
    if panel.integrated:
        a = system.accelerations(motion, q, v, phase)
    else:
        # Near a dead centre, and of links of very different masses, those of the dynamics differ.
        a = system.determined_accelerations(motion, q, v, *known)
    return q, v, a, multipliers(system, motion, q, v, a, jacobian, *known)


def defect(system: System, phase: ConstraintSet, panel: Panel, sigma: FloatArray) -> FloatArray:
    """Residual of the equations of motion at places sigma in [0, 1] of a panel, shape (K, nv).

    Interpolated accelerations differ by it from computed ones, at motion that is not closed anew.
    """
    t = panel.t + panel.h * sigma
    q, v = panel.interpolate(t)
    motion = system.shaft.driven(t, panel.middle)
    system.prescribe(motion, q, v, phase)
    there = system.accelerations(motion, q, v, phase)
    return np.asarray(np.abs(evaluate(panel.a, sigma, 0) - there))


def nearby(
    system: System, q: Vectors, v: Vectors, split: Partition
) -> tuple[FloatArray, FloatArray]:
    """The same states but for round-off: what moves between the two cannot be resolved.

    Dependent coordinates stand where the closures let them stand, and have the rates of that place:
    what the closures are open by near a dead centre makes itself felt there.
    """
    body, columns = system.body, split.columns
    signs = (-1.0) ** np.arange(body.nv)
    # The length of a strut is a difference of places.
    size = np.abs(q) + (system.mechanism.extents if system.mechanism.struts else 0.0)
    q = q + COORDINATE_ROUND_OFF * signs * size
    if columns.size:
        g, jacobian = body.closures(q)
        q[:, columns] -= np.linalg.solve(jacobian[:, :, columns], g[:, :, None])[:, :, 0]
        v = close_velocities(v, body.closures(q)[1], split)
    return q, v


def judged(panel: Panel, forces: FloatArray, excess: float, order: int) -> Attempt:
    """Accept a panel whose unresolved part is at most 1 in units of the tolerance."""
    factor = 0.9 * max(excess, SMALLEST) ** (-1.0 / order)
    factor = min(max(factor, 0.2), 2.0)
    if excess <= 1.0:
        return Attempt(panel, forces, factor)
    return Attempt(None, forces, shorter(excess, order))


def shorter(excess: float, order: int) -> float:
    """Ratio of the length of the next attempt to that of one whose unresolved part is above 1."""
    return float(min(max(0.9 * excess ** (-1.0 / order), 0.2), 0.7))


# A panel may end with a worse choice than it may begin with: with more of the largest good
# condition, and with one at hand that is this part of it. The next panel changes.
_SPOILT, _MUCH_BETTER = 2.0, 0.1
# Links that turn by less [rad] pass no two places where a choice fails.
_ONE_PLACE = 1.0


def serves(system: System, panel: Panel, start: FloatArray, end: FloatArray) -> bool:
    """True if the closures determine the dependent coordinates throughout a panel.

    A determinant that changes its sign has been zero. A block of condition c becomes singular only
    if links turn by some 1 / c.

    Args:
        start: Closure Jacobian at its start, shape (m, nv).
        end: The same at the end of the segment on it.
    """
    if not system.body.closure_rows:
        return True
    condition = system.condition(panel.split, end)
    if not condition < _SPOILT * system.good_condition:
        return False
    turns = system.turns(panel.q - panel.q[0])
    # The Euclidean norm bounds the largest element, and is found faster.
    if condition**2 * np.vdot(turns, turns) < 1.0:
        return True
    if turns.max() <= _ONE_PLACE:
        columns = panel.split.columns
        return same_sign(start.take(columns, 1), end.take(columns, 1))
    jacobians = np.concatenate([start[None], end[None], system.body.closures(panel.q)[1]])
    return _keeps_sign(jacobians, panel.split)


def suited_split(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    end: FloatArray,
    preferred: tuple[int, ...],
) -> Partition | None:
    """Dependent coordinates that serve throughout a panel on which its own do not.

    Args:
        end: Closure Jacobian at the end of the segment on it, shape (m, nv).
        preferred: Coordinates to keep independent where the closures allow it.

    Returns:
        The choice, its own if no other is much better where it is worst; None if another one is
        there, but not for the whole panel.
    """
    own = panel.split
    jacobians = np.concatenate([system.body.closures(panel.q)[1], end[None]])
    sizes = [system.condition(own, jacobian) for jacobian in jacobians]
    worst = jacobians[int(np.argmax(sizes))]
    try:
        weighed = worst * system.body.units
        other = partition(weighed, phase.given, preferred, system.good_condition)
    except SingularConfigurationError:
        # A dead centre, whatever the choice.
        return own if _keeps_sign(jacobians, own) else None
    if system.condition(other, worst) >= _MUCH_BETTER * max(sizes):
        return own if _keeps_sign(jacobians, own) else None
    good = max(system.condition(other, jacobian) for jacobian in jacobians) < system.good_condition
    return other if good and _keeps_sign(jacobians, other) else None


def _keeps_sign(jacobians: FloatArray, split: Partition) -> bool:
    """True if the determinant of the dependent block has one sign at all places."""
    signs = np.sign(np.linalg.det(jacobians[:, :, split.columns]))
    return bool((signs == signs[0]).all())
