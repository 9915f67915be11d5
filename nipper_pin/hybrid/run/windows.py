"""The two windows of a run: one transition, or whole turns; those that must repeat are copied."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System
from ...errors import InputError
from ...mechanism import Mechanism
from ...tolerances.hybrid import SAME_POSITION, SAME_RATE, SHORTEST_PANEL
from ...units import coordinate_text, rate_text
from ..event import Event, EventKind, Outcome
from ..segment import Segment, State
from .phase_manager import PhaseManager


def comes_back(system: System) -> bool:
    """True if the drives come back with the cylinder, but for whole turns of a crank."""
    positions = np.zeros((2, system.body.nv))
    positions[:, system.driven] = system.shaft.driven(np.array([0.0, system.shaft.period]))[0]
    return winding(system.mechanism, positions[0], positions[1]) is not None


def winding(
    mechanism: Mechanism, start: FloatArray, end: FloatArray, within: float = SAME_POSITION
) -> FloatArray | None:
    """By how much hinges have wound on where the links stand as before.

    Links stand the same after whole turns of a hinge; springs and stops at the hinge do not.

    Args:
        start: Configuration, shape (nv,) [rad or m].
        end: Another one, likewise.
        within: What positions of one assembly may differ by, in units of coordinates.

    Returns:
        Multiples of 2 pi, zero for all other coordinates, shape (nv,) [rad]; None if the links
        stand elsewhere.
    """
    bound = {spring.index for spring in mechanism.springs}
    bound |= {table.index for table in mechanism.tabulated_springs}
    bound |= {force.index for force in mechanism.forces}
    bound |= {stop.index for stop in mechanism.stops}
    winds = np.zeros(len(start))
    for joint in mechanism.joints:
        winds[joint.index] = joint.kind == "revolute" and joint.index not in bound
    wound = 2.0 * np.pi * winds * np.rint((end - start) / (2.0 * np.pi))
    apart = np.abs(end - start - wound) / mechanism.units
    return wound if apart.max(initial=0.0) <= within else None


def repeats(
    system: System,
    previous: Sequence[Segment],
    current: Sequence[Segment],
    start: State,
    end: State,
) -> FloatArray | None:
    """By how much hinges wind on in this turn, if the one after must equal it.

    With held drives a phase without freedom is determined by the cylinder angle and the assembly of
    the links, so two turns that share such a phase at the same angle are equal from there on. An
    event at the very border of two turns may, by round-off, belong to either, and a flight may
    bring the links to another assembly: this turn has to end as it began.

    Args:
        previous: Segments of the turn before; none before the first.

    Returns:
        As :func:`winding`; None if the next turn has to be computed.
    """
    if not system.held or not comes_back(system):
        return None
    period = system.shaft.period
    units = system.body.units
    changed = float((np.abs(end.v - start.v) / units).max())
    panels = [panel for part in current for panel in part.panels]
    fastest = max(float((np.abs(panel.v) / units).max()) for panel in panels)
    if start.closed != end.closed or changed > SAME_RATE * fastest:
        return None
    # The links may have come to their other assembly, where rates may be the same.
    wound = winding(system.mechanism, start.q, end.q)
    first, last = current[0], current[-1]
    if first.kinematic and last.kinematic and first.closed == last.closed:
        return wound
    shared = any(
        old.kinematic
        and new.kinematic
        and old.closed == new.closed
        and old.t_start + period < new.t_end
        and new.t_start < old.t_end + period
        for old in previous
        for new in current
    )
    return wound if shared else None


def transition(manager: PhaseManager) -> Outcome:
    """From the touch configuration, where the transition stop collides, to its rest."""
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
    """Name of the transition stop, which closes in the touch configuration.

    Raises:
        InputError: The machine has no such stop, or it does not close there.
    """
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
        progress: Called with (turns done, turns in all) after each turn.

    Returns:
        How it ended, and the turn that the following ones are copies of, None without copies.
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
