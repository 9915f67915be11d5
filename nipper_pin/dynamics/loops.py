"""The closures of a planar machine as sums of turned lengths, for many configurations at once.

In the plane a vector is a complex number z + i x, and turning it is a product. A point of a link
lies at the sum of exp(i phi_j) (l_j + d_j q_j) over the joints on its way: phi_j is the angle by
which the body behind joint j has turned, l_j leads from there to the next joint or to the point,
and d_j is the direction of a slide. A gap is the difference of two such sums, in the axes of a body
that turns; all that is constant in gaps and Jacobians is one matrix.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..arrays import FloatArray, product
from ..mechanism import joint_axis, joint_placements, supports

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

    def accelerations(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
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

    def _turned(self, q: FloatArray, slid: FloatArray | float) -> NDArray[np.complex128]:
        """Units turned with the bodies, then lengths turned with the slides.

        Args:
            q: Configurations, shape (N, nv).
            slid: The lengths, shape (N, slides), or one for all.

        Returns:
            Shape (N, joints + slides).
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
