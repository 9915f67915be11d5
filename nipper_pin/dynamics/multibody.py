"""The only owner of ``pin.Data``: every call of Pinocchio's algorithms is in this module.

Two facts of Pinocchio shape it. A planar pin as a 3-D point constraint has one dead row (out of the
plane), so the proximal form of the constrained dynamics is used, and explicit Jacobians keep the
two planar rows only. And the explicit-Jacobian algorithms (impulse dynamics) share buffers with the
constraint-model algorithms, so each family has a model and a data object of its own.

Prescribed coordinates (held drives, closed stops) are joints of infinite inertia: with armature I
and force I * a the joint accelerates with a, whatever pulls at it. I is a power of two, so that the
product and the quotient are exact and a is met to the last bit but one.
"""

from __future__ import annotations

import math
import threading
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from ..arrays import FloatArray
from ..errors import SingularConfigurationError
from ..mechanism import Mechanism

INFINITE_INERTIA = 2.0**100
_PLANAR_ROWS_OF_A_PIN = (0, 2)
_PLANAR_ROWS_OF_A_TWIST = (0, 2, 4)
# The regularisation only has to keep the dead row from dividing by zero; the proximal iteration
# removes its effect on the live rows. The smallest eigenvalue of G M^-1 G' is that of the heaviest
# body, divided by the square of the closures' condition near a dead centre: beside it the
# regularisation must be small, or the iteration does not get there.
_REGULARISATION, _ACCURACY, _ITERATIONS = 1e-14, 1e-14, 200
# A body that resists with less than this share of the heaviest one's mass is light: forces that
# balance but for round-off accelerate it.
_LIGHT = 1e-7
_OF_THREAD = threading.local()
_NO_FORCES = np.empty((0, 2))


def multibody(mechanism: Mechanism) -> Multibody:
    """Return this thread's multibody system of a mechanism.

    Building one takes as long as thirty evaluations, and none keeps anything from one call to the
    next but its buffers, so all runs of a thread share it.

    Args:
        mechanism: The mechanism.
    """
    known: WeakKeyDictionary[Mechanism, Multibody] | None
    known = getattr(_OF_THREAD, "known", None)
    if known is None:
        known = _OF_THREAD.known = WeakKeyDictionary()
    if mechanism not in known:
        known[mechanism] = Multibody(mechanism)
    return known[mechanism]


