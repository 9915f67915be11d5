"""Values, Jacobians and velocity terms of all constraints and coordinates of a machine.

With u = R' (P_b - P_a), the second point seen from the first body, a line keeps the part of u
across its direction at zero, and the part along it is a coordinate. Rows are the pins (x and z
each), the lines' parts across, the locks of turning, and then all coordinates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .machine import Machine

Array = np.ndarray


class Rows(NamedTuple):
    """At K states: values (K, R), Jacobian (K, R, 3 bodies), and J a + bias is their second rate.

    Attributes:
        value: Values of the rows.
        jacobian: By x, z and angle of each body but the frame.
        bias: Second rate without accelerations.
        points: Places of all points (K, P, 2).
        arms: Points seen from their centres of mass (K, P, 2).
    """

    value: Array
    jacobian: Array
    bias: Array
    points: Array
    arms: Array


def across(vectors: Array) -> Array:
    """Vectors of the plane turned counter-clockwise by a right angle."""
    return plane(-vectors[..., 1], vectors[..., 0])


def plane(x: Array, z: Array) -> Array:
    """Vectors of the plane of these components."""
    found = np.empty((*x.shape, 2))
    found[..., 0], found[..., 1] = x, z
    return found


def dot(one: Array, other: Array) -> Array:
    """Products of vectors of the plane."""
    return one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1]


class Geometry:
    """Evaluates the rows of one machine, many states at a time."""

    def __init__(self, machine: Machine) -> None:
        """Lay the constraints out as arrays."""
        self.machine = machine
        self.count = len(machine.links.bodies)
        self.centres = np.array([body.centre for body in machine.links.bodies])
        self.body = np.array([body for body, _ in machine.places], dtype=int)
        places = np.array([place for _, place in machine.places]).reshape(-1, 2)
        self.local = places - self.centres[self.body]
        # Slides alone may be drawn as one point.
        self.reach = max(float(np.hypot(*np.ptp(np.vstack([places, self.centres]), axis=0))), 0.01)
        pins, lines = machine.pins, machine.lines
        self.pin_ends = np.array([[p.first, p.second] for p in pins], dtype=int).reshape(-1, 2).T
        self.line_ends = np.array([[p.first, p.second] for p in lines], dtype=int).reshape(-1, 2).T
        self.directions = np.array([p.direction for p in lines]).reshape(-1, 2)
        self.offsets = np.array([p.offset for p in lines])
        joints = list(machine.coordinates.values())
        self.hinge_rows = [i for i, item in enumerate(joints) if isinstance(item, tuple)]
        self.slide_rows = [i for i, item in enumerate(joints) if not isinstance(item, tuple)]
        self.slide_lines = [item for item in joints if not isinstance(item, tuple)]
        hinges = [item for item in joints if isinstance(item, tuple)]
        self.hinges = np.array(hinges, dtype=int).reshape(-1, 2).T
        self.locks = np.array(machine.locks, dtype=int).reshape(-1, 2).T
        ends = np.cumsum([2 * len(pins), len(lines), len(machine.locks), len(joints)])
        self.constraints, self.size = int(ends[2]), int(ends[3])
        self.line_rows = np.arange(ends[0], ends[1])
        self.lock_rows = np.arange(ends[1], ends[2])
        self.turning_rows = self.constraints + np.array(self.hinge_rows, dtype=int)
        self.sliding_rows = self.constraints + np.array(self.slide_rows, dtype=int)
        self.sliding = np.array(self.slide_lines, dtype=int)
        self.every = np.arange(len(lines))
        self.pin_rows = [np.arange(axis, 2 * len(pins), 2) for axis in (0, 1)]

    def evaluate(self, q: Array, v: Array) -> Rows:
        """Evaluate all rows; q and v have shape (K, 3 (bodies - 1)), angles third."""
        K, n = len(q), self.count
        pose, rate = np.zeros((K, n, 3)), np.zeros((K, n, 3))
        pose[:, 1:], rate[:, 1:] = q.reshape(K, n - 1, 3), v.reshape(K, n - 1, 3)
        c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
        x, z = self.local[:, 0], self.local[:, 1]
        cp, sp = c[:, self.body], s[:, self.body]
        arms = plane(cp * x - sp * z, sp * x + cp * z)
        levers = across(arms)
        omega = rate[:, self.body, 2]
        points = pose[:, self.body, :2] + arms
        speeds = rate[:, self.body, :2] + omega[..., None] * levers
        falls = -(omega**2)[..., None] * arms
        value, bias = np.zeros((K, self.size)), np.zeros((K, self.size))
        jacobian = np.zeros((K, self.size, n, 3))
        self._pins(value, jacobian, bias, points, levers, falls)
        self._lines(value, jacobian, bias, (c, s), rate, points, speeds, levers, falls)
        for rows, (one, other) in (
            (self.lock_rows, self.locks),
            (self.turning_rows, self.hinges),
        ):
            value[:, rows] = pose[:, other, 2] - pose[:, one, 2]
            jacobian[:, rows, other, 2] = 1.0
            jacobian[:, rows, one, 2] = -1.0
        return Rows(value, jacobian[:, :, 1:].reshape(K, self.size, -1), bias, points, arms)

    def _pins(
        self, value: Array, jacobian: Array, bias: Array, points: Array, levers: Array, falls: Array
    ) -> None:
        """Second point less first one, x and z."""
        one, other = self.pin_ends
        for axis in (0, 1):
            rows = self.pin_rows[axis]
            value[:, rows] = points[:, other, axis] - points[:, one, axis]
            bias[:, rows] = falls[:, other, axis] - falls[:, one, axis]
            for end, sign in ((one, -1.0), (other, 1.0)):
                jacobian[:, rows, self.body[end], axis] = sign
                jacobian[:, rows, self.body[end], 2] = sign * levers[:, end, axis]

    def _lines(
        self, value: Array, jacobian: Array, bias: Array, turn: tuple[Array, Array], rate: Array,
        points: Array, speeds: Array, levers: Array, falls: Array,
    ) -> None:  # fmt: skip
        """Parts of u across and along the lines."""
        one, other = self.line_ends
        if not one.size:
            return
        first, second = self.body[one], self.body[other]
        r, r_dot = points[:, other] - points[:, one], speeds[:, other] - speeds[:, one]
        w = rate[:, first, 2][..., None]
        c, s = turn[0][:, first], turn[1][:, first]
        drop = falls[:, other] - falls[:, one] - 2.0 * w * across(r_dot) - w * w * r
        x, z = self.directions[:, 0], self.directions[:, 1]
        along = plane(c * x - s * z, s * x + c * z)
        chosen, slides = self.sliding, self.sliding_rows
        for rows, part, e in (
            (self.line_rows, self.every, across(along)),
            (slides, chosen, along[:, chosen]),
        ):
            a, b = first[part], second[part]
            value[:, rows] = dot(e, r[:, part])
            bias[:, rows] = dot(e, drop[:, part])
            jacobian[:, rows, b, :2] = e
            jacobian[:, rows, b, 2] = dot(e, levers[:, other[part]])
            jacobian[:, rows, a, :2] = -e
            jacobian[:, rows, a, 2] = -dot(e, levers[:, one[part]] + across(r[:, part]))
        value[:, slides] -= self.offsets[chosen]
