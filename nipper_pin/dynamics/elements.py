"""Springs and dampers that are not linear in the state: tables on joints, and struts.

A strut joins two points a and b. With d = b - a, l = |d|, u = d / l and G_d = dd/dq,

    T = k (l - l_0) + c l_dot,      l_dot = u' G_d v,      tau = -G_d' (T u),
    energy k (l - l_0)^2 / 2,       dissipated power c l_dot^2.

A table f on the coordinate x gives tau = -f(x) and stores its integral; a force law gives
tau = -f(x, x_dot), its energy and its heat. All of this is a function of (q, v) alone.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, Times, Vectors
from ..errors import ElementError
from ..mechanism import Mechanism
from ..tolerances.mechanics import COINCIDENT_M, HEAT_ROUND_OFF, TABLE_END_OVERRUN
from ..units import DEG_PER_RAD, MM_PER_M
from .multibody import Multibody


class Elements:
    """Forces, energy and losses of tables, struts and force laws."""

    def __init__(self, mechanism: Mechanism, body: Multibody) -> None:
        """Lay the values of the struts out as arrays, shape (struts,)."""
        self._joints = mechanism.joints
        self._tables = mechanism.tabulated_springs
        self._struts = mechanism.struts
        self._laws = mechanism.forces
        self._body = body
        self._stiffness = np.array([strut.stiffness for strut in self._struts])
        self._free_length = np.array([strut.free_length for strut in self._struts])
        self._damping = np.array([strut.damping for strut in self._struts])
        self._directed = np.array([strut.directed for strut in self._struts], dtype=bool)
        self.coincident_m = COINCIDENT_M * mechanism.unit_m

    def forces(self, q: Vectors, v: Vectors) -> FloatArray:
        """Generalised forces, shape (N, nv) [N or N m].

        Raises:
            ElementError: Two points coincide.
        """
        tau = np.zeros_like(q)
        for table in self._tables:
            tau[:, table.index] -= table.characteristic.forces(q[:, table.index])
        for item in self._laws:
            tau[:, item.index] -= item.law.force(q[:, item.index], v[:, item.index])
        if self._struts:
            pull, jacobian, _ = self._pulls(q, v)
            tau -= np.einsum("nsi,nsij->nj", pull, jacobian)
        return tau

    def energy(self, q: FloatArray) -> FloatArray:
        """Energy stored in tables, struts and force laws [J], shape (N,)."""
        energy = np.zeros(len(q))
        for table in self._tables:
            energy += table.characteristic.energies(q[:, table.index])
        for item in self._laws:
            energy += item.law.energy(q[:, item.index])
        if self._struts:
            places, _ = self._body.points(q)
            length = np.linalg.norm(places[:, :, 1] - places[:, :, 0], axis=2)
            energy += 0.5 * (length - self._free_length) ** 2 @ self._stiffness
        return energy

    def dissipation(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Power that becomes heat [W], shape (N,); arguments as :meth:`forces`."""
        power = np.zeros(len(q))
        for item in self._laws:
            power += item.law.heat(q[:, item.index], v[:, item.index])
        if self._damping.any():
            _, _, rate = self._pulls(q, v)
            power += rate**2 @ self._damping
        return power

    def damper_lines(self, q: FloatArray) -> FloatArray:
        """Lines from point a to point b of all dampers (x, z), shape (N, dampers, 2) [m]."""
        if not self._damping.any():
            return np.empty((len(q), 0, 2))
        places, _ = self._body.points(q)
        return np.asarray((places[:, :, 1] - places[:, :, 0])[:, self._damping > 0.0])

    def point_forces(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Forces (x, z) on the points a of the struts, world axes, shape (N, struts, 2) [N]."""
        return self._pulls(q, v)[0]

    def runs_off(self, q: FloatArray) -> bool:
        """Return whether a motion that starts within the tables leaves one.

        Args:
            q: Configurations in order of time, shape (N, nv).
        """
        for table in self._tables:
            low, high = table.characteristic.reach
            x = q[:, table.index]
            if low <= x[0] <= high and (x.min() < low or x.max() > high):
                return True
        return False

    def check(self, q: FloatArray, t: FloatArray) -> None:
        """Refuse a motion that leaves a table.

        Args:
            q: Configurations, shape (N, nv).
            t: Their times [s], shape (N,).

        Raises:
            ElementError: Names table, joint, time and coordinate of the first such state.
        """
        for table in self._tables:
            low, high = table.characteristic.ends
            x = q[:, table.index]
            slack = TABLE_END_OVERRUN * (high - low)
            outside = np.flatnonzero((x < low - slack) | (x > high + slack))
            if outside.size:
                row = int(outside[0])
                joint = self._joints[table.index]
                factor, unit = (
                    (MM_PER_M, "mm") if joint.kind == "prismatic" else (DEG_PER_RAD, "deg")
                )
                message = (
                    f"spring {table.name}: at t = {t[row]:.6g} s joint {joint.name} stands at "
                    f"{factor * x[row]:.6g} {unit}, and the rows of its table go from "
                    f"{factor * low:g} to {factor * high:g} {unit}; add rows"
                )
                raise ElementError(
                    message,
                    element=table.name,
                    joint=joint.name,
                    coordinate=float(x[row]),
                    ends=(low, high),
                    t=float(t[row]),
                    q=q[row],
                )

    def check_heat(self, q: Vectors, v: Vectors, t: Times) -> None:
        """Refuse a motion on which a force law takes heat for work.

        Raises:
            ElementError: Names the law, the time and the heat of the first such state.
        """
        for item in self._laws:
            x, rate = q[:, item.index], v[:, item.index]
            heat = np.broadcast_to(item.law.heat(x, rate), x.shape)
            power = np.abs(item.law.force(x, rate) * rate)
            wrong = ~(heat >= -HEAT_ROUND_OFF * power.max(initial=0.0))
            if wrong.any():
                row = int(np.argmax(wrong))
                kind = type(item.law).__name__
                message = (
                    f"force {item.name} ({kind}, law {item.kind!r}): at t = {t[row]:.6g} s its "
                    f"heat is {heat[row]:.6g} W, and a force can turn work into heat but no heat "
                    "into work: heat has to be at least 0; mend the law or its numbers"
                )
                raise ElementError(
                    message, element=item.name, law=kind, heat=float(heat[row]), t=float(t[row]),
                    q=q[row],
                )  # fmt: skip

    def _pulls(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces T u on the points a, (N, struts, 2), G_d, (N, struts, 2, nv), and l_dot."""
        places, jacobians = self._body.points(q)
        line = places[:, :, 1] - places[:, :, 0]
        jacobian = jacobians[:, :, 1] - jacobians[:, :, 0]
        length = np.sqrt(np.einsum("nsi,nsi->ns", line, line))
        short = self._directed & (length < self.coincident_m)
        if short.any():
            row, place = (int(found[0]) for found in np.nonzero(short))
            strut = self._struts[place]
            message = (
                f"{strut.kind} {strut.name}: its points {strut.frame_a} and {strut.frame_b} "
                "coincide, so its force has no direction; move one of them off the other's way"
            )
            raise ElementError(
                message, element=strut.name, distance_m=float(length[row, place]), q=q[row]
            )
        # Points of a spring of free length zero may coincide: its force vanishes with the line.
        inverse = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
        rate = inverse * np.einsum("nsi,nsij,nj->ns", line, jacobian, v)
        density = (
            self._stiffness * (1.0 - self._free_length * inverse) + self._damping * rate * inverse
        )
        return density[:, :, None] * line, jacobian, rate
