"""Phases 1 and 2 of the working cycle: kinematics alone, nothing to integrate.

Does the steeve stay on its stop while the jaw is open, as the published study assumes? The drives
determine the motion there, so the force of the stop is known in closed form but for three functions
of the cylinder angle: F = p B(psi) + W(psi) + omega^2 J(psi), preload, weight and inertia. The stop
lets go where F falls to zero.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import ShaftMotion, System, close_positions, close_velocities, multipliers
from nipper_pin.hybrid import Case, EventKind, Window, simulate
from nipper_pin.mechanism import INDEX_PER_TURN, Mechanism, rad_s_from_rpm, within_turn
from nipper_pin.units import S_PER_MIN

from ..tolerances import PRELOAD_STEP

_TURN = np.linspace(0.0, INDEX_PER_TURN, 1441)
_SPEEDS_RPM = (100.0, 600.0)
# Of the map, in preloads of the model and in rated speeds: 5 to 17 mm, 400 to 800 r/min of the E62.
_PRELOADS = np.linspace(5.0, 17.0, 49) / 11.0
_MAP_SPEEDS = np.linspace(400.0, 800.0, 81) / 450.0


def branch(
    mechanism: Mechanism, closed: frozenset[str], speed_rpm: float, index: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Follow a set of closed stops through places of the turn, as if they could pull as well.

    The drives are held, and no freedom is left. The places, shape (K,), begin at the touch
    configuration and go in one direction, in steps so short that no other branch is reached.

    Returns:
        Configurations, shape (K, nv) [rad or m], and forces of the closed stops along their
        coordinates, shape (K, closed) [N m or N].

    Raises:
        ConvergenceError: The closures cannot be met; the stops cannot stay closed there.
        SingularConfigurationError: The mechanism passes a dead centre.
    """
    shaft = ShaftMotion(mechanism, rad_s_from_rpm(speed_rpm), mechanism.cylinder.angle_at_touch_rad)
    system = System(mechanism, shaft)
    phase = system.constraint_set(closed)
    motion = shaft.driven(shaft.period * (index - touch_index(mechanism)) / INDEX_PER_TURN)
    q = np.zeros((len(index), system.body.nv))
    v = np.zeros_like(q)
    system.prescribe(motion, q, v, phase)
    _, jacobian = system.body.closures(np.zeros((1, system.body.nv)))
    split = system.split(jacobian[0], phase.given, ())
    dependent = list(split.dependent)
    for k in range(len(index)):
        # A straight line through the last two places is a guess near enough.
        guess = q[k - 1] * 2.0 - q[k - 2] if k > 1 else q[max(k - 1, 0)]
        q[k, dependent] = guess[dependent]
        q[k : k + 1], _ = close_positions(system.body, q[k : k + 1], split)
    q, jacobian = close_positions(system.body, q, split)
    v = close_velocities(v, jacobian, split)
    a = system.accelerations(motion, q, v, phase)
    return q, multipliers(system, motion, q, v, a, jacobian, phase, split).la_N


def touch_index(mechanism: Mechanism) -> float:
    """Index of the touch configuration."""
    return mechanism.cylinder.index_from_angle(mechanism.cylinder.angle_at_touch_rad)


def kinematics(mechanism: Mechanism, speed_rpm: float) -> dict[str, float]:
    """Marks of a turn in which the jaw closes without a bounce.

    Returns:
        The speed, which changes nothing, where the jaw closes and opens, how wide, and the longest
        way of the stop that is closed while the jaw is open [m or rad].

    Raises:
        ConvergenceError: A stop cannot stay closed through the whole turn.
    """
    index = touch_index(mechanism) + _TURN
    initial = mechanism.phase(mechanism.initial_phase).closed
    jaw = mechanism.stop(mechanism.transition_stop)
    opened, _ = branch(mechanism, initial, speed_rpm, index)
    closed, _ = branch(mechanism, frozenset({jaw.name}), speed_rpm, index)
    gap = jaw.gaps(opened)
    first = int(np.argmax(gap[1:] > 0.0)) + 1
    # The gap crosses zero between two neighbours; a straight line is within 1e-4 of the index.
    low, high = gap[first - 1], gap[first]
    opening = index[first - 1] + (index[1] - index[0]) * low / (low - high)
    q = np.where(gap[:, None] > 0.0, opened, closed)
    return {
        "speed_rpm": speed_rpm,
        "closing_index": touch_index(mechanism),
        "opening_index": float(within_turn(opening)),
        "largest_jaw_angle_rad": float(q[:, jaw.index].max()),
        "largest_stroke": float(q[:, mechanism.stop(min(initial)).index].max()),
    }


@dataclass(frozen=True)
class Release:
    """A simulated turn: where the stop lets go (None: nowhere), by how much and for how long."""

    speed_rpm: float
    index: float | None
    lift: float
    duration_s: float


