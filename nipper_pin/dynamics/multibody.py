"""Constrained dynamics and impulse dynamics of a mechanism with its loops closed.

This module and ``open_tree`` own all ``pin.Data``: every call of Pinocchio's algorithms is in them.

Two facts of Pinocchio shape it. A planar pin as a 3-D point constraint has one dead row (out of the
plane), so the proximal form of the constrained dynamics is used, and explicit Jacobians keep the
two planar rows only. And the explicit-Jacobian algorithms (impulse dynamics) share buffers with the
constraint-model algorithms, so each family has its own model and data object.

Prescribed coordinates (held drives, closed stops) are joints of infinite inertia: with armature I
and force I * a the joint accelerates with a under any force. I is a power of two, so that the
product and the quotient are exact and a is met to the last bit but one.
"""

from __future__ import annotations

import math
import threading
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from ..arrays import FloatArray
from ..errors import SingularConfigurationError
from ..mechanism import Mechanism
from ..tolerances.mechanics import (
    LIGHT_BODY_SHARE,
    PROXIMAL_CHANGE,
    PROXIMAL_REGULARISATION,
    PROXIMAL_RESIDUAL,
)
from .loops import Loops
from .open_tree import PLANAR_ROWS_OF_A_POINT, OpenTree

INFINITE_INERTIA = 2.0**100
_ITERATIONS = 200
# Configurations from which on all together are faster than each by Pinocchio.
_MANY = 4
_OF_THREAD = threading.local()


def multibody(mechanism: Mechanism) -> Multibody:
    """Return this thread's multibody system of a mechanism.

    Building one takes as long as thirty evaluations, and none keeps anything from one call to the
    next but its buffers, so all runs of a thread share it.
    """
    known: WeakKeyDictionary[Mechanism, Multibody] | None
    known = getattr(_OF_THREAD, "known", None)
    if known is None:
        known = _OF_THREAD.known = WeakKeyDictionary()
    if mechanism not in known:
        known[mechanism] = Multibody(mechanism)
    return known[mechanism]


