"""Constrained dynamics and impulse dynamics of a mechanism with its loops closed.

The closures of a planar machine are sums of turned lengths, for many configurations at once. In the
plane a vector is a complex number z + i x, and turning it is a product. A point of a link
lies at the sum of exp(i phi_j) (l_j + d_j q_j) over the joints on its way: phi_j is the angle by
which the body behind joint j has turned, l_j leads from there to the next joint or to the point,
and d_j is the direction of a slide. A gap is the difference of two such sums, in the axes of a body
that turns; all that is constant in gaps and Jacobians is one matrix.

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
from collections.abc import Sequence
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..arrays import FloatArray, Vector, Vectors, product
from ..errors import SingularConfigurationError
from ..mechanism import Mechanism, Shared, joint_axis, joint_placements, supports
from ..tolerances.mechanics import (
    LIGHT_BODY_SHARE,
    PROXIMAL_CHANGE,
    PROXIMAL_REGULARISATION,
    PROXIMAL_RESIDUAL,
)
from .open_tree import PLANAR_ROWS_OF_A_POINT, OpenTree

_X, _Y, _Z = range(3)


class Loops:
    """Gaps of cut joints, their Jacobian and their accelerations.

    Args:
        model: The Pinocchio model, planar in (x, z).
        cuts: Frames a and b of every cut joint.
    """

    def __init__(self, model: pin.Model, cuts: Sequence[Sequence[pin.Frame]]) -> None:
        """Lay out the matrix that leads from turned units to gaps and Jacobians."""
        nv, joints, count = int(model.nv), int(model.njoints), len(cuts)
        self._places = joint_placements(model)
        axes = [np.zeros(6), *(joint_axis(model, self._places, j) for j in range(1, joints))]
        slides = [j for j in range(1, joints) if not round(axes[j][3 + _Y])]
        # Where a slide's way is among the turned lengths.
        self._rows = {joint: row for row, joint in enumerate(slides, start=joints)}
        self._columns = [int(model.joints[j].idx_v) for j in range(joints)]
        # Angles of bodies by coordinates, shape (nv, joints).
        self._turning = np.zeros((nv, joints))
        for body in range(1, joints):
            for joint in supports(model, body):
                self._turning[self._columns[joint], body] = round(axes[joint][3 + _Y])
        matrix = np.zeros((joints + len(slides), count, 1 + nv), dtype=np.complex128)
        self._signs = np.empty((count, 1))
        for cut, (frame_a, frame_b) in enumerate(cuts):
            for sign, frame in ((1.0, frame_a), (-1.0, frame_b)):
                self._add_way(matrix[:, cut], model, frame, sign, axes)
            own = (self._places[frame_a.parentJoint] * frame_a.placement).rotation
            matrix[:, cut] *= _planar(own[:, _Z]).conjugate()
            self._signs[cut] = round((_planar(own[:, _X]) / _planar(own[:, _Z])).imag)
        self._matrix = matrix.reshape(len(matrix), -1)
        self._gaps = np.ascontiguousarray(matrix[:, :, 0])
        self._joints, self._nv = joints, nv
        self._owners = np.array([frame.parentJoint for frame, _ in cuts], dtype=np.intp)
        self._slides = np.array(slides, dtype=np.intp)
        self._slid = np.array([self._columns[j] for j in slides], dtype=np.intp)

    def _add_way(
        self, matrix: NDArray[np.complex128], model: pin.Model, frame: pin.Frame, sign: float,
        axes: Sequence[FloatArray],
    ) -> None:  # fmt: skip
        """Add the way to the point of a frame, and its derivatives, to the columns of a cut."""
        chain = [0, *reversed(supports(model, frame.parentJoint))]
        points = [self._places[joint].translation for joint in chain]
        points.append((self._places[frame.parentJoint] * frame.placement).translation)
        for joint, here, there in zip(chain, points, points[1:], strict=False):
            lengths = {joint: sign * _planar(there - here)}
            if joint in self._rows:
                along = lengths[self._rows[joint]] = sign * _planar(axes[joint][:3])
                matrix[joint, 1 + self._columns[joint]] += along
            for row, length in lengths.items():
                matrix[row, 0] += length
                matrix[row, 1:] += 1j * length * self._turning[:, joint]

    def closures(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Closure gaps and their Jacobian, as :meth:`Multibody.closures`."""
        turned = self._turned(q, q.take(self._slid, 1))
        # There may be no configuration, and no closure.
        count, cuts = len(q), len(self._owners)
        apart = turned.dot(self._matrix).reshape(count, cuts, 1 + self._nv)
        apart *= turned.take(self._owners, 1).conj()[:, :, None]
        rows = np.empty((count, cuts, 2, 1 + self._nv))
        np.multiply(apart.imag, self._signs, rows[:, :, 0])
        rows[:, :, 1] = apart.real
        both: FloatArray = rows.reshape(count, 2 * cuts, 1 + self._nv)
        return both[:, :, 0], both[:, :, 1:]

    def accelerations(self, q: FloatArray, v: FloatArray, a: FloatArray) -> Vectors:
        """Accelerations of the gaps, as :meth:`OpenTree.closure_accelerations`."""
        turned, spin = self._turned(q, 1.0), product(v, self._turning)
        owners = turned.take(self._owners, 1).conj()
        whirl = np.empty_like(turned)
        bodies = whirl[:, : self._joints]
        bodies.real, bodies.imag = -spin * spin, product(a, self._turning)
        if len(self._slides):
            x, rate, pace = (states.take(self._slid, 1) for states in (q, v, a))
            way = bodies.take(self._slides, 1) * x + 2j * spin.take(self._slides, 1) * rate + pace
            whirl[:, self._joints :] = way
        apart = (turned * whirl).dot(self._gaps) * owners
        rows = np.empty((*apart.shape, 2))
        rows[:, :, 0], rows[:, :, 1] = apart.imag * self._signs[:, 0], apart.real
        return rows.reshape(len(q), 2 * len(self._owners))

    def _turned(self, q: Vectors, slid: FloatArray | float) -> NDArray[np.complex128]:
        """Units turned with the bodies, then lengths with the slides, shape (N, joints + slides).

        Args:
            slid: The lengths, shape (N, slides), or one for all.
        """
        angles = product(q, self._turning)
        turned = np.empty((len(q), len(self._matrix)), dtype=np.complex128)
        np.cos(angles, turned.real[:, : self._joints])
        np.sin(angles, turned.imag[:, : self._joints])
        if len(self._slides):
            turned[:, self._joints :] = turned.take(self._slides, 1) * slid
        return turned


