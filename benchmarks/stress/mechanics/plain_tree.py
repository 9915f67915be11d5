"""Kinematics and inverse dynamics of the links by Pinocchio's plain algorithms, on a copy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism, Strut

_PLANE = [0, 2]
_WORLD = pin.LOCAL_WORLD_ALIGNED


class Pull(NamedTuple):
    """A strut at one state.

    Attributes:
        strut: The strut.
        tension: Its pull [N].
        line: From its first point to its second (x, z) [m].
        length: Of the line [m], not zero.
        jacobian: Of the line, shape (2, nv).
    """

    strut: Strut
    tension: float
    line: FloatArray
    length: float
    jacobian: FloatArray


class PlainTree:
    """The tree of links of a mechanism with its loops cut."""

    def __init__(self, mechanism: Mechanism) -> None:
        """Copy the model and find the frames of closures and struts."""
        self._model = pin.Model(mechanism.model)
        self._data = self._model.createData()
        self.nv = int(self._model.nv)
        ends = [(item.frame_a, item.frame_b) for item in mechanism.closures]
        self._cuts = [(self._frame(a), self._frame(b)) for a, b in ends]
        self._struts = [
            (item, self._frame(item.frame_a), self._frame(item.frame_b))
            for item in mechanism.struts
        ]

    def closures(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gaps of the cut joints in world axes, shape (m,) [m], and their Jacobian, (m, nv)."""
        self._place(q)
        gaps = [self._at(a) - self._at(b) for a, b in self._cuts]
        rows = [self._jacobian(a) - self._jacobian(b) for a, b in self._cuts]
        none = np.empty((0, self.nv))
        return np.concatenate([np.empty(0), *gaps]), np.concatenate([none, *rows])

    def opening(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """G_dot v: accelerations with which the cut joints open while no rate changes [m/s2]."""
        pin.forwardKinematics(self._model, self._data, q, v, np.zeros(self.nv))
        parts = [self._acceleration(a) - self._acceleration(b) for a, b in self._cuts]
        return np.concatenate([np.empty(0), *parts])

    def mass(self, q: FloatArray) -> FloatArray:
        """Mass matrix of the links, shape (nv, nv)."""
        upper = np.triu(np.array(pin.crba(self._model, self._data, q)))
        return np.asarray(upper + np.triu(upper, 1).T)

    def held_back(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Coriolis, centrifugal and gravity forces h, shape (nv,)."""
        return np.array(pin.rnea(self._model, self._data, q, v, np.zeros(self.nv)))

    def pulls(self, q: FloatArray, v: FloatArray) -> Iterator[Pull]:
        """Springs and dampers between two points."""
        self._place(q)
        for strut, first, second in self._struts:
            line = self._at(second) - self._at(first)
            jacobian = self._jacobian(second) - self._jacobian(first)
            length = max(float(np.hypot(*line)), float(np.finfo(float).tiny))
            rate = float(line / length @ jacobian @ v)
            tension = strut.stiffness * (length - strut.free_length) + strut.damping * rate
            yield Pull(strut, tension, line, length, jacobian)

    def _acceleration(self, frame: int) -> FloatArray:
        found = pin.getFrameClassicalAcceleration(self._model, self._data, frame, _WORLD)
        return np.asarray(found.linear[_PLANE])

    def _place(self, q: FloatArray) -> None:
        pin.computeJointJacobians(self._model, self._data, q)
        pin.updateFramePlacements(self._model, self._data)

    def _at(self, frame: int) -> FloatArray:
        return np.array(self._data.oMf[frame].translation[_PLANE])

    def _jacobian(self, frame: int) -> FloatArray:
        found = pin.getFrameJacobian(self._model, self._data, frame, _WORLD)
        return np.asarray(found.reshape(6, self.nv)[_PLANE])

    def _frame(self, name: str) -> int:
        return int(self._model.getFrameId(name, pin.FrameType.BODY))
