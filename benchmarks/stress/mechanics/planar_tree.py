"""Planar multibody dynamics of a tree of links in complex numbers, without Pinocchio.

A point (x, z) of the side view is the complex number x + i z and a link's axes at the angle theta
are exp(i theta), so that with the offset r of a joint in its parent's axes

    o   = o_p   + r e,                                    e = exp(i theta_p)
    o'  = o_p'  + i w r e,
    o'' = o_p'' + (i alpha - w^2) r e,

and a slide by q along u adds q u to r, q' u e to the velocity and (q'' + 2 i w q') u e to the
acceleration. Forces follow from virtual work (Kane): the generalised force that a motion needs is
sum Re(conj(dc'/dv_j) m (c'' + i g)) + I alpha dw/dv_j.

Arrays of states have any shape before that of the coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .model_text import Frame, Real, read_links

if TYPE_CHECKING:
    from nipper_pin.mechanism import Mechanism

Complex = NDArray[np.complex128]
Places = NDArray[np.int_]


@dataclass(frozen=True)
class Motion:
    """Origins, angles and centroids of the links with their rates, each of shape (..., links)."""

    origin: Complex
    origin_rate: Complex
    origin_acceleration: Complex
    angle: Real
    spin: Real
    spin_rate: Real
    com: Complex
    com_rate: Complex
    com_acceleration: Complex

    def points(self, frames: Sequence[Frame]) -> tuple[Complex, Complex, Complex]:
        """Places, velocities and accelerations of the origins of frames, (..., frames) each."""
        origins = self.origin, self.origin_rate, self.origin_acceleration
        return _points(_bodies(frames), _places(frames), origins, self._angles)

    def axes(self, frames: Sequence[Frame]) -> Complex:
        """Directions of the x axes of frames, shape (..., frames)."""
        turned = _turned(_bodies(frames), self._angles)[0]
        return np.asarray(turned * np.array([frame.axes for frame in frames], dtype=complex))

    @property
    def _angles(self) -> tuple[Real, Real, Real]:
        return self.angle, self.spin, self.spin_rate


class PlanarTree:
    """The links of a model, of its URDF and TOML document, with its loops cut.

    Coordinates are in the order of these names of joints.
    """

    def __init__(self, urdf: str, document: Mapping[str, Any], order: Sequence[str]) -> None:
        """Read the texts; of a slot its block is a link."""
        closures = document.get("closures", {})
        text = read_links(urdf, order, closures)
        self.links, self.frames, self.nv = text.links, text.frames, len(text.links)
        self.gravity = text.steepness * float(document["gravity_m_s2"])
        self.masses = np.array([link.mass for link in self.links])
        self.inertias = np.array([link.inertia for link in self.links])
        firsts = {
            name: f"{name}_block" if item.get("slot_axis") else item["frame_a"]
            for name, item in closures.items()
        }
        self.closures = [
            (self.frames[firsts[name]], self.frames[item["frame_b"]])
            for name, item in closures.items()
        ]
        self.parents = np.array([link.parent for link in self.links], dtype=int)
        self.offsets = np.array([link.offset for link in self.links], dtype=complex)
        self.slides = np.array([link.slide is not None for link in self.links], dtype=bool)
        self._directions = np.array([link.slide or 0j for link in self.links], dtype=complex)
        self._every = np.arange(self.nv)
        self._com = np.array([link.com for link in self.links], dtype=complex)
        # Joints (columns) that move a link (rows); the last row is the frame's.
        self.moved = np.zeros((self.nv + 1, self.nv), dtype=bool)
        for body in range(self.nv):
            above = body
            while above >= 0:
                self.moved[body, above], above = True, self.links[above].parent
        self._senses = np.array([link.sense for link in self.links]) * ~self.slides
        self.turning = self.moved[:-1] * self._senses

    @classmethod
    def of(cls, mechanism: Mechanism) -> PlanarTree:
        """Read the texts that a mechanism was built from."""
        order = [joint.name for joint in mechanism.joints]
        return cls(mechanism.urdf, mechanism.description, order)

    def motion(self, q: Real, v: Real, a: Real) -> Motion:
        """Move the links; each of shape (..., nv)."""
        angles = q @ self.turning.T, v @ self.turning.T, a @ self.turning.T
        above, own = _turned(self.parents, angles), _turned(self._every, angles)
        slid = (q * own[0], v * own[0] + q * own[1], a * own[0] + 2.0 * v * own[1] + q * own[2])
        place, rate, rise = (
            (self.offsets * turn + self._directions * part) @ self.moved[:-1].T
            for turn, part in zip(above, slid, strict=True)
        )
        origins = place, rate, rise
        return Motion(*origins, *angles, *_points(self._every, self._com, origins, angles))

    def jacobian(self, motion: Motion, frames: Sequence[Frame]) -> Complex:
        """Derivatives of places by the coordinates, shape (..., frames, nv)."""
        return self._columns(motion, motion.points(frames)[0], _bodies(frames))

    def _columns(self, motion: Motion, place: Complex, bodies: Places) -> Complex:
        """A hinge turns what is beyond it about itself, a slide moves it along."""
        arms = place[..., :, None] - motion.origin[..., None, :]
        along = (self._directions * np.exp(1j * motion.angle))[..., None, :]
        turning = 1j * self._senses * arms
        return np.asarray(np.where(self.slides, along, turning) * self.moved[bodies])

    def mass_matrix(self, q: Real) -> Real:
        """M = sum m Re(conj(J_c)' J_c) + I J_w' J_w, shape (..., nv, nv)."""
        J = self._com_columns(self._still(q))
        moved = np.swapaxes(J.conj() * self.masses[:, None], -1, -2) @ J
        return np.asarray(moved.real + (self.turning.T * self.inertias) @ self.turning)

    def inverse_dynamics(self, q: Real, v: Real, a: Real) -> Real:
        """Generalised forces M a + h, shape (..., nv)."""
        motion = self.motion(q, v, a)
        force = self.masses * (motion.com_acceleration + 1j * self.gravity)
        moved = (self._com_columns(motion).conj() * force[..., :, None]).real.sum(axis=-2)
        return np.asarray(moved + (self.inertias * motion.spin_rate) @ self.turning)

    def kinetic_energy(self, q: Real, v: Real) -> Real:
        """Sum of m |c'|^2 / 2 + I w^2 / 2, shape (...)."""
        motion = self.motion(q, v, np.zeros_like(v))
        linear = np.abs(motion.com_rate) ** 2 @ self.masses
        return np.asarray(0.5 * (linear + motion.spin**2 @ self.inertias))

    def closure(self, q: Real, v: Real, a: Real, *, world: bool = False) -> tuple[Real, Real, Real]:
        """Gaps of the closures, their rates and accelerations, each of shape (..., m).

        Position of frame a minus that of frame b; rates and accelerations are those of the points
        (on closed motion the turning of the axes adds nothing), all in the axes of frame a or
        of the world.
        """
        motion = self.motion(q, v, a)
        firsts, seconds = self._ends
        axes = 1.0 if world else motion.axes(firsts).conj()
        both = zip(motion.points(firsts), motion.points(seconds), strict=True)
        gap, rate, acceleration = (_parts((one - other) * axes) for one, other in both)
        return gap, rate, acceleration

    def closure_jacobian(self, q: Real, *, world: bool = False) -> Real:
        """G, shape (..., m, nv), in the axes of the gaps."""
        motion = self._still(q)
        firsts, seconds = self._ends
        rows = self.jacobian(motion, firsts) - self.jacobian(motion, seconds)
        axes = np.ones(1) if world else motion.axes(firsts).conj()
        return np.swapaxes(_parts(np.swapaxes(rows * axes[..., None], -1, -2)), -1, -2)

    @property
    def _ends(self) -> tuple[list[Frame], list[Frame]]:
        return [first for first, _ in self.closures], [second for _, second in self.closures]

    def _com_columns(self, motion: Motion) -> Complex:
        return self._columns(motion, motion.com, self._every)

    def _still(self, q: Real) -> Motion:
        return self.motion(q, np.zeros_like(q), np.zeros_like(q))


def _bodies(frames: Sequence[Frame]) -> Places:
    return np.array([frame.body for frame in frames], dtype=int)


def _places(frames: Sequence[Frame]) -> Complex:
    return np.array([frame.place for frame in frames], dtype=complex)


def _turned(bodies: Places, angles: tuple[Real, Real, Real]) -> tuple[Complex, Complex, Complex]:
    """exp(i theta) of links, with its two derivatives by time."""
    # What the frame turns by is the last, and not taken.
    angle, spin, rate = (np.where(bodies < 0, 0.0, x[..., bodies]) for x in angles)
    axes = np.exp(1j * angle)
    return axes, 1j * spin * axes, (1j * rate - spin**2) * axes


def _points(
    bodies: Places,
    local: Complex,
    origins: tuple[Complex, Complex, Complex],
    angles: tuple[Real, Real, Real],
) -> tuple[Complex, Complex, Complex]:
    turned = _turned(bodies, angles)
    place, rate, rise = (
        np.where(bodies < 0, 0.0, origin[..., bodies]) + local * turn
        for origin, turn in zip(origins, turned, strict=True)
    )
    return place, rate, rise


def _parts(values: Complex) -> Real:
    """Parts x and z of each, one after the other: shape (..., n) becomes (..., 2 n)."""
    both = np.stack([values.real, values.imag], axis=-1)
    return both.reshape(*both.shape[:-2], -1)