@dataclass(frozen=True)
class PhaseOne:
    """Force of the stop that is closed in phase 1.

    Attributes:
        stop: Name of the stop.
        preload: Preload of the model [m or rad].
        preloads: Those of the map, shape (preloads,) [m or rad].
        speeds_rpm: Speeds of the map, shape (speeds,) [r/min].
        index: Places with the jaw open, shape (K,).
        per_preload: B, force by preload [N/m or N/rad], shape (K,).
        weight: W [N], shape (K,).
        per_speed2: J, force by the square of the cylinder's rate [N s^2], shape (K,).
        releases: What a simulated turn does at the published speeds.
    """

    stop: str
    preload: float
    preloads: FloatArray
    speeds_rpm: FloatArray
    index: FloatArray
    per_preload: FloatArray
    weight: FloatArray
    per_speed2: FloatArray
    releases: tuple[Release, ...]

    def force(self, preload: float, speed_rpm: float) -> FloatArray:
        """Force of the stop along the phase [N], shape (K,)."""
        omega = rad_s_from_rpm(speed_rpm)
        return self.per_preload * preload + self.weight + omega**2 * self.per_speed2

    def threshold_rpm(self, preload: float) -> float:
        """Speed from which on the stop lets go somewhere [r/min]; infinite if it never does."""
        pull = self.per_speed2 < 0.0
        held = (self.per_preload * preload + self.weight)[pull]
        if not pull.any():
            return np.inf
        omega2 = max(float((held / -self.per_speed2[pull]).min()), 0.0)
        return float(np.sqrt(omega2) * S_PER_MIN / (2.0 * np.pi))

    def smallest_forces(self) -> FloatArray:
        """Smallest force over the map [N], shape (preloads, speeds)."""
        return np.array([[self.force(p, n).min() for n in self.speeds_rpm] for p in self.preloads])

    def record(self) -> dict[str, Any]:
        """Return the answers as plain data."""
        limits = ((float(p), self.threshold_rpm(float(p))) for p in self.preloads)
        return {
            "stop": self.stop,
            "preload": self.preload,
            "threshold_rpm": self.threshold_rpm(self.preload),
            "thresholds": [{"preload": p, "speed_rpm": n} for p, n in limits if np.isfinite(n)],
            "turns": [asdict(item) for item in self.releases],
        }


def phase_one(mechanism: Mechanism, speeds_rpm: tuple[float, ...]) -> PhaseOne:
    """Find the force of the one stop that is closed in phase 1, and what turns at speeds do."""
    (name,) = mechanism.phase(mechanism.initial_phase).closed
    closed, (spring,) = frozenset({name}), mechanism.springs
    index = touch_index(mechanism) - _TURN
    tighter = replace(spring, preload=spring.preload + PRELOAD_STEP)
    found = [
        branch(mechanism, closed, _SPEEDS_RPM[0], index),
        branch(mechanism, closed, _SPEEDS_RPM[1], index),
        branch(replace(mechanism, springs=(tighter,)), closed, _SPEEDS_RPM[0], index),
    ]
    slow, fast, tight = (forces[:, 0] / mechanism.stop(name).lever for _, forces in found)
    omega2 = [rad_s_from_rpm(speed) ** 2 for speed in _SPEEDS_RPM]
    per_preload = (tight - slow) / PRELOAD_STEP
    per_speed2 = (fast - slow) / (omega2[1] - omega2[0])
    weight = slow - omega2[0] * per_speed2 - spring.preload * per_preload
    # From the touch configuration backwards, the jaw is open until its angle falls to zero.
    angle = found[0][0][:, mechanism.stop(mechanism.transition_stop).index]
    back = slice(int(np.argmax(angle[1:] <= 0.0)), None, -1)
    return PhaseOne(
        stop=name,
        preload=spring.preload,
        preloads=_PRELOADS * spring.preload,
        speeds_rpm=_MAP_SPEEDS * mechanism.cylinder.rated_speed_rpm,
        index=index[back],
        per_preload=per_preload[back],
        weight=weight[back],
        per_speed2=per_speed2[back],
        releases=tuple(_release(mechanism, name, speed) for speed in speeds_rpm),
    )


def _release(mechanism: Mechanism, stop: str, speed: float) -> Release:
    """Follow one turn and look for the stop's release with the jaw wide open."""
    run = simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE))
    for event in run.events:
        if event.kind is EventKind.RELEASE and event.stops == (stop,):
            later = (item.t for item in run.events[event.number :] if stop in item.stops)
            end = next(later, run.trajectory.span[1])
            q = run.trajectory.evaluate(np.linspace(event.t, end, 400), left=True).q
            index = mechanism.cylinder.index_from_angle(float(run.shaft.angle(event.t)))
            lift = float(mechanism.stop(stop).gaps(q).max())
            return Release(speed, index, lift, end - event.t)
    return Release(speed, None, 0.0, 0.0)