class Multibody(OpenTree):
    """Dynamics of a mechanism's tree with its closures, through Pinocchio.

    Arrays of states have shape (N, nv): one row a configuration. Coordinates are [rad] or [m].
    """

    def __init__(self, mechanism: Mechanism) -> None:
        """Build models and data."""
        super().__init__(mechanism)
        self._flight = pin.Model(mechanism.model)
        self._flight_data = self._flight.createData()
        self._impact = pin.Model(mechanism.model)
        self._impact_data = self._impact.createData()
        self._pins = pin.StdVec_RigidConstraintModel()
        self._pin_data = pin.StdVec_RigidConstraintData()
        for ends in self.cuts:
            constraint = pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                self._flight,
                *(item for end in ends for item in (end.parentJoint, end.placement)),
                pin.LOCAL,
            )
            self._pins.append(constraint)
            self._pin_data.append(constraint.createData())
        places = range(0, 2 * len(self.cuts), 2)
        self._constraints = list(zip(places, self._pins, self._pin_data, strict=True))
        pin.initConstraintDynamics(self._flight, self._flight_data, self._pins, self._pin_data)
        heaviest = max((inertia.mass for inertia in mechanism.model.inertias), default=0.0)
        mu = PROXIMAL_REGULARISATION / heaviest if heaviest > 0.0 else PROXIMAL_REGULARISATION
        residual = PROXIMAL_RESIDUAL * mechanism.unit_m
        self._proximal = pin.ProximalSettings(residual, PROXIMAL_CHANGE, mu, _ITERATIONS)
        self._planar_rows = np.array(
            [
                3 * number + row
                for number in range(len(mechanism.closures))
                for row in PLANAR_ROWS_OF_A_POINT
            ],
            dtype=np.intp,
        )
        self.evaluations = 0
        # Armature of the model in flight: a phase has the same array from panel to panel.
        self._armature: FloatArray | None = None
        sizes = [1.0 if joint.kind == "prismatic" else self.reach_m for joint in mechanism.joints]
        # Pinocchio's solution knows nothing of couplings.
        self._refines = self._couples or (
            self.closure_rows > 0 and self._lightest(np.array(sizes)) < LIGHT_BODY_SHARE * heaviest
        )

    def closures(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Closure gaps and their Jacobian.

        Args:
            q: Configurations, shape (N, nv).

        Returns:
            g [m], shape (N, m): position of frame a minus that of frame b in the axes of frame a,
            and G = dg/dq (on the closure manifold), shape (N, m, nv).
        """
        model, data, pins, pin_data = self._flight, self._flight_data, self._pins, self._pin_data
        if self._couples:
            return self._with_couplings(q)
        if self.closure_rows and len(q) >= _MANY:
            return self._loops.closures(q)
        gaps = np.empty((len(q), self.closure_rows))
        jacobians = np.empty((len(q), self.closure_rows, self.nv))
        if not self.closure_rows:
            return gaps, jacobians
        for row in range(len(q)):
            gap = gaps[row]
            pin.computeJointJacobians(model, data, q[row])
            # `calc` must run at this q before the Jacobian is read, or its placement is stale.
            for place, constraint, constraint_data in self._constraints:
                constraint.calc(model, data, constraint_data)
                x, _, z = constraint_data.c1Mc2.translation.tolist()
                gap[place], gap[place + 1] = -x, -z
            rows = pin.getConstraintsJacobian(model, data, pins, pin_data)
            # Otherwise numpy would write through a buffer.
            rows.take(self._planar_rows, 0, jacobians[row], "clip")
        return gaps, jacobians

    def _with_couplings(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gaps and Jacobian as :meth:`closures`, those of the couplings after the pins."""
        pins, coupled = self._loops.closures(q), self._coupled
        below = np.broadcast_to(coupled, (len(q), *coupled.shape))
        gaps = np.concatenate([pins[0], q @ coupled.T], axis=1)
        return gaps, np.concatenate([pins[1], below], axis=1)

    def closure_accelerations(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Accelerations G a + G_dot v, shape (N, m); as :meth:`OpenTree.closure_accelerations`."""
        if self.closure_rows and len(q) >= _MANY and not self._couples:
            return self._loops.accelerations(q, v, a)
        return super().closure_accelerations(q, v, a)

    @cached_property
    def _loops(self) -> Loops:
        return Loops(self._plain, self.cuts)

    def accelerations(
        self, q: FloatArray, v: FloatArray, tau: FloatArray, armature: FloatArray
    ) -> FloatArray:
        """Constrained accelerations: M a + h = tau + G' la_g, G a + G_dot v = 0.

        Args:
            q: Configurations, shape (N, nv).
            v: Velocities that satisfy G v = 0, shape (N, nv).
            tau: Generalised forces, shape (N, nv) [N m or N].
            armature: Inertia added to each joint, shape (nv,); ``INFINITE_INERTIA`` where the
                acceleration is prescribed as tau / armature.

        Returns:
            a, shape (N, nv).

        Raises:
            SingularConfigurationError: The closures lose rank.
        """
        model, data, pins, pin_data = self._flight, self._flight_data, self._pins, self._pin_data
        if armature is not self._armature:
            model.armature = self._armature = armature
        solve, proximal = pin.constraintDynamics, self._proximal
        a = np.empty(q.shape)
        for row in range(len(q)):
            a[row] = solve(model, data, q[row], v[row], tau[row], pins, pin_data, proximal)
            if proximal.iter >= _ITERATIONS:
                raise _singular(q[row])
        self.evaluations += len(q)
        # A sum of infinities of both signs would warn, and so would `dot` of what overflows.
        if not math.isfinite(np.vdot(a, a)):
            raise _singular(q)
        return self.refined(q, v, a, armature) if self._refines else a

    def refined(
        self, q: FloatArray, v: FloatArray, a: FloatArray, armature: FloatArray
    ) -> FloatArray:
        """Accelerations refined until G a + G_dot v = 0 to round-off.

        One step of iterative refinement, a - M^-1 G' (G M^-1 G')^-1 (G a + G_dot v): the
        closures give the acceleration of a light body more accurately than its forces do. With
        light bodies :meth:`accelerations` includes this step.

        Args:
            q: Configurations, shape (N, nv).
            v: Velocities that satisfy G v = 0, shape (N, nv).
            a: Accelerations, shape (N, nv).
            armature: Inertia added to each joint, shape (nv,).

        Returns:
            a, shape (N, nv).

        Raises:
            SingularConfigurationError: The closures lose rank.
        """
        _, jacobians = self.closures(q)
        residuals = self.closure_accelerations(q, v, a)[:, :, None]
        masses = self.mass_matrices(q)
        places = np.arange(self.nv)
        masses[:, places, places] += armature
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                response = np.linalg.solve(masses, np.swapaxes(jacobians, 1, 2))
                impulses = np.linalg.solve(jacobians @ response, residuals)
                found: FloatArray = a - (response @ impulses)[:, :, 0]
        except np.linalg.LinAlgError as error:
            raise _singular(q) from error
        if not math.isfinite(np.vdot(found, found)):
            raise _singular(q)
        return found

    def _lightest(self, sizes: FloatArray) -> float:
        """Smallest mass with which a coordinate resists in the touch configuration [kg].

        Args:
            sizes: Metres by which a unit of each coordinate moves its link, shape (nv,).
        """
        try:
            inverse = np.linalg.inv(self.mass_matrix(np.zeros(self.nv)))
        except np.linalg.LinAlgError:
            return 0.0
        return float((1.0 / np.diag(inverse) / sizes**2).min(initial=np.inf))

    def impulse_response(
        self, q: FloatArray, rows: FloatArray, z: FloatArray, armature: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Smallest change of velocity, in the metric of M, that cancels the rate ``rows @ z``.

        Solves M delta = rows' P, rows (z + delta) = 0 by Pinocchio's impulse dynamics with zero
        restitution. Only z, not the whole velocity, goes in: the result keeps its relative
        precision however small the impact is, and each row may have its own restitution.

        Args:
            q: Configuration, shape (nv,).
            rows: Independent constraint rows, shape (r, nv).
            z: Velocity whose rates along the rows are to be cancelled, shape (nv,).
            armature: Inertia added to each joint, shape (nv,).

        Returns:
            delta, shape (nv,), and the impulses P, shape (r,) [N s or N m s].
        """
        self._impact.armature = armature
        after = pin.impulseDynamics(self._impact, self._impact_data, q, z, rows, 0.0, 0.0)
        return after - z, np.array(self._impact_data.impulse_c)


def _singular(q: FloatArray) -> SingularConfigurationError:
    message = (
        "the constrained dynamics has no solution here: the closures lose rank; "
        "keep the mechanism away from this dead centre"
    )
    return SingularConfigurationError(message, q=q)
