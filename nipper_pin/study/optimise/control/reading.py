"""A simulated turn of an optimum by the direct engine, read as tables of turns read it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....dynamics import ShaftMotion, System
from ....errors import SimulationError
from ....hybrid import Case, Event, EventKind, Solution, Window, comes_back, simulate
from ....hybrid.result.turns import INDICES, Turn, of_turn
from ....hybrid.result.turns.held import held
from ....mechanism import INDEX_PER_TURN, Mechanism, counted_from, rad_s_from_rpm
from ....tolerances.study import CONTROL_ROUND_OFF
from ....units import S_PER_MIN
from ...true_transition import TrueTransition, first_transition
from ..points.turn import opening, turn_values
from ..problem.quantities import MARGIN, QUANTITIES

MOST_TURNS = 8
"""Largest number of turns before one repeats exactly."""
# Turns start a quarter of a turn before the touch: the machine is in its initial phase there.
_BEFORE = 0.25


class Read(NamedTuple):
    """A quantity read off a turn.

    Attributes:
        value: The quantity, in its unit.
        error: Stated error of it, in the same unit.
    """

    value: float
    error: float


@dataclass(frozen=True, eq=False)
class ControlTurn:
    """One turn: the last of those simulated, or the only one of drives that wind on.

    Attributes:
        solution: The simulated turns.
        number: Number of the turn, from 1.
        repeats: Whether it equals the turn before; True for drives that wind on.
    """

    solution: Solution
    number: int
    repeats: bool

    @property
    def computed(self) -> int:
        """Turns that were computed; those after one that repeats are copies of it."""
        return self.solution.repeated_from or self.solution.case.cycles

    @cached_property
    def turn(self) -> Turn:
        """Its quantities."""
        return Turn(self.solution, self.number, int(self.repeats))

    @cached_property
    def bounces(self) -> TrueTransition:
        """Its first transition."""
        found = first_transition(self.solution, (self.number - 1) * self.solution.shaft.period)
        if found is None:
            message = f"the stop {self.stop} is not hit in the simulated turn"
            raise SimulationError(message, stop=self.stop)
        return found

    @property
    def stop(self) -> str:
        """Name of the transition stop."""
        return self.solution.mechanism.transition_stop

    @cached_property
    def cycle(self) -> tuple[dict[str, float], dict[str, float]]:
        """Quantities of its working cycle, and the same by half of the samples."""
        return turn_values(self.bounces), turn_values(self.bounces, thin=True)

    @property
    def opens(self) -> Event:
        """The event at which the transition stop opens."""
        return opening(self.solution, self.bounces.collisions[0].event)

    @property
    def open(self) -> tuple[float, float]:
        """When the transition stop is open before its first collision: begin and end [s]."""
        begin = self.opens.t - self.solution.shaft.period
        if begin < self.solution.trajectory.span[0]:
            message = f"the stop {self.stop} does not open in the turn before: the drives wind on"
            raise SimulationError(message, stop=self.stop)
        return begin, self.bounces.collisions[0].t

    def without_bounces(self, name: str) -> ControlTurn:
        """Turns of the machine in which a stop takes up every blow."""
        mechanism, case = self.solution.mechanism, self.solution.case
        stops = tuple(
            replace(stop, restitution=0.0, law=None) if stop.name == name else stop
            for stop in mechanism.stops
        )
        calm = replace(mechanism, stops=stops)
        return control_turn(calm, case.speed_rpm, case.rest_rate)

    def late(self, event: Event) -> float:
        """Stated error of the time of an event [s]."""
        return self.solution.errors[event.number - 1].time


def read(turn: ControlTurn, name: str) -> Read:
    """A quantity of a turn.

    Raises:
        SimulationError: The turn has none.
    """
    value, error = _SOURCES[QUANTITIES[name].source](turn, name)
    if value is None:
        message = f"the simulated turn has no {name}"
        raise SimulationError(message, stop=turn.stop)
    size = INDEX_PER_TURN if name in (*INDICES, MARGIN) else abs(value)
    return Read(float(value), float(error + CONTROL_ROUND_OFF * size))


def _setting(turn: ControlTurn, _: str) -> tuple[float | None, float]:
    return S_PER_MIN / turn.solution.shaft.period, 0.0


def _transition(turn: ControlTurn, name: str) -> tuple[float | None, float]:
    found, errors = turn.bounces, turn.bounces.errors
    first = found.collisions[0]
    if name == "duration_s":
        rest = found.duration_error
        if found.transition is None or rest is None:
            return None, 0.0
        return found.transition.duration, errors[0].time + rest
    if name == "rebound_time_s_1":
        return first.rebound_time or 0.0, sum(item.time for item in errors[:2])
    height = first.rebound_amplitude or 0.0
    return height, 2.0 * max(item.impulse for item in errors[:2]) * height


def _cycle(turn: ControlTurn, name: str) -> tuple[float | None, float]:
    if name == "stop_force_N":
        return _stop_force(turn), 0.0
    fine, thin = (values[name] for values in turn.cycle)
    error = abs(fine - thin)
    for index, event in (("closing_index", turn.bounces.collisions[0].event),
                         ("opening_index", turn.opens)):  # fmt: skip
        if name == index:
            error += INDEX_PER_TURN * turn.late(event) / turn.solution.shaft.period
    return fine, error


def _stop_force(turn: ControlTurn) -> float:
    """Least force of the initial phase's stop while the other is open; zero if it is left.

    Where it bounces after the opening nothing holds it, so the force that presses there is that of
    turns in which it takes up every blow.
    """
    mechanism = turn.solution.mechanism
    (waiting,) = mechanism.phase(mechanism.initial_phase).closed
    first, last = turn.open
    left = (
        event.kind is EventKind.RELEASE and waiting in event.stops and first < event.t < last
        for event in turn.solution.events
    )
    if any(left):
        return 0.0
    calm = turn.without_bounces(waiting)
    first, last = calm.open
    parts = [
        (max(item.t_start, first), min(item.t_end, last))
        for item in calm.solution.phases
        if waiting in item.closed and item.t_start < last and item.t_end > first
    ]
    force = held(calm.solution, waiting, parts, 0.0)
    return 0.0 if force is None else force.least


def _turn(turn: ControlTurn, name: str) -> tuple[float | None, float]:
    of, solution = turn.turn, turn.solution
    period, start = solution.shaft.period, solution.case.start_index
    if name == MARGIN:
        if of.opening_index is None or of.rest_index is None:
            return None, 0.0
        rested, opened = counted_from(start, np.array([of.rest_index, of.opening_index]))
        return opened - rested, (of.rest_index_error or 0.0) + (of.opening_index_error or 0.0)
    column = of_turn(name, solution.mechanism)[0].column
    error = getattr(of, f"{column}_error", 0.0)
    if name in ("clamped_time_s", "clamped_share"):
        error = math.fsum(
            turn.late(event)
            for event in solution.events
            if (turn.number - 1) * period <= event.t < turn.number * period
            and (turn.stop in event.closed_before) != (turn.stop in event.closed_after)
        ) / (1.0 if name == "clamped_time_s" else period)  # fmt: skip
    return getattr(of, column), error or 0.0


_SOURCES: Mapping[str, Callable[[ControlTurn, str], tuple[float | None, float]]] = {
    "setting": _setting, "transition": _transition, "cycle": _cycle, "turn": _turn,
}  # fmt: skip


def control_turn(mechanism: Mechanism, speed_rpm: float, rest_rate: float | None) -> ControlTurn:
    """Simulate turns until they repeat.

    Args:
        rest_rate: Separation rate at which bounces end; None: at their limit.

    Raises:
        SimulationError: The motion cannot be followed.
        InputError: A quarter of a turn before the touch the mechanism is not in its initial phase.
    """
    cylinder = mechanism.cylinder
    touch = cylinder.index_from_angle(cylinder.angle_at_touch_rad)
    case = Case(
        speed_rpm=speed_rpm,
        window=Window.CYCLE,
        start_index=touch - _BEFORE * INDEX_PER_TURN,
        rest_rate=rest_rate,
    )
    turning = ShaftMotion(mechanism, rad_s_from_rpm(speed_rpm), 0.0)
    if not comes_back(System(mechanism, turning)):
        return ControlTurn(simulate(mechanism, case), 1, repeats=True)
    turns = simulate(mechanism, replace(case, cycles=MOST_TURNS))
    return ControlTurn(turns, MOST_TURNS, repeats=turns.repeated_from is not None)
