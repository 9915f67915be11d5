"""Motion of the two working phases over a whole turn: kinematics alone, nothing to integrate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics.assembly import close_positions, close_velocities
from nipper_pin.dynamics.multipliers import multipliers
from nipper_pin.dynamics.shaft import ShaftMotion
from nipper_pin.dynamics.system import System
from nipper_pin.mechanism import INDEX_PER_TURN, Mechanism, rad_s_from_rpm


@dataclass(frozen=True)
class Branch:
    """Motion with one set of closed stops, as if they could pull as well.

    Attributes:
        closed: Closed stops.
        index: Places on the comber's scale, growing with time from ``start``, shape (K,).
        q: Configurations, shape (K, nv) [rad or m].
        v: Velocities at the speed of the branch, shape (K, nv).
        a: Accelerations, shape (K, nv).
        forces: Forces of the closed stops along their coordinates, shape (K, closed) [N m or N].
    """

    closed: frozenset[str]
    index: FloatArray
    q: FloatArray
    v: FloatArray
    a: FloatArray
    forces: FloatArray


def branch(
    mechanism: Mechanism, closed: frozenset[str], speed_rpm: float, index: FloatArray
) -> Branch:
    """Follow a set of closed stops through given places of the turn.

    Args:
        mechanism: The mechanism, with held drives.
        closed: Closed stops; with them no freedom is left.
        speed_rpm: Cylinder speed [r/min].
        index: Places, shape (K,), in one direction and in steps short enough for the mechanism to
            stay on its branch; the first one is that of the touch configuration.

    Raises:
        ConvergenceError: The closures cannot be met; the stops cannot stay closed there.
        SingularConfigurationError: The mechanism passes a dead centre.
    """
    cylinder = mechanism.cylinder
    shaft = ShaftMotion(mechanism, rad_s_from_rpm(speed_rpm), cylinder.angle_at_touch_rad)
    system = System(mechanism, shaft)
    phase = system.constraint_set(closed)
    t = shaft.period * (index - touch_index(mechanism)) / INDEX_PER_TURN
    motion = shaft.driven(t)
    q = np.zeros((len(t), system.body.nv))
    v = np.zeros_like(q)
    system.prescribe(motion, q, v, phase)
    _, jacobian = system.body.closures(np.zeros((1, system.body.nv)))
    split = system.split(jacobian[0], phase.given, ())
    dependent = list(split.dependent)
    for k in range(len(t)):
        # A straight line through the last two places is a guess near enough.
        guess = q[k - 1] * 2.0 - q[k - 2] if k > 1 else q[max(k - 1, 0)]
        q[k, dependent] = guess[dependent]
        q[k : k + 1], _ = close_positions(system.body, q[k : k + 1], split)
    q, jacobian = close_positions(system.body, q, split)
    v = close_velocities(v, jacobian, split)
    a = system.accelerations(motion, q, v, phase)
    forces = multipliers(system, motion, q, v, a, jacobian, phase, split).la_N
    return Branch(closed, index, q, v, a, forces)


def touch_index(mechanism: Mechanism) -> float:
    """Index of the touch configuration."""
    cylinder = mechanism.cylinder
    return cylinder.index_from_angle(cylinder.angle_at_touch_rad)
