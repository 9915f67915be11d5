"""Forces that resist a motion of a held mechanism, by what they depend on.

At velocities v = n x' + m w the inertial forces are a quadratic form of (w, x'). It is taken apart
by evaluating it at (1, 0), (1, 1), (1, -1) and (0, 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...dynamics import INFINITE_INERTIA, System
from ...mechanism import Mechanism, rad_s_from_rpm


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


def has_elements(mechanism: Mechanism) -> bool:
    """True for a machine with dampers, tabulated springs, or springs or dampers between points."""
    return bool(mechanism.dampers or mechanism.tabulated_springs or mechanism.struts)


def inertial_forces(
    system: System, motion: Rates, accelerations: FloatArray, armature: FloatArray
) -> tuple[FloatArray, ...]:
    """M b + h - weight at the rates (1, 0), (1, 1), (1, -1) and (0, 1), then the weight.

    Args:
        system: The held system.
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


def mass_times(
    system: System, q: FloatArray, direction: FloatArray, forces: tuple[FloatArray, ...]
) -> FloatArray:
    """M times a direction, shape (N, nv); ``forces`` as of :func:`inertial_forces`."""
    scale = _fast(system) ** 2
    pushed = system.body.inverse_dynamics(q, np.zeros_like(q), scale * direction)
    return np.asarray((pushed - forces[-1]) / scale)


def resisted(
    system: System, along: FloatArray, forces: tuple[FloatArray, ...], motion: Rates
) -> FloatArray:
    """What resists motion along a direction while x'' is zero, by function.

    Args:
        system: The held system.
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
    if not has_elements(system.mechanism):
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
