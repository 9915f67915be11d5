"""The transition that a design has in its turns, by the engine that suits it.

The tables of the reduced engine hold for one machine; only restitution, spring rates, preloads and
the speed leave it the same. Where nothing else is free they are sampled once and a transition costs
some 50 us. A machine of its own for every point would pay 60 ms for tables to save 2 ms of the
direct engine: those problems are solved by that one. Where the machine does not arrive as a
transition assumes, whole turns are followed: by tables as well if there are some and the motion of
all links is not asked for, in 0.5 ms, else by the direct engine in 40 ms or more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ....errors import InputError, NipperError, SimulationError
from ....hybrid import Case, Outcome, Resolution, comes_back
from ....mechanism import Mechanism
from ....reduced import ReducedModel, ReducedTransition, build, transition, unfit
from ...cases import Settings
from ...transitions import REDUCED, REDUCED_TURN, TURN
from ...true_transition import TrueTransition, assumed_transition, transition_of_turns
from ...turn_transition import TurnTransition, turn_transition
from ..problem.problem import Problem
from .one_machine import sampled_once

_MOST_COLLISIONS = 500


@dataclass(frozen=True, eq=False)
class Bounces:
    """The transition of one design.

    Attributes:
        engine: "reduced" or "direct"; "reduced_turn" or "turn": the same two on whole turns.
    """

    engine: str
    found: ReducedTransition | TurnTransition | TrueTransition

    @property
    def turn(self) -> TrueTransition | None:
        """The transition with its simulated turns; None if no turn was simulated."""
        return (
            self.found if isinstance(self.found, TrueTransition) and self.engine == TURN else None
        )

    @property
    def values(self) -> dict[str, float]:
        """Quantities by name; NaN where the series has no such rebound."""
        found = self.found
        if not isinstance(found, TrueTransition):
            height, time = found.rebound_amplitude[0], found.rebound_time[0]
            duration: float | None = found.duration
        else:
            first, last = found.collisions[0], found.transition
            height, time = first.rebound_amplitude, first.rebound_time
            duration = None if last is None else last.duration
        return _named(height, time, duration)

    @property
    def errors(self) -> dict[str, float]:
        """Stated errors of these quantities."""
        found = self.found
        if not isinstance(found, TrueTransition):
            return _named(found.amplitude_error[0], found.rebound_error[0], found.duration_error)
        first, errors = found.collisions[0], found.errors
        blur = max(item.impulse for item in errors[:2])
        late = sum(item.time for item in errors[:2])
        height, time = first.rebound_amplitude or 0.0, first.rebound_time or 0.0
        rest = found.duration_error or 0.0
        return _named(2.0 * blur * height, late + blur * time, rest + errors[0].time)


def _named(height: float | None, time: float | None, duration: float | None) -> dict[str, float]:
    found = {"rebound_amplitude_1": height, "rebound_time_s_1": time, "duration_s": duration}
    return {name: np.nan if x is None else float(x) for name, x in found.items()}


class Transitions:
    """Transitions of the designs of one problem."""

    def __init__(self, problem: Problem) -> None:
        """Prepare; nothing is computed yet."""
        self._problem = problem
        self._machine: Mechanism | None = None

    @property
    def why(self) -> str:
        """Reason for the choice of the engine."""
        return self._sampled[1]

    def at(self, mechanism: Mechanism, speed_rpm: float, *, dense: bool = True) -> Bounces:
        """The transition of one design, as its turns have it.

        Args:
            dense: Whether turns must give the motion of all links, and so be simulated.

        Raises:
            SimulationError: It cannot be simulated, or does not come to rest.
        """
        reduced = self._by_tables(mechanism, speed_rpm)
        if reduced is not None and reduced.premise_holds:
            return Bounces(REDUCED, reduced)
        if not dense and (turn := self._by_turns(mechanism, speed_rpm)) is not None:
            return Bounces(REDUCED_TURN, turn)
        found = assumed_transition(mechanism, self._case(speed_rpm))
        if found.premise_holds is not True and comes_back(found.solution.system):
            return self.in_turn(mechanism, speed_rpm, found.solution.premise.why)
        return Bounces("direct", _at_rest(found))

    def in_turn(
        self, mechanism: Mechanism, speed_rpm: float, why: str, before: float = 0.0
    ) -> Bounces:
        """The transition of a simulated turn.

        Args:
            why: Why it is not taken alone.
            before: Part of a turn before the touch at which the turns start.

        Raises:
            SimulationError: It cannot be simulated, does not come to rest, or turns differ.
        """
        found = transition_of_turns(mechanism, self._case(speed_rpm), why, before)
        if found.solution.repeated_from is None:
            message = (
                f"{mechanism.name}: turns differ from one another, and so do their transitions"
            )
            raise SimulationError(message, speed_rpm=speed_rpm)
        return Bounces(TURN, _at_rest(found))

    def _case(self, speed_rpm: float) -> Case:
        return Case(
            speed_rpm=speed_rpm,
            rest_rate=self._problem.rest_rate,
            resolution=Resolution(tolerance=self._problem.tolerance),
            max_collisions=_MOST_COLLISIONS,
        )

    @cached_property
    def _sampled(self) -> tuple[ReducedModel | None, str]:
        return sampled_once(self._problem, self._built)

    def _built(self, mechanism: Mechanism) -> ReducedModel:
        reason = unfit(mechanism)
        if reason is not None:
            raise InputError(reason, model=mechanism.name)
        self._machine = mechanism
        return build(mechanism)

    def _by_tables(self, mechanism: Mechanism, speed_rpm: float) -> ReducedTransition | None:
        """The transition by the reduced engine; None where its tables do not cover it."""
        model = self._sampled[0]
        if model is None:
            return None
        try:
            return transition(
                model,
                speed_rpm=speed_rpm,
                rest_rate=self._problem.rest_rate,
                tolerance=self._problem.tolerance,
                **_numbers(mechanism),
            )
        except NipperError:
            # The direct engine computes cases outside the tables, and the point records its name.
            return None

    def _by_turns(self, mechanism: Mechanism, speed_rpm: float) -> TurnTransition | None:
        """The transition of a turn by tables; None where they cannot tell it."""
        base = self._machine
        if self._sampled[0] is None or base is None:
            return None
        settings = Settings(
            rest_rate=self._problem.rest_rate,
            tolerance=self._problem.tolerance,
            max_collisions=_MOST_COLLISIONS,
        )
        try:
            found = turn_transition(
                base, speed_rpm=speed_rpm, settings=settings, **_numbers(mechanism)
            )
        except NipperError:
            # The direct engine follows what tables do not, and the point records its name.
            return None
        told = found.premise_holds is False and found.repeats
        return found if told and found.outcome is Outcome.AT_REST else None


def _numbers(mechanism: Mechanism) -> dict[str, Any]:
    """What a machine may have otherwise than the one whose tables were sampled."""
    return {
        "restitution": mechanism.stop(mechanism.transition_stop).restitution,
        "stiffness": np.array([spring.stiffness for spring in mechanism.springs]),
        "preload": np.array([spring.preload for spring in mechanism.springs]),
    }


def _at_rest(found: TrueTransition) -> TrueTransition:
    if found.outcome is not Outcome.AT_REST:
        raise SimulationError(found.outcome.value, outcome=found.outcome.name)
    return found
