"""Estimated errors of event times and impulses, from what a run has left unresolved.

A flight of length T that leaves a stop at the rate w ends with a gap error eps and a rate error
eta of its own, and finds its end to an error delta = eps/|w-| plus the round-off of time. The next
collision then is off by

    dt' = dt + T dw/w + delta,      dw'/w' = dw/w + (eta + |a| delta)/|w-|,

since time and final rate of a nearly ballistic flight are proportional to w. A stop that arrives
slower than it moved before, as one does whose flight others interrupt, arrives later by as much
more. eps and eta come from the Chebyshev coefficients that are missing (the last ones, times their
rate of decay), from what one more sweep would change and from what the round-off of a state does to
its acceleration, which is more than round-off where masses differ much. In a phase without freedom
the past is forgotten: only the round-off of its closures and of time is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import inverted
from ..dynamics.system import ConstraintSet, System
from ..mechanism import Stop
from .collocation import nodes
from .event import Event
from .panel import Panel
from .segment import Segment

_EPS = float(np.finfo(float).eps)
# True errors were up to 4.6 times the bare estimate, over ten runs at six tolerances; with masses
# that differ by 1e8 up to 11 times.
_SAFETY = 8.0
# Round-off of a polynomial, in units of that of its largest term.
_OPERATIONS = 4.0
# A state that differs by round-off, in units of it.
_NEARBY = 4.0


@dataclass(frozen=True)
class EventError:
    """Estimated errors of an event.

    Attributes:
        time: Of its time [s].
        impulse: Of its impulse and rates, relative [-].
    """

    time: float
    impulse: float


def event_errors(
    system: System, segments: Sequence[Segment], events: Sequence[Event]
) -> tuple[EventError, ...]:
    """Estimate the errors of all events, in their order.

    Args:
        system: The system.
        segments: Segments in order of time.
        events: Events in order of time.
    """
    found: list[EventError] = []
    error = EventError(0.0, 16.0 * _EPS)
    left_over: dict[tuple[int, int], tuple[float, float]] = {}
    place = 0
    for event in events:
        stop = system.mechanism.stop(event.stops[0])
        while place < len(segments) and segments[place].t_end <= event.t:
            error = _carried(system, segments[place], stop, error, left_over)
            place += 1
        # A rest lies beyond the end of the motion: what is left of its series has the error of its
        # rate.
        beyond = event.t - segments[place - 1].t_end if place else 0.0
        left = max(beyond, 0.0) * error.impulse + event.series_error
        found.append(replace(error, time=error.time + left))
    return tuple(found)


def _carried(
    system: System,
    segment: Segment,
    stop: Stop,
    before: EventError,
    left_over: dict[tuple[int, int], tuple[float, float]],
) -> EventError:
    """Errors at the end of a segment from those at its start; copies of a turn share theirs."""
    length, index = segment.t_end - segment.t_start, stop.index
    if length <= 0.0:
        return before
    rows = system.constraint_set(segment.closed)
    last = segment.panels[-1]
    q, v = last.interpolate(np.array([segment.t_end]))
    rate = abs(float(v[0, index]))
    if rate == 0.0:
        return before
    a = abs(float(last.a[-1, index]))
    clock = 2.0 * _EPS * segment.t_end
    if segment.kinematic:
        shift = _gap_round_off(system, last, q, index) / rate + clock
        return EventError(shift, 16.0 * _EPS + a * shift / rate)
    eta = fastest = 0.0
    # Round-off of a coordinate that is not near zero where its gap is; none if it started there.
    eps = 0.0 if segment.panels[0].q[0, index] == stop.at else _EPS * abs(stop.at)
    for panel in segment.panels:
        key = (id(panel.q), index)
        if key not in left_over:
            left_over[key] = _left_over(system, rows, panel, index)
        gap, slope = left_over[key]
        eps += gap + panel.h * eta
        eta += slope
        fastest = max(fastest, float(np.abs(panel.v[:, index]).max()))
    shift = eps / rate + clock
    # 1 in a ballistic flight.
    slower = max(fastest / rate, 1.0)
    late = min(length * before.impulse * slower, length)
    relative = before.impulse * slower + (eta + a * (shift + late * (1.0 - 1.0 / slower))) / rate
    # At 1 nothing is known any more.
    return EventError(before.time + late + shift, min(relative, 1.0))


def _gap_round_off(system: System, panel: Panel, q: FloatArray, index: int) -> float:
    """Round-off of a gap that the closures determine: theirs, by how far it moves for them."""
    amplified = 1.0
    if index in panel.split.dependent:
        _, jacobian = system.body.closures(q)
        _, inverse = inverted(jacobian[0][:, panel.split.columns])
        amplified = float(np.abs(inverse[panel.split.dependent.index(index)]).sum())
    return 8.0 * _EPS * system.body.reach_m * amplified


def _left_over(
    system: System, rows: ConstraintSet, panel: Panel, index: int
) -> tuple[float, float]:
    """What a flight panel leaves unresolved in one position and one velocity."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times)
    again = system.accelerations(motion, panel.q, panel.v, rows)
    swept = (again - a)[:, index]
    signs = (-1.0) ** np.arange(panel.q.shape[1])
    nearby = panel.q * (1.0 + _NEARBY * _EPS * signs)
    rough = float(
        np.abs(system.accelerations(motion, nearby, panel.v, rows) - again)[:, index].max()
    )
    coefficients = np.abs(grid.integrals[0] @ a[:, index])
    known, last = float(coefficients[-4:-2].max()), float(coefficients[-2:].max())
    missing = last * min(last / known, 1.0) if known > 0.0 else last
    round_off = _OPERATIONS * _EPS * (abs(panel.v[0, index]) + h * float(np.abs(a[:, index]).max()))
    position = missing / (2.0 * panel.order) ** 2 + float(np.abs(grid.twice @ swept).max())
    velocity = missing / (2.0 * panel.order) + float(np.abs(grid.once @ swept).max())
    return (
        _SAFETY * h**2 * (position + 0.5 * rough) + h * round_off,
        _SAFETY * h * (velocity + rough) + round_off,
    )
