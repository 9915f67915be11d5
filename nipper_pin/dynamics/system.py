"""A mechanism set in motion: its shaft, its forces and the constraint sets of its phases."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ..arrays import FloatArray
from ..mechanism import Mechanism
from .multibody import INFINITE_INERTIA, Multibody
from .shaft import Driven, ShaftMotion


class DriveMode(StrEnum):
    """How the driven shafts behave."""

    HELD = "held"
    """Position, rate and acceleration are prescribed; an impact cannot change them."""
    INERTIAL = "inertial"
    """Each shaft has a finite inertia on an elastic drive train; impacts change its speed."""


@dataclass(frozen=True)
class ConstraintSet:
    """The bilateral rows of one phase beside the closures.

    Attributes:
        closed: Names of the closed stops.
        stops: Coordinates of the closed stops, held at zero.
        given: Driven coordinates and closed stops: never dependent through the closures.
        armature: Inertia added to each joint in flight, shape (nv,).
        freedom: Degrees of freedom that are left.
    """

    closed: frozenset[str]
    stops: tuple[int, ...]
    given: tuple[int, ...]
    armature: FloatArray
    freedom: int


class System:
    """What the solver sees: accelerations, multipliers and impulses of one mechanism at one speed.

    Args:
        mechanism: The mechanism.
        shaft: Motion of the cylinder.
        drive: Behaviour of the driven shafts.
    """

    def __init__(
        self, mechanism: Mechanism, shaft: ShaftMotion, drive: DriveMode = DriveMode.HELD
    ) -> None:
        """Build the system."""
        self.mechanism = mechanism
        self.shaft = shaft
        self.drive = drive
        self.held = drive is DriveMode.HELD
        self.driven = np.array([item.index for item in mechanism.drives], dtype=int)
        self.inertia = np.array([item.reflected_inertia for item in mechanism.drives])
        omega = 2.0 * np.pi * np.array([item.shaft_frequency_hz for item in mechanism.drives])
        damping = np.array([item.shaft_damping_ratio for item in mechanism.drives])
        self._shaft_stiffness = self.inertia * omega**2
        self._shaft_damping = 2.0 * damping * omega * self.inertia
        nv = len(mechanism.joints)
        self._drive_armature = np.zeros(nv)
        self._drive_armature[self.driven] = INFINITE_INERTIA if self.held else self.inertia
        # 1 for coordinates that accelerations move, 0 for those that a law holds.
        self.free = np.ones(nv)
        if self.held:
            self.free[self.driven] = 0.0
        self.body = Multibody(mechanism, self._drive_armature)
        self._sets: dict[frozenset[str], ConstraintSet] = {}

    def constraint_set(self, closed: frozenset[str]) -> ConstraintSet:
        """Return the rows of the phase with these closed stops."""
        if closed not in self._sets:
            stops = tuple(stop.index for stop in self.mechanism.stops if stop.name in closed)
            given = (*(drive.index for drive in self.mechanism.drives), *stops)
            prescribed = len(given) if self.held else len(stops)
            armature = self._drive_armature.copy()
            armature[list(stops)] = INFINITE_INERTIA
            freedom = self.body.nv - self.body.closure_rows - prescribed
            self._sets[closed] = ConstraintSet(closed, stops, given, armature, freedom)
        return self._sets[closed]

    def prescribe(self, motion: Driven, q: FloatArray, v: FloatArray, rows: ConstraintSet) -> None:
        """Write the prescribed coordinates and rates into q and v, in place.

        Args:
            motion: Driven coordinates of these states.
            q: Configurations, shape (N, nv).
            v: Velocities, shape (N, nv).
            rows: The phase.
        """
        if self.held:
            for column, index in enumerate(self.driven):
                q[:, index] = motion[0][:, column]
                v[:, index] = motion[1][:, column]
        for index in rows.stops:
            q[:, index] = 0.0
            v[:, index] = 0.0

    def spring_forces(self, q: FloatArray) -> FloatArray:
        """Generalised forces of the springs, -k (p + x), shape (N, nv)."""
        tau = np.zeros(q.shape)
        for spring in self.mechanism.springs:
            tau[:, spring.index] -= spring.stiffness * (spring.preload + q[:, spring.index])
        return tau

    def spring_energy(self, q: FloatArray) -> FloatArray:
        """Energy stored in the springs [J], shape (N,)."""
        energy = np.zeros(len(q))
        for spring in self.mechanism.springs:
            energy += 0.5 * spring.stiffness * (spring.preload + q[:, spring.index]) ** 2
        return energy

    def shaft_torques(self, motion: Driven, q: FloatArray, v: FloatArray) -> FloatArray:
        """Torques that an elastic drive train exerts on the free shafts, shape (N, drives) [N m].

        tau = I a_law + k (q_law - q) + c (v_law - v), with k = I w^2 and c = 2 zeta w I.
        """
        q_law, v_law, a_law = motion
        return np.asarray(
            self.inertia * a_law
            + self._shaft_stiffness * (q_law - q[:, self.driven])
            + self._shaft_damping * (v_law - v[:, self.driven])
        )

    def accelerations(
        self,
        motion: Driven,
        q: FloatArray,
        v: FloatArray,
        rows: ConstraintSet,
    ) -> FloatArray:
        """Accelerations with the closures and the rows of a phase, shape (N, nv).

        Args:
            motion: Driven coordinates, rates and accelerations of these states, as
                :meth:`ShaftMotion.driven` gives them.
            q: Configurations, shape (N, nv).
            v: Velocities, shape (N, nv).
            rows: The phase.
        """
        tau = self.spring_forces(q)
        torques = INFINITE_INERTIA * motion[2] if self.held else self.shaft_torques(motion, q, v)
        for column, index in enumerate(self.driven):
            tau[:, index] += torques[:, column]
        for index in rows.stops:
            tau[:, index] = 0.0
        return self.body.accelerations(q, v, tau, rows.armature)
