"""Functions of the scalar equation of motion, exact at points (u, x).

With held drives the velocities are v = n x' + m w: n is the null direction (n_J = 1 at the
transition stop J, G n = 0, no drive moves) and m the motion by the cylinder alone (m_J = 0,
G m = 0). Inverse dynamics along n, n' (M a + h) = n' tau, contains no force of a closure or a
drive. With a = n x'' + b, b the convective acceleration at x'' = 0 that Pinocchio gives for x held,
it reads

    C x'' = n' tau - n' (M b + h),   C = n' M n,

and the right side is a quadratic form of (w, x') plus gravity. It is taken apart by evaluating it
at (1, 0), (1, 1), (1, -1) and (0, 1). Nothing is differentiated numerically.

Source: R. E. Kalaba and F. E. Udwadia, Analytical Dynamics, 1996 (null-space form).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...dynamics import INFINITE_INERTIA, System, close_positions, close_velocities, partition
from ...errors import InputError
from ...mechanism import Mechanism, Stop, rad_s_from_rpm
from ...tolerances.mechanics import TABLE_END_OVERRUN

# Places along the travel of which one is found from the last such one, the others from it.
_STRIDE = 4


@dataclass(frozen=True, eq=False)
class _Motion:
    """Configurations, their rates and forces.

    Attributes:
        q: Configurations, shape (N, nv).
        n: Rates by that of x, shape (N, nv).
        m: Rates by that of the cylinder with x held, shape (N, nv).
        jacobian: Derivatives of the closures, shape (N, rows, nv).
        weight: Generalised forces of the weight, shape (N, nv).
        inertial: M b + h - weight at the rates (1, 0), (1, 1), (1, -1) and (0, 1), likewise.
    """

    q: FloatArray
    n: FloatArray
    m: FloatArray
    jacobian: FloatArray
    weight: FloatArray
    inertial: tuple[FloatArray, ...]


@dataclass(frozen=True)
class Samples:
    """Functions at N points.

    Attributes:
        equation: F0, F1, F2, Fg, then F_k and F_k s_k of every spring, shape (4 + 2 springs, N);
            of a machine with other elements three more, shape (7 + 2 springs, N): what they do at
            rest, and by the rates of the cylinder and of x.
        gaps: Gaps of the other stops, then those up to the ends of springs' tables [m or rad];
            then their derivatives by x, then by u, shape (3 S, N).
        inertia: C, shape (N,) [kg m^2 or kg].
    """

    equation: FloatArray
    gaps: FloatArray
    inertia: FloatArray

    @property
    def rows(self) -> FloatArray:
        """All of them, shape (rows, N)."""
        return np.concatenate([self.equation, self.gaps, self.inertia[None]])


def _table_ends(mechanism: Mechanism) -> Iterator[Stop]:
    """Ends of the tables of springs, as if they were stops; none where a stop holds them off.

    A coordinate at the very end is on its table, and beyond it no force is known.
    """
    for spring in mechanism.tabulated_springs:
        low, high = spring.characteristic.ends
        slack = TABLE_END_OVERRUN * (high - low)
        for sense, at in ((1.0, low - slack), (-1.0, high + slack)):
            own = [stop for stop in mechanism.stops if stop.index == spring.index]
            if not any(stop.sense == sense and sense * (stop.at - at) >= 0.0 for stop in own):
                yield Stop(name=spring.name, index=spring.index, restitution=0.0, contact=None,
                           sense=sense, at=at)  # fmt: skip


class Sampler:
    """Evaluates a held system whose shaft turns at 1 rad/s from a configuration.

    In its methods u are travels [rad] and x coordinates of the stop, shape (N,) each unless told
    otherwise, q and guess configurations there and near there, shape (N, nv).

    Args:
        system: The system; its time is the travel u.
        stop: The stop whose gap is x.
        home: The configuration at travel zero, shape (nv,), with the stop closed or near it.

    Raises:
        InputError: The stop's coordinate follows from the drives at home.
    """

    def __init__(self, system: System, stop: Stop, home: FloatArray) -> None:
        """Choose dependent coordinates; that of the stop and the drives are independent."""
        _, jacobian = system.body.closures(home[None])
        driven = [int(index) for index in system.driven]
        self._split = partition(jacobian[0] * system.body.units, driven, [stop.index])
        if stop.index in self._split.dependent:
            where = ": a dead centre is near" if home.any() else " in the touch configuration"
            message = f"stop {stop.name!r} cannot move freely{where}"
            raise InputError(message, stop=stop.name)
        self._system = system
        self._stop, self._home = stop, home[None]
        others = [item for item in system.mechanism.stops if item.name != stop.name]
        self._others = (*others, *_table_ends(system.mechanism))
        self._armature = np.zeros(system.body.nv)
        self._armature[[*system.driven, stop.index]] = INFINITE_INERTIA
        # Cylinder speed at which inertial forces are evaluated: at 1 rad/s the round-off of the
        # subtracted weight would exceed them.
        self._fast = rad_s_from_rpm(system.mechanism.cylinder.rated_speed_rpm)

    def grid(self, u: FloatArray, x: FloatArray) -> FloatArray:
        """Close the loops on a grid, from neighbour to neighbour, so that the branch is kept.

        Args:
            u: Travels, increasing, the first one near zero, shape (U,).
            x: Coordinates in any order, shape (X,).

        Returns:
            Configurations, shape (U, X, nv).

        Raises:
            SimulationError: The mechanism cannot reach a point of the grid.
        """
        rough = np.concatenate([*self.along(u[::_STRIDE, None], np.zeros(1), self._home)])
        near = np.repeat(rough, _STRIDE, axis=0)[: len(u)]
        (closed,) = self.along(u[None], np.zeros(1), near)
        found = np.empty((len(u), len(x), closed.shape[1]))
        # Outwards from x = 0, first to one side and then to the other.
        for side in (np.flatnonzero(x >= 0.0), np.flatnonzero(x < 0.0)):
            order = side[np.argsort(np.abs(x[side]))]
            for place, rows in zip(order, self.along(u, x[order, None], closed), strict=True):
                found[:, place] = rows
        return found

    def along(self, u: FloatArray, x: FloatArray, q: FloatArray) -> Iterator[FloatArray]:
        """Follow configurations in small steps.

        Args:
            u: Travels after every step; with x broadcast to shape (steps, N).
            q: Configurations before the first one.

        Yields:
            Configurations after every step, shape (N, nv).

        Raises:
            SimulationError: The mechanism cannot reach a point.
        """
        jacobian = self._system.body.closures(q)[1]
        for travels, places in zip(*np.broadcast_arrays(u, x), strict=True):
            step = close_velocities(self._set(q, travels, places) - q, jacobian, self._split)
            to = self._set(q + step, travels, places)
            q, jacobian = close_positions(self._system.body, to, self._split)
            yield q

    def rates(self, u: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rates of all coordinates by that of x, and by that of the travel with x held: n and m."""
        n, m = np.zeros_like(q), np.zeros_like(q)
        n[:, self._stop.index] = self._stop.sense
        m[:, self._system.driven] = self._system.shaft.driven(u)[1]
        jacobian = self._system.body.closures(q)[1]
        n, m = (close_velocities(v, jacobian, self._split) for v in (n, m))
        return n, m

    def closed(self, travel: float, near: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The configuration at a travel with x at zero, and the rates by the travel there.

        Args:
            near: A configuration near by, shape (nv,).
        """
        u = np.array([travel])
        (rows,) = self.along(u[None], np.zeros(1), near[None])
        return rows[0], self.rates(u, rows)[1][0]

    def at(self, u: FloatArray, x: FloatArray, guess: FloatArray) -> Samples:
        """Evaluate all functions."""
        motion = self._motion(u, x, guess)
        inertia = 2.0 * self._system.body.kinetic_energy(motion.q, motion.n)
        gaps = [stop.gaps(motion.q) for stop in self._others]
        gaps += [stop.rates(by) for by in (motion.n, motion.m) for stop in self._others]
        return Samples(
            -self._resisted(motion.n, motion) / inertia,
            np.reshape(gaps, (len(gaps), len(u))),
            inertia,
        )

    def torque(self, drive: int, u: FloatArray, x: FloatArray, guess: FloatArray) -> Samples:
        """Evaluate the functions of the torque of a drive, which is linear in x'', too.

        The direction k of one drive alone, with the stop and all others held and G k = 0, does no
        work against closures, stops and other drives: T = k' (M a + h - tau).

        Returns:
            Those of the equation of motion, and in the place of a gap the factor of x''.
        """
        motion = self._motion(u, x, guess)
        # M n; the weight is taken off again, so the rates are those of inertial forces.
        scale, zero = self._fast**2, np.zeros_like(motion.q)
        pushed = self._system.body.inverse_dynamics(motion.q, zero, scale * motion.n)
        pushed = (pushed - motion.weight) / scale
        k = zero.copy()
        k[:, self._system.driven[drive]] = 1.0
        k = close_velocities(k, motion.jacobian, self._split)
        gaps = np.zeros((3, len(u)))
        gaps[0] = np.einsum("ni,ni->n", k, pushed)
        return Samples(self._resisted(k, motion), gaps, np.ones(len(u)))

    def _motion(self, u: FloatArray, x: FloatArray, guess: FloatArray) -> _Motion:
        """Closed configurations with their rates and forces."""
        body, driven, fast = self._system.body, self._system.driven, self._fast
        accelerations = self._system.shaft.driven(u)[2]
        q, jacobian = close_positions(body, self._set(guess, u, x), self._split)
        n, m = self.rates(u, q)
        zero = np.zeros_like(q)
        weight = body.inverse_dynamics(q, zero, zero)

        def inertial(w: float, rate: float) -> FloatArray:
            v, tau = fast * (w * m + rate * n), zero.copy()
            tau[:, driven] = INFINITE_INERTIA * (fast * w) ** 2 * accelerations
            b = body.accelerations(q, v, tau, self._armature)
            return np.asarray(body.inverse_dynamics(q, v, b) - weight)

        forces = inertial(1.0, 0.0), inertial(1.0, 1.0), inertial(1.0, -1.0), inertial(0.0, 1.0)
        return _Motion(q, n, m, jacobian, weight, forces)

    def _resisted(self, along: FloatArray, motion: _Motion) -> FloatArray:
        """What resists motion along a direction, shape (N, nv), while x'' is zero.

        Returns:
            Shape (functions, N), in the order of the equation of motion.
        """
        system, q = self._system, motion.q

        def of(force: FloatArray) -> FloatArray:
            return np.asarray(np.einsum("ni,ni->n", along, force))

        by_speed, both, against, by_rate = (of(force) / self._fast**2 for force in motion.inertial)
        terms = [by_speed, 0.5 * (both - against), by_rate, of(motion.weight)]
        for spring in system.mechanism.springs:
            terms += [along[:, spring.index], along[:, spring.index] * q[:, spring.index]]
        # Tables, dampers and struts: at rest, by the cylinder's speed and by x'.
        machine = system.mechanism
        if machine.dampers or machine.tabulated_springs or machine.struts:
            zero = np.zeros_like(q)
            still = zero if system.elements is None else system.elements.forces(q, zero)
            all_still = system.applied_forces(q, zero)
            rates = (system.applied_forces(q, v) - all_still for v in (motion.m, motion.n))
            terms += [-of(force) for force in (still, *rates)]
        return np.array(terms)

    def _set(self, q: FloatArray, u: FloatArray, x: FloatArray) -> FloatArray:
        """Configurations with the drives and the stop at new points; the others are kept."""
        found = q.copy()
        found[:, self._system.driven] = self._system.shaft.driven(u)[0]
        found[:, self._stop.index] = self._stop.at + self._stop.sense * x
        return found
