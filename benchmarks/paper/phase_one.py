"""Does the steeve stay on its stop while the jaw is open, as the published study assumes?

In phase 1 the drives determine the motion, so the force of the stop is known in closed form but for
three functions of the cylinder angle: F = p B(psi) + W(psi) + omega^2 J(psi), preload, weight and
inertia. The stop lets go where F falls to zero.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid.case import Case, Window
from nipper_pin.hybrid.event import EventKind
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import INDEX_PER_TURN, Mechanism, rad_s_from_rpm
from nipper_pin.units import S_PER_MIN

from ..tolerances import PRELOAD_STEP
from .branches import branch, touch_index

_PLACES = 1440
_SPEEDS_RPM = (100.0, 600.0)
# Of the map, in preloads of the model and in rated speeds: 5 to 17 mm, 400 to 800 r/min of the E62.
_PRELOADS = np.linspace(5.0, 17.0, 49) / 11.0
_MAP_SPEEDS = np.linspace(400.0, 800.0, 81) / 450.0


@dataclass(frozen=True)
class Release:
    """The stop lets go in a simulated turn.

    Attributes:
        speed_rpm: Cylinder speed [r/min].
        index: Where it lets go; None if it does not.
        lift: How far it opens [m or rad].
        duration_s: Until it is back [s].
    """

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
        thresholds = [self.threshold_rpm(float(p)) for p in self.preloads]
        return {
            "stop": self.stop,
            "preload": self.preload,
            "threshold_rpm": self.threshold_rpm(self.preload),
            "thresholds": [
                {"preload": float(p), "speed_rpm": value}
                for p, value in zip(self.preloads, thresholds, strict=True)
                if np.isfinite(value)
            ],
            "turns": [asdict(item) for item in self.releases],
        }


def phase_one(mechanism: Mechanism, speeds_rpm: tuple[float, ...]) -> PhaseOne:
    """Find the force of the one stop that is closed in phase 1, and what turns at speeds do."""
    (name,) = mechanism.phase(mechanism.initial_phase).closed
    jaw = mechanism.stop(mechanism.transition_stop).index
    index = touch_index(mechanism) - np.linspace(0.0, INDEX_PER_TURN, _PLACES + 1)
    closed = frozenset({name})
    (spring,) = mechanism.springs
    tighter = replace(spring, preload=spring.preload + PRELOAD_STEP)
    slow, fast = (branch(mechanism, closed, speed, index) for speed in _SPEEDS_RPM)
    tight = branch(replace(mechanism, springs=(tighter,)), closed, _SPEEDS_RPM[0], index)
    omega2 = [rad_s_from_rpm(speed) ** 2 for speed in _SPEEDS_RPM]
    lever = mechanism.stop(name).lever
    forces = [item.forces[:, 0] / lever for item in (slow, fast, tight)]
    per_preload = (forces[2] - forces[0]) / PRELOAD_STEP
    per_speed2 = (forces[1] - forces[0]) / (omega2[1] - omega2[0])
    weight = forces[0] - omega2[0] * per_speed2 - spring.preload * per_preload
    # From the touch configuration backwards, the jaw is open until its angle falls to zero.
    last = int(np.argmax(slow.q[1:, jaw] <= 0.0)) + 1
    back = slice(last - 1, None, -1)
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
    solution = simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE))
    for event in solution.events:
        if event.kind is EventKind.RELEASE and event.stops == (stop,):
            later = (item for item in solution.events[event.number :] if stop in item.stops)
            end = next(later).t
            index = mechanism.cylinder.index_from_angle(float(solution.shaft.angle(event.t)))
            return Release(speed, index, _lift(solution, stop, event.t, end), end - event.t)
    return Release(speed, None, 0.0, 0.0)


def _lift(solution: Solution, stop: str, begin: float, end: float) -> float:
    times = np.linspace(begin, end, 400)
    q = solution.trajectory.evaluate(times, left=True).q
    return float(solution.mechanism.stop(stop).gaps(q).max())
