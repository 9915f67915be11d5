"""What follows an event: a rest lies beyond the last collision that was computed."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from ...errors import InputError
from ..event import Event, EventKind, found_after
from ..run.phase_manager import PhaseManager, go_on
from ..state import State
from .simulated import Simulated
from .trajectory import Motion

Run = TypeVar("Run", bound=Simulated)


def motion_at(solution: Simulated, event: Event) -> Motion:
    """The state just after an event, at its time; see :meth:`Solution.motion_at`.

    Raises:
        SimulationError: The motion cannot be followed to the time of a rest.
    """
    system, t = solution.led_system, event.t
    q, v = event.q, event.v_after
    if event.kind is EventKind.REST:
        if solution.segments and t <= solution.segments[-1].t_end:
            return solution.trajectory.evaluate(t)
        began = found_after(solution.events, event).t
        closed = solution.led_events[event.number - 1].closed_after
        start = State.at(system, began, q, v, closed)
        reached, _ = go_on(system, solution.case, start, t)
        if reached is not None:
            q, v = reached.q, reached.v
    times = np.array([t])
    return Motion(times, system.shaft.angle(times), q[None], v[None])


def continued(solution: Run, to: float) -> Run:
    """The run with the motion after its last event; see :meth:`Solution.continued`.

    Raises:
        InputError: The run has no event, or its last one comes later.
        SimulationError: The motion cannot be followed.
    """
    if not solution.events or not to > solution.events[-1].t:
        there = f"comes at {solution.events[-1].t:.6g} s" if solution.events else "is not there"
        message = f"to = {to:g} s: a run is continued behind its last event, which {there}"
        raise InputError(message, to=to)
    last, system = solution.led_events[-1], solution.led_system
    motion = motion_at(solution, last)
    start = State.at(system, last.t, motion.q[0], motion.v[0], last.closed_after)
    manager = PhaseManager(system, solution.case, start)
    manager.step(to)
    before = [item for item in solution.segments if item.t_start < last.t]
    return replace(solution, segments=(*before, *manager.segments))
