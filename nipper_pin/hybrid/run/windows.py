"""The two windows of a run: one transition, or whole turns."""

from __future__ import annotations

from collections.abc import Callable

from ...errors import InputError
from ...tolerances.hybrid import SHORTEST_PANEL
from ...units import coordinate_text, rate_text
from ..event import Event, EventKind
from ..segment import Segment
from .outcome import Outcome
from .periodicity import repeats
from .phase_manager import PhaseManager


def transition(manager: PhaseManager) -> Outcome:
    """From the touch configuration, where the transition stop collides, to its rest.

    Args:
        manager: The run, at its start.

    Raises:
        InputError: The machine has no such stop, or it does not close there.
        SimulationError: The motion cannot be followed.
    """
    name = _closing_stop(manager)
    manager.collide({name} | manager.closing())
    while True:
        # Most events are no rests.
        resting = manager.events[-1].kind is EventKind.REST
        rest = _rest_of(manager, name) if resting else None
        if rest is not None and _followed(manager, name, rest.t):
            return Outcome.AT_REST
        if manager.collisions >= manager.case.max_collisions:
            return Outcome.TOO_MANY_COLLISIONS
        if not manager.step(manager.system.shaft.period):
            return Outcome.NO_REST


def _rest_of(manager: PhaseManager, name: str) -> Event | None:
    """The rest of a stop, if the latest events hold it."""
    for event in reversed(manager.events):
        if event.kind is not EventKind.REST:
            return None
        if name in event.stops:
            return event
    return None


def _followed(manager: PhaseManager, name: str, t_rest: float) -> bool:
    """Follow parts that do not touch a stop until its rest [s]; False if they strike too often."""
    if manager.system.whole:
        return True
    together = manager.system.coupled([name])
    stops = {stop.name for stop in manager.mechanism.stops}
    if stops <= together | manager.state.closed:
        return True
    while manager.step(t_rest):
        if manager.collisions >= manager.case.max_collisions:
            return False
    # What comes to rest later is no part of the transition.
    while name not in manager.events[-1].stops:
        manager.events.pop()
    return True


def _closing_stop(manager: PhaseManager) -> str:
    """Name of the transition stop, which closes in the touch configuration."""
    mechanism, state = manager.mechanism, manager.state
    name = mechanism.transition_stop
    if not name:
        message = (
            f"{mechanism.name} has no stop, so there is no transition: simulate whole "
            "turns (window cycle), or give it a stop"
        )
        raise InputError(message, model=mechanism.name)
    stop = mechanism.stop(name)
    gap, rate = stop.gap(state.q), stop.rate(state.v)
    kind = mechanism.joints[stop.index].kind
    if gap != 0.0:
        message = (
            f"stop {name!r} stands open by {coordinate_text(gap, kind)} in the touch "
            "configuration, where a transition starts: simulate whole turns (window cycle), or "
            "make transition_stop one that is closed there"
        )
        raise InputError(message, stop=name, gap=gap)
    if rate >= 0.0:
        if mechanism.drives:
            how = "check cylinder.angle_at_touch_deg and cylinder.direction"
        else:
            how = "without a drive nothing moves there"
        message = (
            f"stop {name!r} is not closing in the touch configuration, where a transition starts "
            f"(rate {rate_text(rate, kind)}): {how}; or simulate whole turns (window cycle)"
        )
        raise InputError(message, stop=name, rate=rate)
    return name


def turns(
    manager: PhaseManager, progress: Callable[[int, int], None] | None
) -> tuple[Outcome, int | None]:
    """Whole turns, until one is known to repeat.

    Args:
        manager: The run, at its start.
        progress: Called with (turns done, turns in all) after each turn.

    Returns:
        How it ended, and the turn that the following ones are copies of, None without copies.

    Raises:
        SimulationError: The motion cannot be followed.
    """
    case, period = manager.case, manager.system.shaft.period
    previous: list[Segment] = []
    # What is over within the shortest time that is resolved, is over at the end.
    manager.end = (case.cycles + SHORTEST_PANEL) * period
    manager.touch()
    for turn in range(1, case.cycles + 1):
        first_segment, first_event = len(manager.segments), len(manager.events)
        start, before = manager.state, manager.collisions
        while manager.step(turn * period):
            if manager.collisions - before >= case.max_collisions:
                return Outcome.TOO_MANY_COLLISIONS, None
        if progress is not None:
            progress(turn, case.cycles)
        current = manager.segments[first_segment:]
        wound = None
        # Of the last copy a rest in the turn that follows would lie beyond the window.
        over = any(event.t > turn * period for event in manager.events[first_event:])
        if case.reuse_cycles and turn < case.cycles and not over:
            wound = repeats(manager.system, previous, current, start, manager.state)
        if wound is not None:
            manager.copy(current, manager.events[first_event:], case.cycles - turn, wound)
            if progress is not None:
                progress(case.cycles, case.cycles)
            return _at_the_end(manager), turn
        previous = current
    return _at_the_end(manager), None


def _at_the_end(manager: PhaseManager) -> Outcome:
    return Outcome.COMPLETED if not manager.state.series else Outcome.STILL_BOUNCING