def _planar(vector: FloatArray) -> complex:
    return complex(vector[_Z], vector[_X])


INFINITE_INERTIA = 2.0**100
_ITERATIONS = 200
# Configurations from which on all together are faster than each by Pinocchio.
_MANY = 4


_OF_THREAD = threading.local()


def multibody(mechanism: Mechanism) -> Multibody:
    """Return this thread's multibody system of a mechanism.

    Building one takes as long as thirty evaluations, and none keeps anything from one call to the
    next but its buffers, so all runs of a thread share it, and those of machines with other numbers
    of springs, dampers and restitutions.
    """
    known: WeakKeyDictionary[Shared, Multibody]
    known = vars(_OF_THREAD).setdefault("known", WeakKeyDictionary())
    shared = mechanism.shared
    if shared not in known:
        known[shared] = Multibody(mechanism)
    return known[shared]


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

    def closures(self, q: Vectors) -> tuple[FloatArray, FloatArray]:
        """Closure gaps and their Jacobian.

        Returns:
            g [m], shape (N, m): position of frame a minus that of frame b in the axes of frame a,
            and G = dg/dq (on the closure manifold), shape (N, m, nv).
        """
        model, data, pins, pin_data = self._flight, self._flight_data, self._pins, self._pin_data
        if self._couples:
            # Those of the couplings come after the pins.
            (gaps, jacobians), coupled = self._loops.closures(q), self._coupled
            below = np.broadcast_to(coupled, (len(q), *coupled.shape))
            gaps = np.concatenate([gaps, q @ coupled.T], axis=1)
            return gaps, np.concatenate([jacobians, below], axis=1)
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

    def closure_accelerations(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Accelerations G a + G_dot v, shape (N, m); as :meth:`OpenTree.closure_accelerations`."""
        if self.closure_rows and len(q) >= _MANY and not self._couples:
            return self._loops.accelerations(q, v, a)
        return super().closure_accelerations(q, v, a)

    @cached_property
    def _loops(self) -> Loops:
        return Loops(self._plain, self.cuts)

    def accelerations(
        self, q: Vectors, v: FloatArray, tau: FloatArray, armature: FloatArray
    ) -> FloatArray:
        """Constrained accelerations: M a + h = tau + G' la_g, G a + G_dot v = 0.

        Args:
            v: Velocities that satisfy G v = 0, shape (N, nv).
            tau: Generalised forces, shape (N, nv) [N m or N].
            armature: Inertia added to each joint, shape (nv,); ``INFINITE_INERTIA`` where the
                acceleration is prescribed as tau / armature.

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

    def refined(self, q: Vectors, v: FloatArray, a: Vectors, armature: FloatArray) -> Vectors:
        """Accelerations refined until G a + G_dot v = 0 to round-off.

        One step of iterative refinement, a - M^-1 G' (G M^-1 G')^-1 (G a + G_dot v): the
        closures give the acceleration of a light body more accurately than its forces do. With
        light bodies :meth:`accelerations` includes this step.

        Args:
            v: Velocities that satisfy G v = 0, shape (N, nv).
            armature: Inertia added to each joint, shape (nv,).
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
        self, q: Vector, rows: FloatArray, z: FloatArray, armature: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Smallest change of velocity, in the metric of M, that cancels the rate ``rows @ z``.

        Solves M delta = rows' P, rows (z + delta) = 0 by Pinocchio's impulse dynamics with zero
        restitution. Only z, not the whole velocity, goes in: the result keeps its relative
        precision however small the impact is, and each row may have its own restitution.

        Args:
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
