"""The transition that a machine has in its turns, whatever is assumed of how it arrives."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..errors import SimulationError
from ..hybrid import (
    Case,
    Collision,
    EventError,
    EventKind,
    Outcome,
    Solution,
    Transition,
    Window,
    simulate,
)
from ..hybrid.result.premise import MOST_IN_TURN
from ..mechanism import INDEX_PER_TURN, Mechanism

# Turns that are followed from the touch; the last one is read, from half a turn before its touch.
_TURNS = 3


@dataclass(frozen=True, eq=False)
class TrueTransition:
    """A transition and where it was read.

    Attributes:
        solution: What was simulated: the transition alone, or whole turns.
        premise_holds: Whether the machine arrives in its initial phase; None where that was not
            asked. Where it is False the transition is that of the turns.
        collisions: Collisions of the transition stop, from the first one to rest.
        transition: The transition; None without rest.
        outcome: How it ended.
        message: What is to be known of it; empty if it is an ordinary one.
    """

    solution: Solution
    premise_holds: bool | None
    collisions: tuple[Collision, ...]
    transition: Transition | None
    outcome: Outcome
    message: str = ""

    @property
    def errors(self) -> tuple[EventError, ...]:
        """Estimated errors of the collisions."""
        return tuple(self.solution.errors[hit.event.number - 1] for hit in self.collisions)

    @property
    def duration_error(self) -> float | None:
        """Estimated error of the duration [s]; None without rest."""
        if self.transition is None:
            return None
        stop = self.solution.mechanism.transition_stop
        end = next(
            event
            for event in self.solution.events[self.collisions[-1].event.number :]
            if event.kind is EventKind.REST and stop in event.stops
        )
        return float(self.solution.errors[end.number - 1].time)


def true_transition(mechanism: Mechanism, case: Case) -> TrueTransition:
    """The transition of a case; that of whole turns if the machine arrives otherwise.

    Args:
        case: The case; its window is not used.

    Raises:
        SimulationError: The motion cannot be followed, or no turn has a collision of the
            transition stop.
        InputError: The mechanism has no transition.
    """
    found = assumed_transition(mechanism, case)
    if found.premise_holds is False:
        return transition_of_turns(mechanism, case, found.solution.premise.why)
    return found


def assumed_transition(mechanism: Mechanism, case: Case) -> TrueTransition:
    """The transition of a case that starts in the initial phase, true or not.

    Args:
        case: The case; its window is not used.

    Raises:
        SimulationError: The motion cannot be followed.
        InputError: The mechanism has no transition.
    """
    solution = simulate(mechanism, replace(case, window=Window.TRANSITION))
    stop = mechanism.transition_stop
    hits = tuple(hit for hit in solution.collisions if hit.stop == stop)
    found = solution.transitions[-1] if solution.transitions else None
    return TrueTransition(solution, solution.premise_holds, hits, found, solution.outcome)


def transition_of_turns(
    mechanism: Mechanism, case: Case, why: str, before: float = 0.0
) -> TrueTransition:
    """The first transition of a turn that repeats, from simulated turns.

    Args:
        case: The case; its window, turns and start are not used, and its largest number of
            collisions is that of the transition.
        why: Why the turns have to be simulated.
        before: Part of a turn before the touch at which the turns start, in the initial phase. At
            the touch itself a machine that arrives there is not seen to repeat.

    Raises:
        SimulationError: The motion cannot be followed, or no turn has a collision of the
            transition stop.
    """
    cylinder, stop = mechanism.cylinder, mechanism.transition_stop
    turns = replace(
        case,
        window=Window.CYCLE,
        cycles=_TURNS,
        start_index=cylinder.index_from_angle(cylinder.angle_at_touch_rad)
        - before * INDEX_PER_TURN,
        max_collisions=max(case.max_collisions, MOST_IN_TURN),
    )
    solution = simulate(mechanism, turns)
    begin = (_TURNS - 1.5 + before) * solution.shaft.period
    found = first_transition(solution, begin)
    if found is None:
        message = f"{why} No turn has a collision of stop {stop!r}: {solution.outcome.value}"
        raise SimulationError(message, stop=stop, outcome=solution.outcome.name)
    message = f"{why} This is the transition of the simulated turn."
    if solution.repeated_from is None:
        message += f" Turns differ from one another; it is that of number {_TURNS}."
    most = case.max_collisions
    if len(found.collisions) > most:
        hits, outcome = found.collisions[:most], Outcome.TOO_MANY_COLLISIONS
        return TrueTransition(solution, False, hits, None, outcome, message)
    return replace(found, premise_holds=False, message=message)


def first_transition(solution: Solution, begin: float) -> TrueTransition | None:
    """The first transition of a run from a time on; None if the transition stop is not hit.

    Args:
        begin: The time [s].
    """
    stop = solution.mechanism.transition_stop
    hits = [hit for hit in solution.collisions if hit.stop == stop and hit.t >= begin]
    if not hits:
        return None
    found = next((item for item in solution.transitions if item.t_start == hits[0].t), None)
    outcome = Outcome.NO_REST if found is None else Outcome.AT_REST
    own = tuple(hits if found is None else hits[: found.collisions])
    return TrueTransition(solution, None, own, found, outcome)
