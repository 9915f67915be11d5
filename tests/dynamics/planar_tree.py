"""Planar multibody dynamics in complex numbers, without Pinocchio: what the tests compare with.

A point (x, z) of the side view is the complex number x + i z and a link's axes at the angle theta
are exp(i theta), so that with the offset r of a joint in its parent's axes

    o   = o_p   + r e,                                    e = exp(i theta_p)
    o'  = o_p'  + i w r e,
    o'' = o_p'' + (i alpha - w^2) r e,

and a slide by q along u adds q u to r, q' u e to the velocity and (q'' + 2 i w q') u e to the
acceleration. Forces follow from virtual work (Kane): the generalised force that a motion needs is
sum Re(conj(dc'/dv_j) m (c'' + i g)) + I alpha dw/dv_j.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from nipper_pin.mechanism import Mechanism

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Link:
    """A moving link and the joint that carries it."""

    name: str
    joint: str
    parent: int
    offset: complex
    slide: complex | None
    mass: float
    com: complex
    inertia: float


@dataclass(frozen=True)
class Motion:
    """Origins, angles and centroids of the links with their rates, each of shape (links,)."""

    origin: Complex
    origin_rate: Complex
    origin_acceleration: Complex
    angle: Real
    spin: Real
    spin_rate: Real
    com: Complex
    com_rate: Complex
    com_acceleration: Complex

    def point(self, link: int, local: complex) -> tuple[complex, complex, complex]:
        """Position, velocity and acceleration of a point of a link; -1 is the frame."""
        if link < 0:
            return local, 0.0, 0.0
        arm = local * np.exp(1j * self.angle[link])
        spin = self.spin[link]
        return (
            self.origin[link] + arm,
            self.origin_rate[link] + 1j * spin * arm,
            self.origin_acceleration[link] + (1j * self.spin_rate[link] - spin**2) * arm,
        )


class PlanarTree:
    """The links of a mechanism, read from its URDF text."""

    def __init__(self, mechanism: Mechanism) -> None:
        robot = ElementTree.fromstring(mechanism.urdf)
        bodies = {body.get("name"): body for body in robot.iter("link")}
        places = {joint.name: joint.index for joint in mechanism.joints}
        carried = {joint.find("child").get("link"): joint for joint in robot.findall("joint")}
        links: list[Link | None] = [None] * len(places)
        self.gravity = mechanism.gravity_m_s2
        self.frames: dict[str, tuple[int, complex]] = {}
        for name in bodies:
            index, local, current = -1, 0j, name
            # Fixed joints only shift the origin: all frames are parallel in the zero configuration.
            while current in carried and carried[current].get("type") == "fixed":
                local += _point(carried[current].find("origin"), "xyz")
                current = carried[current].find("parent").get("link")
            if current in carried:
                index = places[carried[current].get("name")]
            self.frames[name] = index, local
        for child, joint in carried.items():
            if joint.get("type") == "fixed":
                continue
            parent, local = self.frames[joint.find("parent").get("link")]
            inertial = bodies[child].find("inertial")
            links[places[joint.get("name")]] = Link(
                name=child,
                joint=joint.get("name"),
                parent=parent,
                offset=local + _point(joint.find("origin"), "xyz"),
                slide=_point(joint.find("axis"), "xyz")
                if joint.get("type") == "prismatic"
                else None,
                mass=float(inertial.find("mass").get("value")),
                com=_point(inertial.find("origin"), "xyz"),
                inertia=float(inertial.find("inertia").get("iyy")),
            )
        self.links = [link for link in links if link is not None]
        self.nv = len(self.links)
        self.masses = np.array([link.mass for link in self.links])
        self.inertias = np.array([link.inertia for link in self.links])
        self.closures = [
            (self.frames[closure.frame_a], self.frames[closure.frame_b])
            for closure in mechanism.closures
        ]

    def motion(self, q: Real, v: Real, a: Real) -> Motion:
        """Move the links."""
        origins, angles, coms = (np.zeros((3, self.nv), dtype=complex) for _ in range(3))
        for i, link in enumerate(self.links):
            above = link.parent
            o, theta = (np.zeros(3), np.zeros(3)) if above < 0 else (
                origins[:, above], angles[:, above].real)  # fmt: skip
            e = np.exp(1j * theta[0])
            turn = 1j * theta[2] - theta[1] ** 2
            arm = link.offset if link.slide is None else link.offset + q[i] * link.slide
            origins[:, i] = o + np.array([1.0, 1j * theta[1], turn]) * arm * e
            if link.slide is None:
                angles[:, i] = theta + np.array([q[i], v[i], a[i]])
            else:
                angles[:, i] = theta
                origins[1, i] += v[i] * link.slide * e
                origins[2, i] += (a[i] + 2j * theta[1] * v[i]) * link.slide * e
            spin, spin_rate = angles[1, i].real, angles[2, i].real
            arm = link.com * np.exp(1j * angles[0, i].real)
            coms[:, i] = origins[:, i] + np.array([1.0, 1j * spin, 1j * spin_rate - spin**2]) * arm
        return Motion(*origins, *angles.real, *coms)

    def _columns(self, q: Real) -> list[Motion]:
        zero = np.zeros(self.nv)
        return [self.motion(q, unit, zero) for unit in np.eye(self.nv)]

    def mass_matrix(self, q: Real) -> Real:
        """M = sum m Re(conj(J_c) J_c) + I J_w J_w."""
        columns = self._columns(q)
        rates = np.array([column.com_rate for column in columns])
        spins = np.array([column.spin for column in columns])
        moved = (rates.conj() * self.masses) @ rates.T
        return moved.real + (spins * self.inertias) @ spins.T

    def inverse_dynamics(self, q: Real, v: Real, a: Real) -> Real:
        """Generalised forces M a + h."""
        motion = self.motion(q, v, a)
        force = self.masses * (motion.com_acceleration + 1j * self.gravity)
        moment = self.inertias * motion.spin_rate
        return np.array(
            [
                np.sum((column.com_rate.conj() * force).real) + column.spin @ moment
                for column in self._columns(q)
            ]
        )

    def kinetic_energy(self, q: Real, v: Real) -> float:
        """Sum of m |c'|^2 / 2 + I w^2 / 2."""
        motion = self.motion(q, v, np.zeros(self.nv))
        linear = self.masses @ np.abs(motion.com_rate) ** 2
        return float(0.5 * (linear + self.inertias @ motion.spin**2))

    def height_energy(self, q: Real) -> float:
        """Sum of m g z."""
        zero = np.zeros(self.nv)
        return float(self.gravity * self.masses @ self.motion(q, zero, zero).com.imag)

    def closure(self, q: Real, v: Real, a: Real) -> tuple[Real, Real, Real]:
        """Gaps of the closures, their rates and accelerations, each of shape (m,).

        Position of frame a minus that of frame b; rates and accelerations are those of the points
        (on closed motion the turning of the axes adds nothing), all in the axes of frame a.
        """
        motion = self.motion(q, v, a)
        rows = []
        for (link_a, local_a), (link_b, local_b) in self.closures:
            axes = np.exp(-1j * motion.angle[link_a]) if link_a >= 0 else 1.0
            one, other = motion.point(link_a, local_a), motion.point(link_b, local_b)
            rows.append([(x - y) * axes for x, y in zip(one, other, strict=True)])
        both = np.array(rows, dtype=complex).reshape(-1, 3)
        return tuple(np.column_stack([x.real, x.imag]).ravel() for x in both.T)

    def closure_jacobian(self, q: Real) -> Real:
        """G, shape (m, nv)."""
        zero = np.zeros(self.nv)
        return np.array([self.closure(q, unit, zero)[1] for unit in np.eye(self.nv)]).T

    def close(self, q: Real, free: list[int]) -> Real:
        """Move the free coordinates by the least amount that closes the loops (Gauss-Newton)."""
        q, zero = q.copy(), np.zeros(self.nv)
        for _ in range(12):
            g = self.closure(q, zero, zero)[0]
            step = np.linalg.lstsq(self.closure_jacobian(q)[:, free], g, rcond=None)[0]
            q[free] -= step
            if np.abs(step).max() < 1e-15:
                break
        return q


def constrained(M: Real, force: Real, rows: Real, rates: Real) -> tuple[Real, Real]:
    """Solve M x = force + rows' y, rows x = rates, to the last digits by iterative refinement."""
    count = len(rows)
    matrix = np.block([[M, -rows.T], [rows, np.zeros((count, count))]])
    right = np.concatenate([force, rates])
    # Equilibrated, because masses and lever arms differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.abs(matrix).max(axis=1))
    inverse = np.linalg.inv(scale[:, None] * matrix * scale)
    x = np.zeros(len(right), dtype=np.longdouble)
    for _ in range(4):
        residual = right - matrix.astype(np.longdouble) @ x
        x = x + scale * (inverse @ (scale * residual.astype(float)))
    solution = x.astype(float)
    return solution[: len(M)], solution[len(M) :]


def _point(element: ElementTree.Element, key: str) -> complex:
    x, _, z = (float(text) for text in element.get(key, "0 0 0").split())
    return complex(x, z)