class Multibody:
    """Kinematics and dynamics of a mechanism's tree with its closures, through Pinocchio.

    Arrays of states have shape (N, nv): one row a configuration. Coordinates are [rad] or [m].

    Args:
        mechanism: The mechanism.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        """Build models and data."""
        self.nv = int(mechanism.model.nv)
        self.closure_rows = 2 * len(mechanism.closures)
        self._link_ids = [mechanism.model.getJointId(joint.name) for joint in mechanism.joints]
        self._plain = pin.Model(mechanism.model)
        self._plain_data = self._plain.createData()
        self._upper = np.triu(np.ones((self.nv, self.nv), dtype=bool))
        self._flight = pin.Model(mechanism.model)
        self._flight_data = self._flight.createData()
        self._impact = pin.Model(mechanism.model)
        self._impact_data = self._impact.createData()
        self._pins = pin.StdVec_RigidConstraintModel()
        self._pin_data = pin.StdVec_RigidConstraintData()
        self._ends_of_closures = [
            [mechanism.model.getFrameId(name) for name in (closure.frame_a, closure.frame_b)]
            for closure in mechanism.closures
        ]
        for closure in mechanism.closures:
            frame_a, frame_b = (
                mechanism.model.frames[mechanism.model.getFrameId(name)]
                for name in (closure.frame_a, closure.frame_b)
            )
            constraint = pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                self._flight,
                frame_a.parentJoint,
                frame_a.placement,
                frame_b.parentJoint,
                frame_b.placement,
                pin.LOCAL,
            )
            self._pins.append(constraint)
            self._pin_data.append(constraint.createData())
        places = range(0, self.closure_rows, 2)
        self._constraints = list(zip(places, self._pins, self._pin_data, strict=True))
        pin.initConstraintDynamics(self._flight, self._flight_data, self._pins, self._pin_data)
        heaviest = max((inertia.mass for inertia in mechanism.model.inertias), default=0.0)
        mu = _REGULARISATION / heaviest if heaviest > 0.0 else _REGULARISATION
        self._proximal = pin.ProximalSettings(_ACCURACY, mu, _ITERATIONS)
        self._planar_rows = np.array(
            [
                3 * number + row
                for number in range(len(mechanism.closures))
                for row in _PLANAR_ROWS_OF_A_PIN
            ],
            dtype=np.intp,
        )
        ends = [(strut.frame_a, strut.frame_b) for strut in mechanism.struts]
        # Springs and dampers often have their points in common.
        names = list(dict.fromkeys(name for pair in ends for name in pair))
        numbers = [[names.index(name) for name in pair] for pair in ends]
        self._ends = np.array(numbers, dtype=np.intp).reshape(-1, 2)
        frames = [
            mechanism.model.frames[mechanism.model.getFrameId(name, pin.FrameType.BODY)]
            for name in names
        ]
        self._points = [(frame.parentJoint, frame.placement) for frame in frames]
        # 1 where a joint moves a point, shape (points, 1, nv); nothing moves the machine's frame.
        self._moving = np.zeros((len(frames), 1, self.nv))
        for moving, (joint, _) in zip(self._moving, self._points, strict=True):
            moving[0, [mechanism.model.idx_vs[j] for j in mechanism.model.supports[joint] if j]] = 1
        self.reach_m = mechanism.reach_m
        self.evaluations = 0
        sizes = [1.0 if joint.kind == "prismatic" else self.reach_m for joint in mechanism.joints]
        self._refines = (
            self.closure_rows > 0 and self._lightest(np.array(sizes)) < _LIGHT * heaviest
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
        gaps = np.empty((len(q), self.closure_rows))
        jacobians = np.empty((len(q), self.closure_rows, self.nv))
        if not self.closure_rows:
            return gaps, jacobians
        for q_row, gap, jacobian in zip(q, gaps, jacobians, strict=True):
            pin.computeJointJacobians(model, data, q_row)
            # `calc` must run at this q before the Jacobian is read, or its placement is stale.
            for place, constraint, constraint_data in self._constraints:
                constraint.calc(model, data, constraint_data)
                x, _, z = constraint_data.c1Mc2.translation.tolist()
                gap[place], gap[place + 1] = -x, -z
            rows = pin.getConstraintsJacobian(model, data, pins, pin_data)
            rows.take(self._planar_rows, 0, jacobian)
        return gaps, jacobians

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
        model.armature = armature
        solve, proximal = pin.constraintDynamics, self._proximal
        a = np.empty_like(q)
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
        """Accelerations without what round-off leaves of the closures in them.

        One step of iterative refinement, a - M^-1 G' (G M^-1 G')^-1 (G a + G_dot v): a light body
        moves as the heavy ones let it, which their accelerations tell better than its forces. Of
        machines with light bodies :meth:`accelerations` does so itself.

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
        model, data = self._plain, self._plain_data
        _, jacobians = self.closures(q)
        residuals = np.empty((len(q), self.closure_rows, 1))
        for row, residual in enumerate(residuals):
            pin.forwardKinematics(model, data, q[row], v[row], a[row])
            for place, (frame_a, frame_b) in enumerate(self._ends_of_closures):
                frame = model.frames[frame_a]
                axes = data.oMi[frame.parentJoint].rotation @ frame.placement.rotation
                apart = _acceleration(model, data, frame_a) - _acceleration(model, data, frame_b)
                residual[2 * place : 2 * place + 2, 0] = (apart @ axes)[[0, 2]]
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

    def inverse_dynamics(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Generalised forces M a + h of the bare links (no armature), shape (N, nv)."""
        return np.array(
            [pin.rnea(self._plain, self._plain_data, *state) for state in zip(q, v, a, strict=True)]
        ).reshape(q.shape)

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

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """Mass matrix M of the bare links at one configuration, shape (nv, nv)."""
        matrix: FloatArray = self.mass_matrices(q[None])[0]
        return matrix

    def mass_matrices(self, q: FloatArray) -> FloatArray:
        """Mass matrices M of the bare links, shape (N, nv, nv)."""
        matrices = np.empty((len(q), self.nv, self.nv))
        for row, matrix in zip(q, matrices, strict=True):
            matrix[:] = pin.crba(self._plain, self._plain_data, row)
        # What lies below the diagonal is not filled in.
        return np.where(self._upper, matrices, np.swapaxes(matrices, 1, 2))

    def kinetic_energy(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Kinetic energy of the links [J], shape (N,)."""
        return np.array(
            [
                pin.computeKineticEnergy(self._plain, self._plain_data, *state)
                for state in zip(q, v, strict=True)
            ]
        )

    def gravity_energy(self, q: FloatArray) -> FloatArray:
        """Potential energy of gravity [J], shape (N,)."""
        return np.array(
            [pin.computePotentialEnergy(self._plain, self._plain_data, row) for row in q]
        )

    def link_velocities(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angular and centroid velocities of the links at one state.

        Args:
            q: Configuration, shape (nv,).
            v: Velocity, shape (nv,).

        Returns:
            Angular velocities, counter-clockwise in the side view, shape (links,) [rad/s], and
            centroid velocities (x, z), shape (links, 2) [m/s].
        """
        model, data = self._plain, self._plain_data
        pin.forwardKinematics(model, data, q, v)
        spin = np.empty(len(self._link_ids))
        centroid = np.empty((len(self._link_ids), 2))
        for row, joint in enumerate(self._link_ids):
            rotation = data.oMi[joint].rotation
            angular = rotation @ data.v[joint].angular
            arm = rotation @ model.inertias[joint].lever
            linear = rotation @ data.v[joint].linear + np.cross(angular, arm)
            spin[row] = -angular[1]
            centroid[row] = linear[[0, 2]]
        return spin, centroid

    def placements(self, q: FloatArray) -> list[pin.SE3]:
        """World placements of the links at one configuration, in the order of the joints."""
        pin.forwardKinematics(self._plain, self._plain_data, q)
        return [pin.SE3(self._plain_data.oMi[joint]) for joint in self._link_ids]

    def points(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """World places of the points of all struts, and their Jacobians.

        Args:
            q: Configurations, shape (N, nv).

        Returns:
            Places (x, z), shape (N, struts, 2, 2) [m], the third axis being points a and b; and
            their derivatives by q, shape (N, struts, 2, 2, nv).
        """
        model, data = self._plain, self._plain_data
        places = np.empty((len(q), len(self._points), 2))
        # Rates of the points of all links at the world's origin (x, z), and of turning (y).
        twists = np.empty((len(q), 3, self.nv))
        for q_row, place, twist in zip(q, places, twists, strict=True):
            pin.computeJointJacobians(model, data, q_row)
            # Of one column the binding makes a vector.
            data.J.reshape(6, self.nv).take(_PLANAR_ROWS_OF_A_TWIST, 0, twist)
            for number, (joint, placement) in enumerate(self._points):
                x, _, z = data.oMi[joint].act(placement.translation).tolist()
                place[number] = x, z
        arms = places[:, :, :, None]
        turning = twists[:, None, 2, None, :] * self._moving
        jacobians = twists[:, None, :2] * self._moving
        jacobians[:, :, :1] += turning * arms[:, :, 1:]
        jacobians[:, :, 1:] -= turning * arms[:, :, :1]
        return places[:, self._ends], jacobians[:, self._ends]

    def joint_wrenches(
        self,
        q: FloatArray,
        v: FloatArray,
        a: FloatArray,
        closure_forces: FloatArray,
        point_forces: FloatArray = _NO_FORCES,
    ) -> tuple[FloatArray, FloatArray]:
        """Wrench that each joint's parent exerts on its child, and the cut joints' forces.

        Args:
            q: Configuration, shape (nv,).
            v: Velocity, shape (nv,).
            a: Acceleration, shape (nv,).
            closure_forces: Multipliers la_g, shape (m,) [N], in the axes of the frames a.
            point_forces: Forces (x, z) of the struts on the bodies of their points a, in world
                axes, shape (struts, 2) [N]; their opposites act at the points b.

        Returns:
            Tree joints' wrenches (force x, force z [N], moment counter-clockwise about the joint
            [N m]) in world axes, shape (joints, 3); and the force that each cut joint exerts on
            the body of its frame a, in world axes, shape (closures, 2) [N].
        """
        model, data = self._plain, self._plain_data
        pin.forwardKinematics(model, data, q)
        outer = pin.StdVec_Force()
        for _ in range(model.njoints):
            outer.append(pin.Force.Zero())
        cut = np.empty((len(self._pins), 2))
        for number, constraint in enumerate(self._pins):
            local = np.zeros(3)
            local[list(_PLANAR_ROWS_OF_A_PIN)] = closure_forces[2 * number : 2 * number + 2]
            place_a = data.oMi[constraint.joint1_id] * constraint.joint1_placement
            place_b = data.oMi[constraint.joint2_id] * constraint.joint2_placement
            world = place_a.rotation @ local
            cut[number] = world[[0, 2]]
            self._push(outer, constraint.joint1_id, place_a.translation, world)
            self._push(outer, constraint.joint2_id, place_b.translation, -world)
        for (x, z), (end_a, end_b) in zip(point_forces, self._ends.tolist(), strict=True):
            (joint_a, local_a), (joint_b, local_b) = self._points[end_a], self._points[end_b]
            force = np.array([x, 0.0, z])
            self._push(outer, joint_a, data.oMi[joint_a].act(local_a.translation), force)
            self._push(outer, joint_b, data.oMi[joint_b].act(local_b.translation), -force)
        pin.rnea(model, data, q, v, a, outer)
        wrenches = np.empty((len(self._link_ids), 3))
        for row, joint in enumerate(self._link_ids):
            rotation = data.oMi[joint].rotation
            force = rotation @ data.f[joint].linear
            moment = rotation @ data.f[joint].angular
            wrenches[row] = force[0], force[2], -moment[1]
        return wrenches, cut

    def _push(
        self, outer: pin.StdVec_Force, joint: int, point: FloatArray, force: FloatArray
    ) -> None:
        """Add a force at a world point to the outer forces on the body behind a joint, in place."""
        acting = pin.SE3(np.eye(3), point).act(pin.Force(force, np.zeros(3)))
        outer[joint] = outer[joint] + self._plain_data.oMi[joint].actInv(acting)


def _acceleration(model: pin.Model, data: pin.Data, frame: int) -> FloatArray:
    """Acceleration of a frame's origin in world axes, shape (3,)."""
    axes = pin.LOCAL_WORLD_ALIGNED
    found: FloatArray = pin.getFrameClassicalAcceleration(model, data, frame, axes).linear
    return found


def _singular(q: FloatArray) -> SingularConfigurationError:
    message = (
        "the constrained dynamics has no solution here: the closures lose rank; "
        "keep the mechanism away from this dead centre"
    )
    return SingularConfigurationError(message, q=q)
