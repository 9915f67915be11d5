"""A mechanism at one speed: its shaft, its forces and its accelerations in every phase.

Forces of constraint (closures, closed stops and drives) follow by inverse dynamics.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Jacobian, Jacobians, Vector, Vectors, product
from ..mechanism import Mechanism, Stop
from ..tolerances.mechanics import GOOD_CONDITION, MAX_CONDITION, REPARTITION_GAIN
from .assembly import Partition, close_velocities, inverses, inverted, partition, products
from .constraint_set import ConstraintSet, coefficients, constraint_set, parts
from .elements import Elements
from .multibody import INFINITE_INERTIA, multibody
from .shaft import Driven, ShaftMotion


class DriveMode(StrEnum):
    """How the driven shafts behave."""

    HELD = "held"
    """Position, rate and acceleration are prescribed; an impact cannot change them."""
    INERTIAL = "inertial"
    """Each shaft has a finite inertia on an elastic drive train; impacts change its speed."""


class System:
    """Accelerations, multipliers and impulses of one mechanism at one speed.

    Attributes:
        parts: Number of the part of each coordinate, shape (nv,); held shafts have their own.
        whole: True if all stops are in one part, as in most machines.
        turning: How far links turn by one unit of each coordinate, shape (nv,) [rad].
    """

    def __init__(
        self, mechanism: Mechanism, shaft: ShaftMotion, drive: DriveMode = DriveMode.HELD
    ) -> None:
        """Build the system."""
        self.mechanism = mechanism
        self.shaft = shaft
        self.drive = drive
        self.held = drive is DriveMode.HELD
        numbers = self._numbers = coefficients(mechanism, self.held)
        self.driven, self.driven_columns = numbers.driven, numbers.columns
        self.inertia, self.turning = numbers.inertia, numbers.turning
        self.drive_armature, self.free = numbers.armature, numbers.free
        self.held_coordinates = tuple(self.driven.tolist()) if self.held else ()
        self.body = multibody(mechanism)
        self.good_condition = GOOD_CONDITION * max(self.body.closure_rows, 1)
        bent = mechanism.tabulated_springs or mechanism.struts or mechanism.forces
        self.elements = Elements(mechanism, self.body) if bent else None
        self._sets: dict[frozenset[str], ConstraintSet] = {}
        self.parts, self._members, self._together, self.whole = parts(mechanism, self.held)
        self._all = frozenset(self._together)
        self._splits: dict[tuple[tuple[int, ...], tuple[int, ...]], Partition] = {}
        self._checked: tuple[FloatArray | None, tuple[int, ...]] = (None, ())
        self._condition, self._inverse = 1.0, np.empty((0, 0))

    def constraint_set(self, closed: frozenset[str]) -> ConstraintSet:
        """Return the constraints of the phase with these closed stops."""
        if closed not in self._sets:
            self._sets[closed] = constraint_set(self.mechanism, closed, self.held)
        return self._sets[closed]

    def apart(self, stops: Sequence[Stop]) -> list[list[Stop]]:
        """Stops in groups of one part each, in their order."""
        if self.whole:
            return [list(stops)]
        groups: dict[int, list[Stop]] = {}
        for stop in stops:
            groups.setdefault(int(self.parts[stop.index]), []).append(stop)
        return list(groups.values())

    def members(self, index: int) -> NDArray[np.intp]:
        """Coordinates of the part of one of them, and of held shafts that move it, in order."""
        return self._members[int(self.parts[index])]

    def coupled(self, names: Collection[str]) -> frozenset[str]:
        """Names of all stops in the parts of some stops, by their names; these among them."""
        if self.whole:
            return self._all if names else frozenset()
        return frozenset().union(*(self._together[name] for name in names))

    def split(
        self, jacobian: FloatArray, given: tuple[int, ...], preferred: tuple[int, ...]
    ) -> Partition:
        """Dependent coordinates here: those of the last choice while well conditioned.

        Value and errors are those of :func:`partition`, and arguments, but for G itself.
        """
        key = given, preferred
        known = self._splits.get(key)
        if known is None or not self._serves(known, jacobian):
            known = self._splits[key] = partition(jacobian * self.body.units, given, preferred)
        return known

    def good_partition(
        self, jacobian: FloatArray, given: tuple[int, ...], preferred: tuple[int, ...]
    ) -> Partition:
        """Dependent coordinates of a flight: as :meth:`split`, others where ill-conditioned.

        Arguments and errors are those of :meth:`split`.
        """
        split = self.split(jacobian, given, preferred)
        if self.condition(split, jacobian) <= self.good_condition:
            return split
        weighed = jacobian * self.body.units
        other = partition(weighed, given, preferred, self.good_condition)
        allowed = REPARTITION_GAIN * self.condition(split, jacobian)
        return other if self.condition(other, jacobian) < allowed else split

    def turns(self, moved: FloatArray) -> FloatArray:
        """How far links turn as coordinates move, shape of ``moved`` [rad]; slides by the reach."""
        return np.abs(moved) * self.turning

    def lift(self, jacobian: Jacobian, split: Partition, v: FloatArray) -> FloatArray:
        """Velocities with G v = 0, shape of ``v``: dependent rates from independent ones.

        Args:
            v: Velocity, shape (nv,) or (N, nv); its dependent rates count for nothing.
        """
        # Caches the inverse of the dependent block.
        self._serves(split, jacobian)
        lifted = v.copy()
        # Of one velocity or of many, the coordinates come first when transposed.
        by_coordinate = lifted.T
        by_coordinate[split.columns] = 0.0
        by_coordinate[split.columns] = -product(self._inverse, product(jacobian, by_coordinate))
        return lifted

    def closed_velocity(self, v: FloatArray, jacobian: Jacobian, split: Partition) -> Vector:
        """Solve G v = 0 for the dependent rates of one velocity that nearly satisfies it.

        Args:
            v: Velocity, shape (nv,); the independent rates are kept.
        """
        if not self._serves(split, jacobian):
            closed: FloatArray = close_velocities(v[None], jacobian[None], split)[0]
            return closed
        closed = v.copy()
        # The correction is small, so the accuracy of the inverse suffices.
        closed[split.columns] -= product(self._inverse, product(jacobian, v))
        return closed

    def condition(self, split: Partition, jacobian: Jacobian) -> float:
        """Condition number of the dependent block of the closures, cached for one configuration."""
        place, dependent = self._checked
        if place is not jacobian or dependent != split.dependent:
            columns = split.columns
            units = self.body.units.take(columns) if self.body.scaled else None
            self._condition, self._inverse = inverted(jacobian.take(columns, 1), units)
            self._checked = jacobian, split.dependent
        return self._condition

    def _serves(self, split: Partition, jacobian: FloatArray) -> bool:
        """True if the closures determine the dependent coordinates."""
        return self.condition(split, jacobian) < MAX_CONDITION

    def prescribe(self, motion: Driven, q: Vectors, v: Vectors, phase: ConstraintSet) -> None:
        """Write the prescribed coordinates and rates into q and v, in place."""
        if self.held:
            q[:, self.driven_columns] = motion[0]
            v[:, self.driven_columns] = motion[1]
        if phase.stops:
            q[:, phase.columns] = phase.places
            v[:, phase.columns] = 0.0

    def applied_forces(self, q: Vectors, v: Vectors) -> FloatArray:
        """Generalised forces of all springs and dampers, shape (N, nv)."""
        numbers = self._numbers
        forces: FloatArray = numbers.preload - numbers.stiffness * q - numbers.damping * v
        if self.elements is not None:
            forces += self.elements.forces(q, v)
        return forces

    def train_torques(self, motion: Driven, q: Vectors, v: Vectors) -> FloatArray:
        """Torques of elastic drive trains, shape (N, drives) [N m or N].

        I a_law + k (q_law - q) + c (v_law - v).
        """
        q_law, v_law, a_law = motion
        numbers = self._numbers
        torques: FloatArray = (
            self.inertia * a_law
            + numbers.train_stiffness * (q_law - q[:, self.driven_columns])
            + numbers.train_damping * (v_law - v[:, self.driven_columns])
        )
        return torques

    def spring_energy(self, q: FloatArray) -> FloatArray:
        """Energy stored in the springs [J], shape (N,)."""
        energy = np.zeros(len(q))
        for spring in self.mechanism.springs:
            energy += 0.5 * spring.stiffness * (spring.preload + q[:, spring.index]) ** 2
        if self.elements is not None:
            energy += self.elements.energy(q)
        return energy

    def dissipation(self, q: Vectors, v: Vectors) -> FloatArray:
        """Power that the dampers of the mechanism turn into heat [W], shape (N,).

        Drive trains are excluded: their losses are work of the drives.
        """
        power: FloatArray = v**2 @ self._numbers.damping
        if self.elements is not None:
            power += self.elements.dissipation(q, v)
        return power

    def point_forces(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Forces of the struts as :meth:`Elements.point_forces`, shape (N, struts, 2) [N]."""
        if self.elements is None:
            return np.zeros((len(q), 0, 2))
        return self.elements.point_forces(q, v)

    def forcing(self, motion: Driven, phase: ConstraintSet) -> FloatArray:
        """Generalised forces that do not depend on the state, shape (N, nv).

        The rest is linear in the state, tau = forcing - stiffness q - damping v, but for tables and
        struts (:mod:`.elements`). Preloads are -k p; a held shaft has I a_law with its infinite
        inertia I, an elastic drive train the torque of :meth:`train_torques` at q = v = 0.
        """
        q_law, v_law, a_law = motion
        tau = np.empty((len(q_law), self.body.nv))
        numbers = self._numbers
        tau[:] = numbers.preload
        if self.held:
            tau[:, self.driven_columns] = INFINITE_INERTIA * a_law
        else:
            tau[:, self.driven_columns] += (
                numbers.inertia * a_law
                + numbers.train_stiffness * q_law
                + numbers.train_damping * v_law
            )
        if phase.stops:
            tau[:, phase.columns] = 0.0
        return tau

    def respond(
        self, forcing: FloatArray, q: FloatArray, v: FloatArray, phase: ConstraintSet
    ) -> FloatArray:
        """Accelerations as :meth:`accelerations`, for forces known beforehand, shape (N, nv)."""
        count = len(q)
        stiffness = phase.repeated[:count] if count <= len(phase.repeated) else phase.stiffness
        tau = forcing - stiffness * q
        if phase.damping is not None:
            tau -= phase.damping * v
        if self.elements is not None:
            tau += phase.moving * self.elements.forces(q, v)
        return self.body.accelerations(q, v, tau, phase.armature)

    def accelerations(
        self,
        motion: Driven,
        q: Vectors,
        v: Vectors,
        phase: ConstraintSet,
    ) -> FloatArray:
        """Accelerations with the closures and the constraints of a phase, shape (N, nv)."""
        return self.respond(self.forcing(motion, phase), q, v, phase)

    def determined_accelerations(
        self,
        motion: Driven,
        q: Vectors,
        v: Vectors,
        phase: ConstraintSet,
        split: Partition,
        inverse: FloatArray,
    ) -> Vectors:
        """Accelerations of a phase without freedom: G a + G_dot v = 0, whatever the forces are.

        Every independent coordinate is a held drive or a closed stop.
        """
        a = np.zeros(q.shape)
        if self.held:
            a[:, self.driven_columns] = motion[2]
        if phase.stops:
            a[:, phase.columns] = 0.0
        if split.dependent:
            a[:, split.columns] = -products(inverse, self.body.closure_accelerations(q, v, a))
        return a


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Forces of constraint of N states.

    Attributes:
        la_g: Closure forces on the body of each closure's frame a, in that frame's axes,
            shape (N, m) [N].
        la_N: Forces of the closed stops along their gaps, positive when they push,
            shape (N, closed) [N m or N], in the order of ``ConstraintSet.stops``.
        drive: Torques on the driven joints, shape (N, drives) [N m]; those of the elastic trains
            where the shafts may change their speed.
    """

    la_g: FloatArray
    la_N: FloatArray
    drive: FloatArray


def multipliers(
    system: System,
    motion: Driven,
    q: Vectors,
    v: Vectors,
    a: Vectors,
    jacobian: Jacobians,
    phase: ConstraintSet,
    split: Partition,
    inverse: FloatArray | None = None,
) -> Multipliers:
    """Solve M a + h = tau + G' la_g + W' la_N for the forces of constraint.

    The rows of the dependent coordinates, on which only known forces act, determine la_g; the rows
    of stops and held drives then give their forces. The torque of an elastic drive train is known,
    and the inertia of its shaft stands beside that of the links.

    Args:
        split: Dependent and independent coordinates; no given one may be dependent.
        inverse: What :func:`inverses` gives for them, where it is known already.
    """
    missing = system.body.inverse_dynamics(q, v, a) - system.applied_forces(q, v)
    trains = 0.0 if system.held else system.train_torques(motion, q, v)
    if not system.held:
        missing[:, system.driven_columns] += system.inertia * a[:, system.driven_columns] - trains
    if inverse is None:
        inverse = inverses(jacobian, split)
    la_g = products(inverse.transpose(0, 2, 1), missing.take(split.columns, 1))
    rest = missing - products(jacobian.transpose(0, 2, 1), la_g)
    drive = rest[:, system.driven_columns] + trains
    return Multipliers(la_g, rest[:, phase.columns] * phase.senses, drive)
