"""Functions of the scalar equation of motion, exact at points (u, x).

With held drives the velocities are v = n x' + m w: n is the null direction (n_J = 1 at the
transition stop J, G n = 0, no drive moves) and m the motion by the cylinder alone (m_J = 0,
G m = 0). Inverse dynamics along n, n' (M a + h) = n' tau, contains no force of a closure or a
drive. With a = n x'' + b, b the convective acceleration at x'' = 0 that Pinocchio gives for x held,
it reads

    C x'' = n' tau - n' (M b + h),   C = n' M n,

and the right side is a quadratic form of (w, x') plus gravity. Nothing is differentiated
numerically.

Forces that resist a motion are told apart by what they depend on. At velocities v = n x' + m w the
inertial forces are a quadratic form of (w, x'). It is taken apart by evaluating it at (1, 0), (1,
1), (1, -1) and (0, 1).

Source: R. E. Kalaba and F. E. Udwadia, Analytical Dynamics, 1996 (null-space form).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...dynamics import INFINITE_INERTIA, System, close_positions, close_velocities, partition
from ...errors import InputError
from ...mechanism import Mechanism, Stop, rad_s_from_rpm
from ...tolerances.mechanics import EPS, TABLE_END_OVERRUN

_ROOT_STEPS = 40


@dataclass(frozen=True, eq=False)
class Rates:
    """Configurations and their rates.

    Attributes:
        q: Configurations, shape (N, nv).
        n: Rates by that of x, shape (N, nv).
        m: Rates by that of the cylinder with x held, shape (N, nv).
    """

    q: FloatArray
    n: FloatArray
    m: FloatArray


def inertial_forces(
    system: System, motion: Rates, accelerations: FloatArray, armature: FloatArray
) -> tuple[FloatArray, ...]:
    """M b + h - weight at the rates (1, 0), (1, 1), (1, -1) and (0, 1), then the weight.

    Args:
        accelerations: Of the driven coordinates, at 1 rad/s of the cylinder, shape (N, drives).
        armature: Inertia added to the joints, shape (nv,): infinite where they are held.

    Returns:
        Generalised forces, shape (N, nv) each; those of inertia by the square of :func:`_fast`.
    """
    body, q, fast = system.body, motion.q, _fast(system)
    zero = np.zeros_like(q)
    weight = body.inverse_dynamics(q, zero, zero)

    def at(w: float, rate: float) -> FloatArray:
        v = fast * (w * motion.m + rate * motion.n)
        tau = zero.copy()
        tau[:, system.driven] = INFINITE_INERTIA * (fast * w) ** 2 * accelerations
        b = body.accelerations(q, v, tau, armature)
        return np.asarray(body.inverse_dynamics(q, v, b) - weight)

    return at(1.0, 0.0), at(1.0, 1.0), at(1.0, -1.0), at(0.0, 1.0), weight


def resisted(
    system: System, along: FloatArray, forces: tuple[FloatArray, ...], motion: Rates
) -> FloatArray:
    """What resists motion along a direction while x'' is zero, by function.

    Args:
        along: The direction, shape (N, nv).
        forces: As of :func:`inertial_forces`.

    Returns:
        Shape (functions, N), in the order of the equation of motion.
    """
    *inertial, weight = forces
    by_speed, both, against, by_rate = (
        np.einsum("ni,ni->n", along, force) / _fast(system) ** 2 for force in inertial
    )
    weighed = np.einsum("ni,ni->n", along, weight)
    terms = [by_speed, 0.5 * (both - against), by_rate, weighed]
    for spring in system.mechanism.springs:
        terms += [along[:, spring.index], along[:, spring.index] * motion.q[:, spring.index]]
    return np.array([*terms, *_by_elements(system, along, motion)])


def _by_elements(system: System, along: FloatArray, motion: Rates) -> list[FloatArray]:
    """The same of tables, dampers and struts: at rest, by the cylinder's speed and by x'."""
    mechanism = system.mechanism
    if not (mechanism.dampers or mechanism.tabulated_springs or mechanism.struts):
        return []
    zero = np.zeros_like(motion.q)
    still = zero if system.elements is None else system.elements.forces(motion.q, zero)
    all_still = system.applied_forces(motion.q, zero)

    def of(force: FloatArray) -> FloatArray:
        return -np.asarray(np.einsum("ni,ni->n", along, force))

    rates = (of(system.applied_forces(motion.q, v) - all_still) for v in (motion.m, motion.n))
    return [of(still), *rates]


def _fast(system: System) -> float:
    """Cylinder speed at which inertial forces are evaluated [rad/s].

    At 1 rad/s the round-off of the subtracted weight would exceed them.
    """
    return rad_s_from_rpm(system.mechanism.cylinder.rated_speed_rpm)


@dataclass(frozen=True)
class Samples:
    """Functions at N points.

    Attributes:
        q: Configurations, shape (N, nv).
        equation: F0, F1, F2, Fg, then F_k and F_k s_k of every spring, shape (4 + 2 springs, N);
            of a machine with other elements three more, shape (7 + 2 springs, N): what they do at
            rest, and by the rates of the cylinder and of x.
        gaps: Gaps of the other stops, then those up to the ends of springs' tables [m or rad];
            then their derivatives by x, then by u, shape (3 S, N).
        inertia: C, shape (N,) [kg m^2 or kg].
    """

    q: FloatArray
    equation: FloatArray
    gaps: FloatArray
    inertia: FloatArray


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
        home: A configuration in which it is closed, shape (nv,); None: that of the touch.
        path: Travels and configurations in which x is zero, shapes (W,) and (W, nv), not far from
            one another; of one sampler without it, the configuration zero at travel zero.

    Raises:
        InputError: The stop's coordinate follows from the drives at home.
    """

    def __init__(
        self,
        system: System,
        stop: Stop,
        home: FloatArray | None = None,
        path: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        """Choose dependent coordinates; that of the stop and the drives are independent."""
        q = np.zeros(system.body.nv) if home is None else home
        _, jacobian = system.body.closures(q[None])
        driven = [int(index) for index in system.driven]
        self._split = partition(jacobian[0] * system.body.units, driven, [stop.index])
        if stop.index in self._split.dependent:
            where = " in the touch configuration" if home is None else ": a dead centre is near"
            message = f"stop {stop.name!r} cannot move freely{where}"
            raise InputError(message, stop=stop.name)
        self._system = system
        self._stop = stop
        self._column = stop.index
        others = [item for item in system.mechanism.stops if item.name != stop.name]
        self._others = (*others, *_table_ends(system.mechanism))
        self._path = path
        self._armature = np.zeros(system.body.nv)
        self._armature[[*system.driven, stop.index]] = INFINITE_INERTIA

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self._system.body.nv

    def grid(self, u: FloatArray, x: FloatArray) -> FloatArray:
        """Close the loops on a grid, from neighbour to neighbour, so that the branch is kept.

        Args:
            u: Travels from zero on, to either side, shape (U,).
            x: Coordinates in any order, shape (X,).

        Returns:
            Configurations, shape (U, X, nv).

        Raises:
            SimulationError: The mechanism cannot reach a point of the grid.
        """
        found = np.empty((len(u), len(x), self.size))
        if self._path is None:
            rows = self._across(x, np.zeros(1), np.zeros((1, self.size)))[0]
            for number, configurations in enumerate(self.along(u, x, rows)):
                found[number] = configurations
            return found
        travels, path = self._path
        near = np.abs(u[:, None] - travels).argmin(axis=1)
        jacobian = self._system.body.closures(path[near])[1]
        q, _ = self._moved(path[near], jacobian, u, np.zeros_like(u))
        return self._across(x, u, q)

    def along(self, u: FloatArray, x: FloatArray, rows: FloatArray) -> Iterator[FloatArray]:
        """Follow points from travel zero on, to either side, in small steps.

        Args:
            u: Travels, shape (U,).
            x: Coordinates of the points, shape (X,).
            rows: Configurations at travel zero, shape (X, nv).

        Yields:
            Configurations at every travel, shape (X, nv).

        Raises:
            SimulationError: The mechanism cannot reach a point.
        """
        jacobians = self._system.body.closures(rows)[1]
        for travel in u:
            rows, jacobians = self._moved(rows, jacobians, np.full(len(x), travel), x)
            yield rows

    def rates(self, u: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rates of all coordinates by that of x, and by that of the travel with x held: n and m."""
        return self._rates(self._system.shaft.driven(u)[1], q, self._system.body.closures(q)[1])

    def closing(
        self, stop: Stop, low: float, high: float, before: FloatArray
    ) -> tuple[float, FloatArray]:
        """Travel at which the gap of another stop falls through zero, with x at zero.

        Args:
            before: Configuration at ``low``, shape (1, nv).

        Returns:
            The travel, and the configuration there, shape (nv,).
        """
        travel = high
        for _ in range(_ROOT_STEPS):
            ((row,),) = self.along(np.array([travel]), np.zeros(1), before)
            gap = stop.gap(row)
            rate = stop.rate(self.rates(np.array([travel]), row[None])[1][0])
            if gap > 0.0:
                low = travel
            else:
                high = travel
            new = travel - gap / rate if rate < 0.0 else math.nan
            if not low <= new <= high:
                new = 0.5 * (low + high)
            if abs(new - travel) <= 4.0 * EPS * travel or gap == 0.0:
                break
            travel = new
        return travel, row

    def _across(self, x: FloatArray, u: FloatArray, q: FloatArray) -> FloatArray:
        """Configurations at all x from those at x = 0, shape (U, X, nv)."""
        jacobian = self._system.body.closures(q)[1]
        found = np.empty((len(u), len(x), self.size))
        # Outwards from x = 0, first to one side and then to the other.
        for side in (np.flatnonzero(x >= 0.0), np.flatnonzero(x < 0.0)):
            rows, slopes = q, jacobian
            for place in side[np.argsort(np.abs(x[side]))]:
                rows, slopes = self._moved(rows, slopes, u, np.full(len(u), x[place]))
                found[:, place] = rows
        return found

    def at(self, u: FloatArray, x: FloatArray, guess: FloatArray) -> Samples:
        """Evaluate all functions."""
        motion, _, forces = self._motion(u, x, guess)
        q, n, m = motion.q, motion.n, motion.m
        inertia = 2.0 * self._system.body.kinetic_energy(q, n)
        equation = -resisted(self._system, n, forces, motion) / inertia
        gaps = [stop.gaps(q) for stop in self._others]
        gaps += [stop.rates(by) for by in (n, m) for stop in self._others]
        return Samples(q, equation, np.reshape(gaps, (len(gaps), len(q))), inertia)

    def torques(self, u: FloatArray, x: FloatArray, guess: FloatArray) -> FloatArray:
        """Evaluate the functions of the drives' torques, which are linear in x'', too.

        The direction k of one drive alone, with the stop and all others held and G k = 0, does no
        work against closures, stops and other drives: T = k' (M a + h - tau).

        Returns:
            By drive the functions as of the equation of motion, and last the factor of x'', shape
            (drives, functions + 1, N).
        """
        motion, jacobian, forces = self._motion(u, x, guess)
        # M n; the weight is taken off again, so the rates are those of inertial forces.
        scale = _fast(self._system) ** 2
        pushed = self._system.body.inverse_dynamics(motion.q, 0.0 * motion.q, scale * motion.n)
        pushed = (pushed - forces[-1]) / scale
        found = []
        for index in self._system.driven:
            k = np.zeros_like(motion.q)
            k[:, index] = 1.0
            k = close_velocities(k, jacobian, self._split)
            by_acceleration = np.einsum("ni,ni->n", k, pushed)
            found.append([*resisted(self._system, k, forces, motion), by_acceleration])
        return np.array(found)

    def _motion(
        self, u: FloatArray, x: FloatArray, guess: FloatArray
    ) -> tuple[Rates, FloatArray, tuple[FloatArray, ...]]:
        """Closed configurations with their rates, closure Jacobians, and forces of inertia."""
        driven, rates, accelerations = self._system.shaft.driven(u)
        q = guess.copy()
        q[:, self._system.driven] = driven
        q[:, self._column] = self._coordinate(x)
        q, jacobian = close_positions(self._system.body, q, self._split)
        motion = Rates(q, *self._rates(rates, q, jacobian))
        forces = inertial_forces(self._system, motion, accelerations, self._armature)
        return motion, jacobian, forces

    def _coordinate(self, x: FloatArray) -> FloatArray:
        """Coordinate of the stop's joint at a gap x."""
        return np.asarray(self._stop.at + self._stop.sense * x)

    def _rates(
        self, driven: FloatArray, q: FloatArray, jacobian: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        n, m = np.zeros_like(q), np.zeros_like(q)
        n[:, self._column] = self._stop.sense
        m[:, self._system.driven] = driven
        return (
            close_velocities(n, jacobian, self._split),
            close_velocities(m, jacobian, self._split),
        )

    def _moved(
        self, q: FloatArray, jacobian: FloatArray, u: FloatArray, x: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Closed configurations at new points, from those of neighbours along the tangent."""
        system = self._system
        driven = system.shaft.driven(u)[0]
        step = np.zeros_like(q)
        step[:, system.driven] = driven - q[:, system.driven]
        coordinate = self._coordinate(x)
        step[:, self._column] = coordinate - q[:, self._column]
        guess = q + close_velocities(step, jacobian, self._split)
        guess[:, system.driven] = driven
        guess[:, self._column] = coordinate
        return close_positions(system.body, guess, self._split)
