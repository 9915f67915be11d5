"""Does the machine arrive at the touch in its initial phase, as a transition assumes?

A transition starts in the touch configuration: the stops of the initial phase are closed and have
come to rest. Whether a turn brings the machine there is told by following the transition on, to
the next touch. Where drives determine the motion nothing of the past is left, so a machine that
arrives in the initial phase repeats this very transition in every turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...dynamics import System
from ...errors import SimulationError
from ...tolerances.hybrid import DECISION_TOLERANCE, REST_BEFORE_TOUCH, SAME_ASSEMBLY
from ..case import Case, Resolution, Window
from ..contact.active_set import active_set
from ..event import Event, EventKind
from ..run.phase_manager import go_on
from ..run.windows import comes_back, winding
from ..segment import Segment, State
from .trajectory import Trajectory

MOST_IN_TURN = 10_000
"""Collisions of a turn that are followed."""
_PANELS = 6


@dataclass(frozen=True)
class Premise:
    """Whether the premise of a transition holds.

    Attributes:
        holds: True or False; None where it was not asked or cannot be told.
        why: One sentence.
    """

    holds: bool | None
    why: str


def premise_of(
    system: System,
    case: Case,
    events: Sequence[Event],
    segments: Sequence[Segment],
    trajectory: Trajectory,
) -> Premise:
    """Follow a transition to the next touch and see in which phase the machine arrives.

    Events and motion are those of the system that was followed; whole turns assume nothing.
    """
    if case.window is not Window.TRANSITION:
        return Premise(None, "Whole turns assume nothing of how the machine arrives.")
    touch = events[0]
    reason = _unanswerable(system, touch)
    if reason:
        return Premise(None, reason)
    before = (1.0 - REST_BEFORE_TOUCH) * system.shaft.period
    start = _end(system, events[-1], segments, trajectory)
    further = replace(
        case,
        max_collisions=MOST_IN_TURN,
        resolution=Resolution(
            tolerance=max(case.resolution.tolerance, DECISION_TOLERANCE),
            panels_per_turn=_PANELS,
        ),
    )
    try:
        end, later = go_on(system, further, start, before)
    except SimulationError as error:
        return Premise(None, f"The turn cannot be followed to the next touch: {error.message}")
    if end is None:
        return Premise(None, "The turn has too many collisions to be followed to the next touch.")
    return _judged(system, touch, end, (*events, *later))


def _unanswerable(system: System, touch: Event) -> str:
    """Reason why the premise cannot be checked; empty if it can."""
    if not system.held:
        return "Inertial shafts remember the turns before, which a transition does not know."
    if system.constraint_set(touch.closed_before).freedom != 0:
        return "The initial phase leaves a freedom, whose motion the drives do not determine."
    if not comes_back(system):
        return "The drives do not come back with the cylinder, so no turn repeats the touch."
    return ""


def _end(system: System, last: Event, segments: Sequence[Segment], trajectory: Trajectory) -> State:
    """State at the end of a run, from which it can be followed on."""
    t, q, v = last.t, last.q, last.v_after
    if segments:
        t = segments[-1].t_end
        if t > last.t:
            state = trajectory.evaluate(np.array([t]), left=True)
            q, v = state.q[0], state.v[0]
    return State.at(system, t, q, v, last.closed_after)


def _judged(system: System, touch: Event, end: State, events: tuple[Event, ...]) -> Premise:
    """Compare the state just before the next touch with the one that the transition starts from."""
    names, period = touch.closed_before, system.shaft.period
    there = "one turn later, where the next transition would start"
    if off := sorted(names - end.closed):
        return Premise(False, f"{_listed(off)} off its stop {there}.")
    if early := sorted(end.closed - names):
        return Premise(False, f"{_listed(early)} already closed {there}.")
    rests = [event.t + event.series_error for event in events if event.kind is EventKind.REST]
    if max(rests, default=0.0) > (1.0 - REST_BEFORE_TOUCH) * period:
        return Premise(False, f"a stop still bounces {there}.")
    left = REST_BEFORE_TOUCH * period
    arrived = touch.q - left * touch.v_before
    if winding(system.mechanism, arrived, end.q, SAME_ASSEMBLY) is None:
        return Premise(False, f"the links stand in another assembly {there}.")
    motion = system.shaft.driven_at(0.0)
    jacobian = system.body.closures(touch.q[None])[1][0]
    stay = active_set(system, motion, touch.q, touch.v_before, jacobian, names)
    if off := sorted(names - stay):
        return Premise(False, f"{_listed(off)} just leaving its stop {there}.")
    return Premise(True, "The machine arrives at the next touch as at this one.")


def _listed(stops: list[str]) -> str:
    return " and ".join(stops) + (" is" if len(stops) == 1 else " are")
