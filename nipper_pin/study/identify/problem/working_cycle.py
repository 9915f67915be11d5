"""The working cycle without bounces: timing, stop force and clamping force, by kinematics.

With held drives, phases 1 (steeve on its stop) and 2 (jaw closed) leave no freedom: the cylinder
angle gives the configuration and inverse dynamics the forces. That is enough for the timing and
the forces of a cycle, it costs a fraction of a simulated one, and it is smooth in the parameters
where a simulated cycle has events that come and go.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....arrays import FloatArray
from ....dynamics import (
    ShaftMotion,
    System,
    close_positions,
    close_velocities,
    multipliers,
    partition,
)
from ....errors import InputError, SimulationError
from ....mechanism import Mechanism, rad_s_from_rpm
from ....tolerances.study import CYCLE_ROOT

_STEP_RAD = math.tau / 30.0
_ROOT_STEPS = 40
SAMPLES = 48
"""Samples of each phase."""


@dataclass(frozen=True)
class Phase:
    """A phase without freedom, sampled over the travel of the cylinder.

    Attributes:
        index: Index of every sample (continued beyond 40), shape (N,).
        gap: Coordinate of the stop that is open, shape (N,) [rad or m].
        force: Force of the closed stop: at the lips [N] if the stop has a contact, along its
            coordinate otherwise, shape (N,) [N or N m].
    """

    index: FloatArray
    gap: FloatArray
    force: FloatArray


@dataclass(frozen=True)
class WorkingCycle:
    """Timing and forces of the working cycle at one speed.

    Attributes:
        closing_index: Index of touch.
        opening_index: Index at which the other stop is reached again and opens the jaw.
        waiting: The phase before touch: the transition stop is open.
        clamping: The phase after touch: the transition stop is closed.
        clamping_force: Mean lip force over the middle half of the closed phase, where the bounces
            are over and the opening is still far [N].
    """

    speed_rpm: float
    closing_index: float
    opening_index: float
    waiting: Phase
    clamping: Phase
    clamping_force: float

    @property
    def stop_force(self) -> float:
        """Least force of the closed stop while the transition stop is open [N]."""
        return float(self.waiting.force.min())


def working_cycle(mechanism: Mechanism, speed_rpm: float) -> WorkingCycle:
    """Walk the two phases without freedom around one turn.

    Args:
        mechanism: A mechanism with two stops that are closed in turn, one at a time.

    Raises:
        InputError: The mechanism has not got these two phases.
        SimulationError: The links cannot follow the drives, or the jaw does not open again.
    """
    transition = mechanism.transition_stop
    waiting = mechanism.phase(mechanism.initial_phase).closed
    system = System(
        mechanism,
        ShaftMotion(mechanism, rad_s_from_rpm(speed_rpm), mechanism.cylinder.angle_at_touch_rad),
    )
    reason = unfit(mechanism)
    if reason is not None:
        raise InputError(reason, model=mechanism.name, initial=sorted(waiting))
    (other,) = waiting
    closed = _Walk(system, transition)
    period = system.shaft.period
    t_open = closed.return_of(mechanism.stop(other).index, period)
    evenly = np.linspace(0.0, 1.0, SAMPLES)
    clamping = closed.sample(t_open * evenly, mechanism.stop(other).index)
    middle = closed.sample(middle_half(0.0, t_open)[0], mechanism.stop(other).index)
    before = _Walk(system, other).sample(
        (period - t_open) * (evenly - 1.0), mechanism.stop(transition).index
    )
    closing = mechanism.cylinder.index_from_angle(mechanism.cylinder.angle_at_touch_rad)
    opening = mechanism.cylinder.index_from_angle(float(system.shaft.angle(t_open)))
    return WorkingCycle(
        speed_rpm=speed_rpm,
        closing_index=closing,
        opening_index=opening,
        waiting=before,
        clamping=clamping,
        clamping_force=float(middle_half(0.0, t_open)[1] @ middle.force),
    )


def unfit(mechanism: Mechanism) -> str | None:
    """Say why a mechanism has no working cycle of two phases without freedom.

    Returns:
        One sentence, or None if it has one.
    """
    waiting = mechanism.phase(mechanism.initial_phase).closed
    one_left = mechanism.degrees_of_freedom == 1 + len(mechanism.drives)
    plain = all(stop.plain for stop in mechanism.stops)
    if len(waiting) == 1 and mechanism.transition_stop not in waiting and one_left and plain:
        return None
    return (
        f"{mechanism.name}: timing and forces by kinematics need one degree of freedom beside the "
        f"drives, held by one stop in the initial phase and by {mechanism.transition_stop} after "
        "it, both lower stops at coordinate zero"
    )


def middle_half(begin: float, end: float) -> tuple[FloatArray, FloatArray]:
    """Places and weights of a mean over the middle half of an interval, by Gauss' rule.

    Returns:
        Places and weights, shape (12,) each; the weights add up to one.
    """
    places, weights = np.polynomial.legendre.leggauss(12)
    return 0.5 * (begin + end) + 0.25 * (end - begin) * places, 0.5 * weights


class _Walk:
    """One phase followed from touch in small steps of the cylinder."""

    def __init__(self, system: System, closed: str) -> None:
        self.system = system
        self.stop = system.mechanism.stop(closed)
        self.rows = system.constraint_set(frozenset({closed}))
        _, jacobian = system.body.closures(np.zeros((1, system.body.nv)))
        self.split = partition(jacobian[0] * system.body.units, self.rows.given, [])
        self._dt = _STEP_RAD / system.shaft.speed_rad_s
        self._known = {0: np.zeros(system.body.nv)}

    def at(self, t: float) -> FloatArray:
        """Configuration at a time, from the nearest one of the walk."""
        place = round(t / self._dt)
        sense = 1 if place > 0 else -1
        for step in range(sense, place + sense, sense) if place else ():
            if step not in self._known:
                self._known[step] = self._near(
                    step * self._dt, self._known[step - sense], (step - sense) * self._dt
                )
        return self._near(t, self._known[place], place * self._dt)

    def _near(self, t: float, q: FloatArray, t_known: float) -> FloatArray:
        """Configuration at a time, from one nearby: a step along the tangent, then Newton."""
        system = self.system
        motion = system.shaft.driven_at(t)
        step = np.zeros((1, system.body.nv))
        step[0, system.driven] = motion[0][0] - q[system.driven]
        _, jacobian = system.body.closures(q[None])
        if t != t_known:
            step = close_velocities(step, jacobian, self.split)
        guess = q[None] + step
        system.prescribe(motion, guess, np.zeros_like(guess), self.rows)
        return np.asarray(close_positions(system.body, guess, self.split)[0][0])

    def return_of(self, index: int, period: float) -> float:
        """Time after touch at which an open coordinate falls back to zero [s]."""
        left, value = self._dt, float(self.at(self._dt)[index])
        while left < period:
            right = left + self._dt
            next_value = float(self.at(right)[index])
            if value > 0.0 >= next_value:
                return self._root(index, left, right)
            left, value = right, next_value
        message = (
            f"{self.system.mechanism.name}: the stop {self.stop.name} does not open again within "
            "a turn; change the dimensions or the timing"
        )
        raise SimulationError(message, stop=self.stop.name)

    def _root(self, index: int, left: float, right: float) -> float:
        """Falling zero of a coordinate between two times [s], by regula falsi (Illinois)."""
        high, low = float(self.at(left)[index]), float(self.at(right)[index])
        for _ in range(_ROOT_STEPS):
            t = (left * low - right * high) / (low - high)
            value = float(self.at(t)[index])
            if abs(value) < CYCLE_ROOT or right - left < CYCLE_ROOT * right:
                return t
            if value > 0.0:
                left, high, low = t, value, 0.5 * low
            else:
                right, low, high = t, value, 0.5 * high
        return t

    def sample(self, times: FloatArray, open_index: int) -> Phase:
        """Gap and force at some times, by way of the walk."""
        system = self.system
        for t in (times[0], times[-1]):
            self.at(float(t))
        guess = np.array([self._known[round(t / self._dt)] for t in times])
        motion = system.shaft.driven(times)
        v = np.zeros_like(guess)
        system.prescribe(motion, guess, v, self.rows)
        q, jacobian = close_positions(system.body, guess, self.split)
        v = close_velocities(v, jacobian, self.split)
        a = system.accelerations(motion, q, v, self.rows)
        forces = multipliers(system, motion, q, v, a, jacobian, self.rows, self.split).la_N[:, 0]
        cylinder = system.mechanism.cylinder
        first = cylinder.index_from_angle(float(system.shaft.angle(0.0)))
        index = first + 40.0 * times / system.shaft.period
        return Phase(index, q[:, open_index].copy(), forces / self.stop.lever)
