"""Estimated errors of event times and impulses, from what a run has left unresolved.

A flight of length T that leaves a stop at the rate w ends with a gap error eps and a rate error
eta of its own, and finds its end to an error delta = eps/|w-| plus the round-off of time. The next
collision then is off by

    dt' = dt + T dw/w + delta,      dw'/w' = dw/w + (eta + |a| delta)/|w-|,

since time and final rate of a ballistic flight are proportional to w. Flights with one freedom are
followed more closely: the fundamental matrix of their variational equation (``propagation.py``)
carries an error of the rate, and a start that is late by dt, to their end. Elsewhere a stop that
arrives slower than it moved before is taken to arrive later by as much more.

What flights leave unresolved, eps and eta, is found in ``unresolved.py``. In a phase without
freedom the past is forgotten: only the round-off of its closures and of time is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics.impact import impact_condition
from ..dynamics.multipliers import multipliers
from ..dynamics.system import System
from ..mechanism import Stop
from .collocation import evaluate
from .event import Event, EventKind
from .panel import NEARBY, forces_at
from .propagation import fundamental_matrix
from .segment import Segment
from .unresolved import OpenGaps, round_off

_EPS = float(np.finfo(float).eps)
# Part of a panel over which the slope of a stop force is taken.
_SLOPE_STEP = 1e-3


@dataclass(frozen=True)
class EventError:
    """Estimated errors of an event.

    Attributes:
        time: Of its time [s].
        impulse: Of its impulse and rates, relative [-].
    """

    time: float
    impulse: float


@dataclass(frozen=True)
class _Known:
    """What has been found of panels and flights, by their arrays: copies share theirs."""

    matrices: dict[tuple[int, int], tuple[FloatArray, FloatArray] | None] = field(
        default_factory=dict
    )
    impacts: dict[int, float] = field(default_factory=dict)


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
    known, open_gaps = _Known(), OpenGaps(system)
    place, struck = 0, None
    for event in events:
        stop = system.mechanism.stop(event.stops[0])
        while place < len(segments) and segments[place].t_end <= event.t:
            own = open_gaps.after(segments[place], stop)
            error = _carried(system, segments[place], stop, struck, error, own, known)
            place += 1
        # A rest lies beyond the end of the motion: what is left of its series has the error of its
        # rate.
        beyond = event.t - segments[place - 1].t_end if place else 0.0
        left = max(beyond, 0.0) * error.impulse + event.series_error
        if event.kind is EventKind.RELEASE and place:
            left = _release(system, segments[place - 1], stop.index, open_gaps)
            if not segments[place - 1].kinematic:
                # A motion that comes too late to its release comes too late to what follows.
                error, left = replace(error, time=error.time + left), 0.0
        struck = stop if event.kind is EventKind.COLLISION else None
        if struck is not None:
            error = replace(error, impulse=min(error.impulse + _impact(system, event, known), 1.0))
        open_gaps.forget(event)
        found.append(replace(error, time=error.time + left))
    return tuple(found)


def _carried(
    system: System,
    segment: Segment,
    stop: Stop,
    struck: Stop | None,
    before: EventError,
    own: tuple[float, float],
    known: _Known,
) -> EventError:
    """Errors at the end of a segment, at a stop, from those at its start, where one was struck.

    Args:
        system: The system.
        segment: The segment.
        stop: The stop that it ends at.
        struck: The stop that was struck at its start, if one was.
        before: Errors at its start.
        own: What the gap of the stop and its rate have got wrong since it was struck itself.
        known: What has been found before.
    """
    index = stop.index
    if segment.t_end - segment.t_start <= 0.0:
        return before
    last = segment.panels[-1]
    q, v = last.interpolate(np.array([segment.t_end]))
    velocity = float(v[0, index])
    if velocity == 0.0:
        return before
    end = np.array([(segment.t_end - last.t) / last.h])
    braking = float(evaluate(last.a[:, index], end, 0)[0])
    clock = 2.0 * _EPS * segment.t_end
    if segment.kinematic:
        rate = abs(velocity)
        shift = float(round_off(system, last, q)[index]) / rate + clock
        return EventError(shift, 16.0 * _EPS + abs(braking) * shift / rate)
    rows = system.constraint_set(segment.closed)
    arrival = _Arrival(velocity, braking, clock, *own)
    key = (id(segment.panels[0].q), index)
    if key not in known.matrices:
        known.matrices[key] = fundamental_matrix(system, rows, segment, index)
    propagation = known.matrices[key]
    if propagation is None:
        return _after_ballistic_flight(segment, stop, arrival, before)
    origin = index if struck is None else struck.index
    return _after_propagation(segment, origin, propagation, arrival, before)


class _Arrival(NamedTuple):
    """How a flight comes to a stop, and what it is wrong by of its own.

    Attributes:
        velocity: Of the stop's coordinate at the end [rad/s or m/s].
        braking: Its acceleration there [rad/s^2 or m/s^2].
        clock: Round-off of the time [s].
        eps: Error of the gap [rad or m].
        eta: Error of its rate [rad/s or m/s].
    """

    velocity: float
    braking: float
    clock: float
    eps: float
    eta: float


def _after_propagation(
    segment: Segment,
    origin: int,
    propagation: tuple[FloatArray, FloatArray],
    arrival: _Arrival,
    before: EventError,
) -> EventError:
    """Errors after a flight with one freedom, whose variational equation carries those before.

    Args:
        segment: The flight.
        origin: Coordinate of the stop that was struck at its start.
        propagation: Its fundamental matrix, and the direction of its one freedom.
        arrival: Its end.
        before: Errors at its start.
    """
    matrix, direction = propagation
    first, rate = segment.panels[0], abs(arrival.velocity)
    # An error of the rate of the stop that was struck, and a start that is late.
    w, slowing = float(first.v[0, origin]), float(first.a[0, origin])
    errors = np.array([[0.0, before.time * w], [before.impulse * w, before.time * slowing]])
    ends = matrix @ errors / max(abs(float(direction[origin])), _EPS)
    lates = ends[0] / -arrival.velocity
    late = float(np.abs(lates).sum())
    slower = float(np.abs(ends[1] + arrival.braking * lates).sum()) / rate
    grown = max(1.0, abs(float(matrix[1, 1])))
    shift = grown * arrival.eps / rate + arrival.clock
    relative = slower + (grown * arrival.eta + abs(arrival.braking) * shift) / rate
    length = segment.t_end - segment.t_start
    return EventError(min(late, before.time + length) + shift, min(relative, 1.0))


def _after_ballistic_flight(
    segment: Segment, stop: Stop, arrival: _Arrival, before: EventError
) -> EventError:
    """Errors after a flight whose length and final rate are taken to go with its first rate.

    Args:
        segment: The flight.
        stop: The stop that it ends at.
        arrival: Its end.
        before: Errors at its start.
    """
    rate, length = abs(arrival.velocity), segment.t_end - segment.t_start
    fastest = max(float(np.abs(panel.v[:, stop.index]).max()) for panel in segment.panels)
    shift = arrival.eps / rate + arrival.clock
    # 1 in a ballistic flight.
    slower = max(fastest / rate, 1.0)
    late = min(length * before.impulse * slower, length)
    wrong = arrival.eta + abs(arrival.braking) * (shift + late * (1.0 - 1.0 / slower))
    # At 1 nothing is known any more.
    relative = min(before.impulse * slower + wrong / rate, 1.0)
    return EventError(before.time + late + shift, relative)


def _impact(system: System, event: Event, known: _Known) -> float:
    """Relative round-off of the rates after a collision: the digits that its matrix loses."""
    key = id(event.delta)
    if key not in known.impacts:
        _, jacobian = system.body.closures(event.q[None])
        struck = [system.mechanism.stop(n).index for n, P in event.P_N.items() if P > 0.0]
        condition = impact_condition(system, event.q, jacobian[0], struck)
        known.impacts[key] = min(_EPS * condition, 1.0)
    return known.impacts[key]


def _release(system: System, segment: Segment, index: int, open_gaps: OpenGaps) -> float:
    """Error of the time at which a stop force vanishes: what it is wrong by over its slope [s]."""
    rows = system.constraint_set(segment.closed)
    panel, t = segment.panels[-1], segment.t_end
    if index not in rows.stops or segment.t_start >= t:
        return 0.0
    column, step = rows.stops.index(index), _SLOPE_STEP * min(panel.h, t - panel.t)
    q, v, _, forces = forces_at(system, rows, panel, np.array([t - step, t]))
    slope = float(forces.la_N[1, column] - forces.la_N[0, column]) / step if step else 0.0
    nv = q.shape[1]
    position, velocity = round_off(system, panel, q[1:]), NEARBY * _EPS * np.abs(v[1])
    if panel.integrated:
        left_over = open_gaps.along(segment)
        position, velocity = position + left_over[0], velocity + left_over[1]
    # One coordinate, then one rate at a time.
    moved = q[1] + np.vstack([np.diag(position), np.zeros((nv, nv))])
    moving = v[1] + np.vstack([np.zeros((nv, nv)), np.diag(velocity)])
    _, jacobian = system.body.closures(moved)
    motion = system.shaft.driven(np.full(2 * nv, t))
    a = system.accelerations(motion, moved, moving, rows)
    there = multipliers(system, motion, moved, moving, a, jacobian, rows, panel.split)
    wrong = float(np.abs(there.la_N[:, column] - forces.la_N[1, column]).sum())
    length = t - segment.t_start
    return min(wrong / abs(slope), length) if slope else length
