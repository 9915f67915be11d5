"""A simulated turn of an optimum, by the direct engine with all its bounces, until it repeats."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NoReturn

import numpy as np

from ....errors import SimulationError
from ....hybrid.case import Case, Window
from ....hybrid.event import Event, EventKind
from ....hybrid.result.solution import Solution
from ....hybrid.result.tables import Collision
from ....hybrid.simulate import simulate
from ....mechanism import INDEX_PER_TURN, Mechanism
from ....tolerances.study import DRIVE_RETURNS

MOST_TURNS = 8
"""Largest number of turns before one repeats exactly."""
# Turns start a quarter of a turn before the touch: the machine is in its initial phase there.
_BEFORE = 0.25


@dataclass(frozen=True, eq=False)
class ControlTurn:
    """One turn: the last of those simulated, or the only one of drives that wind on.

    Attributes:
        solution: The simulated turns.
        begin: Begin of the turn [s].
        end: Its end [s].
        repeats: Whether it equals the turn before; True for drives that wind on.
    """

    solution: Solution
    begin: float
    end: float
    repeats: bool

    @property
    def computed(self) -> int:
        """Turns that were computed; those after one that repeats are copies of it."""
        return self.solution.repeated_from or self.solution.case.cycles

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.solution.mechanism

    @property
    def stop(self) -> str:
        """Name of the transition stop."""
        return self.mechanism.transition_stop

    @property
    def waiting(self) -> str:
        """Name of the stop that is closed in the initial phase."""
        (stop,) = self.mechanism.phase(self.mechanism.initial_phase).closed
        return stop

    @cached_property
    def hits(self) -> tuple[Collision, ...]:
        """Collisions of the transition stop, in order of time; at least one.

        Raises:
            SimulationError: There is none.
        """
        found = tuple(
            hit
            for hit in self.solution.collisions
            if hit.stop == self.stop and self.begin <= hit.t < self.end
        )
        if not found:
            self._miss("is not hit")
        return found

    @cached_property
    def rest(self) -> Event:
        """The first rest of the transition stop.

        Raises:
            SimulationError: There is none.
        """
        return self._event(
            lambda event: event.kind is EventKind.REST and self.stop in event.stops,
            "does not come to rest",
        )

    @cached_property
    def opening(self) -> Event:
        """The event at which the transition stop opens again after its rest.

        Raises:
            SimulationError: There is none.
        """
        return self._event(
            lambda event: (
                event.number > self.rest.number
                and self.stop in event.closed_before
                and self.stop not in event.closed_after
            ),
            "does not open again",
        )

    @property
    def open_between(self) -> tuple[float, float]:
        """Times at which the transition stop opened in the turn before, and is hit in this one."""
        return self.opening.t - (self.end - self.begin), self.hits[0].t

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events of the turn."""
        return tuple(item for item in self.solution.events if self.begin <= item.t < self.end)

    def late(self, event: Event) -> float:
        """Stated error of the time of an event [s]."""
        return self.solution.errors[event.number - 1].time

    def blurred(self, event: Event) -> float:
        """Stated relative error of the rates of an event."""
        return self.solution.errors[event.number - 1].impulse

    def _event(self, fits: Callable[[Event], bool], otherwise: str) -> Event:
        found = next((event for event in self.events if fits(event)), None)
        return self._miss(otherwise) if found is None else found

    def _miss(self, what: str) -> NoReturn:
        message = f"in the simulated turn of {self.mechanism.name} the stop {self.stop} {what}"
        raise SimulationError(message, stop=self.stop)


def control_turn(mechanism: Mechanism, speed_rpm: float, rest_rate: float | None) -> ControlTurn:
    """Simulate turns until they repeat.

    Args:
        mechanism: The mechanism.
        speed_rpm: Cylinder speed [r/min].
        rest_rate: Separation rate at which bounces end; None: at their limit.

    Raises:
        SimulationError: The motion cannot be followed.
        InputError: A quarter of a turn before the touch the mechanism is not in its initial phase.
    """
    cylinder = mechanism.cylinder
    since = cylinder.angle_at_touch_rad - cylinder.reference_angle_rad
    touch = cylinder.reference_index + INDEX_PER_TURN * cylinder.sense * since / math.tau
    case = Case(
        speed_rpm=speed_rpm,
        window=Window.CYCLE,
        start_index=touch - _BEFORE * INDEX_PER_TURN,
        rest_rate=rest_rate,
    )
    first = simulate(mechanism, case)
    period = first.shaft.period
    left, right = first.shaft.driven(np.array([0.0, period]))[0]
    if float(np.abs(right - left).max(initial=0.0)) > DRIVE_RETURNS:
        return ControlTurn(first, 0.0, period, repeats=True)
    turns = simulate(mechanism, replace(case, cycles=MOST_TURNS))
    begin = (MOST_TURNS - 1) * period
    return ControlTurn(turns, begin, begin + period, repeats=turns.repeated_from is not None)
