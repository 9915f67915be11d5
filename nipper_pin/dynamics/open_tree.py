"""The tree of links with its loops cut: kinematics, energies and inverse dynamics."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin

from ..arrays import FloatArray, Vector, Vectors
from ..mechanism import Mechanism, joint_placements

PLANAR_ROWS_OF_A_POINT = (0, 2)
_PLANAR_ROWS_OF_A_TWIST = (0, 2, 4)
# Joints and links may share a name.
_LINK = pin.FrameType.BODY
_NO_FORCES = np.empty((0, 2))


class OpenTree:
    """Kinematics and dynamics of a mechanism's links without its cut joints.

    It owns the ``pin.Data`` of the plain algorithms. Arrays of states have shape (N, nv): one row a
    configuration. Coordinates are [rad] or [m].

    Attributes:
        nv: Number of coordinates.
        reach_m: Largest extent of the mechanism [m].
        units: Of each coordinate, as :attr:`Mechanism.units`, shape (nv,).
        unit_of: The same as plain numbers.
        scaled: Whether any of them is not one.
        closure_rows: Number of closure equations, two a cut joint, then one a coupling.
        cuts: Frames a and b of every cut joint.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        """Build model and data."""
        model = mechanism.model
        self.nv = int(model.nv)
        self.reach_m = mechanism.reach_m
        self.units = mechanism.units
        self.unit_of: list[float] = self.units.tolist()
        self.scaled = bool((self.units != 1.0).any())
        self._plain = pin.Model(model)
        self._plain_data = self._plain.createData()
        self._upper = np.triu(np.ones((self.nv, self.nv), dtype=bool))
        self._link_ids = [model.getJointId(joint.name) for joint in mechanism.joints]
        moves = {j.index: link for j, link in zip(mechanism.joints, self._link_ids, strict=True)}
        touching = ((stop.index, stop.contact) for stop in mechanism.stops)
        self._contacts = [(moves[index], contact) for index, contact in touching if contact]
        self.closure_rows = mechanism.closure_rows
        self._coupled = mechanism.coupling_rows
        self._couples = len(self._coupled) > 0
        self._frames_of_cuts = [
            [model.getFrameId(name, _LINK) for name in (closure.frame_a, closure.frame_b)]
            for closure in mechanism.closures
        ]
        self.cuts = [[model.frames[number] for number in pair] for pair in self._frames_of_cuts]
        ends = [(strut.frame_a, strut.frame_b) for strut in mechanism.struts]
        # Springs and dampers often have their points in common.
        names = list(dict.fromkeys(name for pair in ends for name in pair))
        numbers = [[names.index(name) for name in pair] for pair in ends]
        self._ends = np.array(numbers, dtype=np.intp).reshape(-1, 2)
        frames = [model.frames[model.getFrameId(name, _LINK)] for name in names]
        self._points = [(frame.parentJoint, frame.placement) for frame in frames]
        # 1 where a joint moves a point, shape (points, 1, nv); nothing moves the machine's frame.
        self._moving = np.zeros((len(frames), 1, self.nv))
        for moving, (joint, _) in zip(self._moving, self._points, strict=True):
            moving[0, [model.idx_vs[j] for j in model.supports[joint] if j]] = 1

    def inverse_dynamics(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Generalised forces M a + h of the bare links (no armature), shape (N, nv)."""
        model, data, solve = self._plain, self._plain_data, pin.rnea
        forces = np.empty_like(q)
        for row in range(len(q)):
            forces[row] = solve(model, data, q[row], v[row], a[row])
        return forces

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """Mass matrix M of the bare links at one configuration, shape (nv, nv)."""
        matrix: FloatArray = self.mass_matrices(q[None])[0]
        return matrix

    def mass_matrices(self, q: FloatArray) -> FloatArray:
        """Mass matrices M of the bare links, shape (N, nv, nv)."""
        matrices = np.empty((len(q), self.nv, self.nv))
        for row, matrix in zip(q, matrices, strict=True):
            matrix[:] = pin.crba(self._plain, self._plain_data, row)
        # Pinocchio fills the upper triangle only.
        return np.where(self._upper, matrices, np.swapaxes(matrices, 1, 2))

    def closure_accelerations(self, q: Vectors, v: Vectors, a: Vectors) -> FloatArray:
        """Accelerations G a + G_dot v with which the cut joints open [m/s2].

        Returns:
            Of the frames a against the frames b, in the axes of the frames a, shape (N, m).
        """
        model, data = self._plain, self._plain_data
        found = np.empty((len(q), self.closure_rows))
        found[:, 2 * len(self.cuts) :] = a @ self._coupled.T
        for row, apart in enumerate(found):
            pin.forwardKinematics(model, data, q[row], v[row], a[row])
            for place, (frame_a, frame_b) in enumerate(self._frames_of_cuts):
                frame = model.frames[frame_a]
                axes = data.oMi[frame.parentJoint].rotation @ frame.placement.rotation
                opening = self._acceleration(frame_a) - self._acceleration(frame_b)
                apart[2 * place : 2 * place + 2] = (opening @ axes)[list(PLANAR_ROWS_OF_A_POINT)]
        return found

    def _acceleration(self, frame: int) -> FloatArray:
        """Acceleration of a frame's origin in world axes, shape (3,)."""
        found: FloatArray = pin.getFrameClassicalAcceleration(
            self._plain, self._plain_data, frame, pin.LOCAL_WORLD_ALIGNED
        ).linear
        return found

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

    def link_velocities(self, q: Vector, v: Vector) -> tuple[FloatArray, FloatArray]:
        """Angular and centroid velocities of the links at one state.

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
            turning = (rotation @ data.v[joint].angular).item(1)
            x, _, z = (rotation @ model.inertias[joint].lever).tolist()
            linear = (rotation @ data.v[joint].linear).tolist()
            spin[row] = -turning
            centroid[row] = linear[0] + turning * z, linear[2] - turning * x
        return spin, centroid

    def placements(self, q: FloatArray) -> list[pin.SE3]:
        """World placements of the links at one configuration, in the order of the joints."""
        pin.forwardKinematics(self._plain, self._plain_data, q)
        return [pin.SE3(self._plain_data.oMi[joint]) for joint in self._link_ids]

    def points(self, q: Vectors) -> tuple[FloatArray, FloatArray]:
        """World places of the points of all struts, and their Jacobians.

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
            # The binding returns one column as a vector.
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
        q: Vector,
        v: Vector,
        a: Vector,
        closure_forces: FloatArray,
        point_forces: FloatArray = _NO_FORCES,
        contact_forces: FloatArray | None = None,
        weight: bool = True,
    ) -> tuple[FloatArray, FloatArray]:
        """Wrench that each joint's parent exerts on its child, and the cut joints' forces.

        Impulses [N s, N m s] are to the change of velocity of an impact what forces are to
        accelerations, without v and without weight.

        Args:
            closure_forces: Multipliers la_g, shape (m,) [N], in the axes of the frames a.
            point_forces: Forces (x, z) of the struts on the bodies of their points a, in world
                axes, shape (struts, 2) [N]; their opposites act at the points b.
            contact_forces: Normal forces of the stops with a contact point, in their order,
                shape (contacts,) [N]; none by default.

        Returns:
            Tree joints' wrenches (force x, force z [N], moment counter-clockwise about the joint
            [N m]) in world axes, shape (joints, 3); and the force that each cut joint exerts on
            the body of its frame a, in world axes, shape (closures, 2) [N].
        """
        outer, cut = self._outer(q, closure_forces, contact_forces)
        data = self._plain_data
        for (x, z), (end_a, end_b) in zip(point_forces, self._ends.tolist(), strict=True):
            (joint_a, local_a), (joint_b, local_b) = self._points[end_a], self._points[end_b]
            force = np.array([x, 0.0, z])
            self._push(outer, joint_a, data.oMi[joint_a].act(local_a.translation), force)
            self._push(outer, joint_b, data.oMi[joint_b].act(local_b.translation), -force)
        pin.rnea(self._plain if weight else self._weightless, data, q, v, a, outer)
        wrenches = np.empty((len(self._link_ids), 3))
        for row, joint in enumerate(self._link_ids):
            rotation = data.oMi[joint].rotation
            force = rotation @ data.f[joint].linear
            moment = rotation @ data.f[joint].angular
            wrenches[row] = force[0], force[2], -moment[1]
        return wrenches, cut

    def _outer(
        self, q: FloatArray, closure_forces: FloatArray, contact_forces: FloatArray | None
    ) -> tuple[pin.StdVec_Force, FloatArray]:
        """Forces past the joints: of cut joints and contacts; and those of the cut joints."""
        model, data = self._plain, self._plain_data
        pin.forwardKinematics(model, data, q)
        outer = pin.StdVec_Force()
        for _ in range(model.njoints):
            outer.append(pin.Force.Zero())
        cut = np.empty((len(self.cuts), 2))
        for number, (frame_a, frame_b) in enumerate(self.cuts):
            local = np.zeros(3)
            local[list(PLANAR_ROWS_OF_A_POINT)] = closure_forces[2 * number : 2 * number + 2]
            place_a = data.oMi[frame_a.parentJoint] * frame_a.placement
            place_b = data.oMi[frame_b.parentJoint] * frame_b.placement
            world = place_a.rotation @ local
            cut[number] = world[[0, 2]]
            self._push(outer, frame_a.parentJoint, place_a.translation, world)
            self._push(outer, frame_b.parentJoint, place_b.translation, -world)
        pushing = () if contact_forces is None else zip(contact_forces, self._lips, strict=True)
        for size, (joint, local, normal) in pushing:
            below = model.parents[joint]
            place, force = data.oMi[below].act(local), size * (data.oMi[below].rotation @ normal)
            self._push(outer, joint, place, force)
            self._push(outer, below, place, -force)
        return outer, cut

    @cached_property
    def _weightless(self) -> pin.Model:
        """The model without gravity, which impacts know nothing of."""
        model = pin.Model(self._plain)
        model.gravity = pin.Motion.Zero()
        return model

    @cached_property
    def _lips(self) -> list[tuple[int, FloatArray, FloatArray]]:
        """Of each stop with a contact point: its joint, point and normal in the lower body.

        The lower lip is on the body above the joint, so it turns with that.
        """
        model = self._plain
        world = joint_placements(model)
        lips = []
        for joint, contact in self._contacts:
            below = world[model.parents[joint]]
            local = below.actInv(contact.point)
            lips.append((joint, local, below.rotation.T @ contact.normal))
        return lips

    def _push(
        self, outer: pin.StdVec_Force, joint: int, point: FloatArray, force: FloatArray
    ) -> None:
        """Add a force at a world point to the outer forces on the body behind a joint, in place."""
        acting = pin.SE3(np.eye(3), point).act(pin.Force(force, np.zeros(3)))
        outer[joint] = outer[joint] + self._plain_data.oMi[joint].actInv(acting)
