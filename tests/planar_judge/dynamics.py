"""Accelerations, forces, impulses and projections of a machine in motion, from bordered matrices.

M a = Q + J' la, J a + bias = what is prescribed. An inertial drive is one more body, its shaft,
which turns with its inertia and is tied to the driven coordinate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .geometry import Geometry, Rows, across
from .machine import Machine, Stop, Strut
from .verdict import Reason, Refusal

Array = np.ndarray
# Rows of constraint, of unit length in lengths of the machine, that are this near to dependence.
SINGULAR = 1e-7
# A turning inertia below this share of the machine's is scaled as if it were as large.
_SMALL = 1e-12


class Forces(NamedTuple):
    """Accelerations (K, n) and multipliers (K, rows) at K states."""

    a: Array
    multipliers: Array
    rows: Rows


class Dynamics:
    """One machine at one signed rate of the input shaft [rad/s], from an angle of it on [rad].

    Drives are prescribed if they are held; else they are inertial.
    """

    def __init__(self, machine: Machine, rate: float, start: float, held: bool) -> None:
        """Lay masses and scales out."""
        self.machine, self.rate, self.start, self.held = machine, rate, start, held
        self.geometry = Geometry(machine)
        self._known: tuple[bytes, Array] = (b"", np.empty(0))
        self._latest: tuple[Any, ...] = (None, None, None)
        bodies = machine.links.bodies[1:]
        self.shafts = 0 if held else len(machine.drives)
        self.bodies = 3 * len(bodies)
        self.size = self.bodies + self.shafts
        shafts = [] if held else [drive.inertia for drive in machine.drives]
        self.mass = np.array([m for b in bodies for m in (b.mass, b.mass, b.inertia)] + shafts)
        self.weight = np.zeros(self.size)
        gravity = machine.links.steepness * machine.document["gravity_m_s2"]
        self.weight[1 : self.bodies : 3] = [-gravity * body.mass for body in bodies]
        reach = self.geometry.reach
        floor = _SMALL * max(body.mass for body in bodies) * reach**2
        self.scale = 1.0 / np.sqrt(np.maximum(self.mass, floor))
        # Bodies whose turning does not count may have an inertia of next to nothing.
        self.regular = bool((np.abs(self.mass * self.scale**2 - 1.0) < 1e-9).all())
        turning = [machine.turns(list(machine.coordinates)[d.coordinate]) for d in machine.drives]
        self.unit = np.array(
            [reach, reach, 1.0] * len(bodies)
            + [1.0 if turns else reach for turns in turning][: len(shafts)]
        )
        self.drive_rows = self.geometry.constraints + np.array(
            [drive.coordinate for drive in machine.drives], dtype=int
        )
        self.base = np.concatenate([np.arange(self.geometry.constraints), self.drive_rows])
        self.stop_rows = {
            stop.name: self.geometry.constraints + stop.coordinate for stop in machine.stops
        }

    def chosen(self, stops: Sequence[Stop]) -> Array:
        """Numbers of the rows of constraints, drives and these stops."""
        rows = [self.stop_rows[stop.name] for stop in stops]
        return np.concatenate([self.base, np.array(rows, dtype=int)])

    def laws(self, t: Array) -> Array:
        """Driven coordinates, rates and accelerations, shape (3, K, drives)."""
        key = t.tobytes()
        if key == self._known[0]:
            return self._known[1]
        found = np.zeros((3, len(t), len(self.machine.drives)))
        for column, drive in enumerate(self.machine.drives):
            for row, time in enumerate(t):
                value, first, second = drive.law.motion(self.start + self.rate * time)
                found[:, row, column] = (
                    value - drive.at_touch, first * self.rate, second * self.rate**2
                )  # fmt: skip
        # The iterations of a step ask for the same times again and again.
        self._known = key, found
        return found

    def evaluate(self, q: Array, v: Array) -> Rows:
        """Rows of the machine, with the columns of the shafts."""
        if q is self._latest[0] and v is self._latest[1]:
            return self._latest[2]
        rows = self.geometry.evaluate(q[:, : self.bodies], v[:, : self.bodies])
        if self.shafts:
            jacobian = np.concatenate(
                [rows.jacobian, np.zeros((*rows.jacobian.shape[:2], self.shafts))], axis=2
            )
            rows = rows._replace(jacobian=jacobian)
        # What ends a step is asked stop by stop.
        self._latest = q, v, rows
        return rows

    def restrained(self, rows: Rows, q: Array, stops: Sequence[Stop]) -> tuple[Array, Array]:
        """Jacobian and values of the chosen rows; drives less their shafts."""
        chosen = self.chosen(stops)
        jacobian, value = rows.jacobian[:, chosen], rows.value[:, chosen]
        first = self.geometry.constraints
        for column in range(self.shafts):
            jacobian[:, first + column, self.bodies + column] = -1.0
            value[:, first + column] -= q[:, self.bodies + column]
        for column, stop in enumerate(stops, start=len(self.base)):
            value[:, column] -= stop.at
        return jacobian, value

    def forces(self, laws: Array, rows: Rows, q: Array, v: Array) -> Array:
        """Applied forces Q, shape (K, n)."""
        Q = np.repeat(self.weight[None], len(q), axis=0)
        first = self.geometry.constraints
        for spring in self.machine.springs:
            row = rows.jacobian[:, first + spring.coordinate]
            x = rows.value[:, first + spring.coordinate]
            force = spring.stiffness * (spring.preload + x)
            if spring.damping:
                force = force + spring.damping * np.einsum("ki,ki->k", row, v)
            if spring.table is not None:
                force = force + spring.table(x)
            Q -= force[:, None] * row
        for strut in self.machine.struts:
            self._strut(strut, Q, rows, v)
        for column, drive in enumerate(self.machine.drives if self.shafts else ()):
            place, w = self.bodies + column, drive.frequency
            Q[:, place] += drive.inertia * (
                laws[2, :, column] + w * w * (laws[0, :, column] - q[:, place])
                + 2.0 * drive.damping * w * (laws[1, :, column] - v[:, place])
            )  # fmt: skip
        return Q

    def _strut(self, strut: Strut, Q: Array, rows: Rows, v: Array) -> None:
        """Pull two points together."""
        ends = (strut.first, strut.second)
        line = rows.points[:, ends[1]] - rows.points[:, ends[0]]
        length = np.hypot(line[:, 0], line[:, 1])
        safe = np.where(length > 0.0, length, 1.0)
        pushes = np.zeros((len(Q), 2, self.size))
        for side, end in enumerate(ends):
            body = self.geometry.body[end]
            if body:
                place = 3 * (body - 1)
                sign = 1.0 if side == 0 else -1.0
                lever = across(rows.arms[:, end])
                pushes[:, side, place : place + 2] = sign * line
                pushes[:, side, place + 2] = sign * np.einsum("ki,ki->k", lever, line)
        row = pushes.sum(axis=1)
        # The row is minus l times the gradient of l.
        tension = strut.stiffness * (1.0 - strut.free / safe)
        tension = tension - strut.damping * np.einsum("ki,ki->k", row, v) / safe**2
        Q += tension[:, None] * row

    def accelerate(self, t: Array, q: Array, v: Array, stops: Sequence[Stop]) -> Forces:
        """Accelerations with these stops closed."""
        laws, rows = self.laws(t), self.evaluate(q, v)
        J, _ = self.restrained(rows, q, stops)
        wanted = -rows.bias[:, self.chosen(stops)]
        if self.held:
            wanted[:, self.geometry.constraints : len(self.base)] += laws[2]
        a, multipliers = self.solve(J, self.forces(laws, rows, q, v), wanted)
        return Forces(a, multipliers, rows)

    def solve(
        self, J: Array, Q: Array, wanted: Array, *, unit: bool = False
    ) -> tuple[Array, Array]:
        """x and la of M x = Q + J' la, J x = wanted; ``unit`` takes the scaled unit mass."""
        K, m, n = J.shape
        JD = J * self.scale
        size = np.sqrt(np.einsum("kmn,kmn->km", JD, JD))
        size[size == 0.0] = 1.0
        JD /= size[..., None]
        if unit or self.regular:
            return self._projected(JD, size, Q, wanted)
        matrix = np.zeros((K, n + m, n + m))
        place = np.arange(n)
        matrix[:, place, place] = self.mass * self.scale**2
        matrix[:, :n, n:] = -np.swapaxes(JD, 1, 2)
        matrix[:, n:, :n] = JD
        right = np.concatenate([Q * self.scale, wanted / size], axis=1)
        try:
            found = np.linalg.solve(matrix, right[..., None])[..., 0]
        except np.linalg.LinAlgError as error:
            raise Refusal(Reason.SINGULAR, "the constraints depend on one another") from error
        return found[:, :n] * self.scale, found[:, n:] / size

    def _projected(self, JD: Array, size: Array, Q: Array, wanted: Array) -> tuple[Array, Array]:
        """The same where the scaled mass is one, by an orthogonal basis of the rows.

        A bordered matrix has the square of the rows' condition number, this has the number itself.
        """
        if JD.shape[1] > JD.shape[2]:
            raise Refusal(Reason.SINGULAR, "there are more constraints than coordinates")
        forces = Q * self.scale
        try:
            basis, upper = np.linalg.qr(np.swapaxes(JD, 1, 2))
            lower = np.swapaxes(upper, 1, 2)
            part = np.linalg.solve(lower, (wanted / size)[..., None])
            part = part - np.einsum("knm,kn->km", basis, forces)[..., None]
            multipliers = np.linalg.solve(upper, part)[..., 0]
        except np.linalg.LinAlgError as error:
            raise Refusal(Reason.SINGULAR, "the constraints depend on one another") from error
        x = forces + np.einsum("knm,km->kn", basis, part[..., 0])
        return x * self.scale, multipliers / size

    def independence(self, q: Array, stops: Sequence[Stop]) -> float:
        """Smallest singular value over the largest of the rows of constraint, over all states."""
        J, _ = self.restrained(self.evaluate(q, np.zeros_like(q)), q, stops)
        J = J * self.unit
        if not J.shape[1]:
            return 1.0
        if J.shape[1] > J.shape[2]:
            return 0.0
        size = np.linalg.norm(J, axis=2, keepdims=True)
        values = np.linalg.svd(J / np.where(size > 0.0, size, 1.0), compute_uv=False)
        return float((values[:, -1] / values[:, 0]).min())

    def targets(self, t: float, stops: Sequence[Stop]) -> tuple[Array, Array]:
        """What the chosen rows and their rates have to be."""
        places, rates = np.zeros(len(self.base) + len(stops)), np.zeros(len(self.base) + len(stops))
        if self.held:
            laws = self.laws(np.array([t]))
            span = slice(self.geometry.constraints, len(self.base))
            places[span], rates[span] = laws[0, 0], laws[1, 0]
        return places, rates

    def project(self, t: float, q: Array, v: Array, stops: Sequence[Stop]) -> tuple[Array, Array]:
        """The nearest state, in the metric of the masses, that meets all rows of constraint."""
        places, rates = self.targets(t, stops)
        q, best = q[None].copy(), math.inf
        nothing = np.zeros_like(q)
        for _ in range(30):
            J, value = self.restrained(self.evaluate(q, nothing), q, stops)
            error = places - value
            worst = float(np.abs(error).max(initial=0.0))
            if worst == 0.0 or (worst >= 0.5 * best and worst < 1e-13) or not math.isfinite(worst):
                break
            best = worst
            q = q + self.solve(J, nothing, error, unit=True)[0]
        if not worst < 1e-12 * max(1.0, self.geometry.reach):
            raise Refusal(Reason.ASSEMBLY, f"constraints stay open by {worst:.2g}")
        J, _ = self.restrained(self.evaluate(q, nothing), q, stops)
        v = v[None]
        for _ in range(2):
            v = v + self.solve(J, nothing, rates - np.einsum("kmn,kn->km", J, v), unit=True)[0]
        return q[0], v[0]
