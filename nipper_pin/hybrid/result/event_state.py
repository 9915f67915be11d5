"""State at the time of an event; a rest lies beyond the last collision that was computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..event import Event, EventKind, found_after
from ..run.phase_manager import go_on
from ..state import State
from .trajectory import Motion

if TYPE_CHECKING:
    from .simulated import Simulated


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
        _, jacobian = system.body.closures(q[None])
        motion = system.shaft.driven_at(began)
        closed = solution.led_events[event.number - 1].closed_after
        start = State(began, q, v, jacobian[0], motion, closed)
        reached, _ = go_on(system, solution.case, start, t)
        if reached is not None:
            q, v = reached.q, reached.v
    times = np.array([t])
    return Motion(times, system.shaft.angle(times), q[None], v[None])
