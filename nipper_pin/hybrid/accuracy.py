"""Estimated errors of event times and impulses, from what a run has left unresolved.

What flights leave unresolved (``unresolved.py``) and round-off are the sources of deviations
(``deviations.py``) of the computed motion. The variational equation carries them over flights
(``propagation.py``), the saltation matrix over collisions (``saltation.py``). A deviation (dq, dv)
reaches a stop of the coordinate x late by dt = -dx/v-, with a rate that is wrong by dv + a- dt and
an impulse that is wrong by the derivative of the impact law. A phase without freedom forgets the
past: only the round-off of its closures and of time is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics.system import System
from .deviations import Deviations
from .event import Event, EventKind
from .let_go import release_error
from .linear_maps import LinearMaps, pushing
from .propagation import free_coordinates
from .segment import Segment
from .unresolved import of_closures, round_off

_EPS = float(np.finfo(float).eps)
# Round-off of rates that follow from drives and closures, and of the clock, relative.
_RATE, _CLOCK = 16.0 * _EPS, 2.0 * _EPS


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
    if not events:
        return ()
    known = LinearMaps(system)
    start = segments[0].panels[0].v[0] if segments else events[0].v_before
    deviations, error = _of_rates(start), EventError(0.0, _RATE)
    found, place, last = [], 0, None
    for event in events:
        flown = 0.0
        # A rest lies beyond the end of the motion before it.
        while (
            event.kind is not EventKind.REST
            and place < len(segments)
            and segments[place].t_end <= event.t
        ):
            last = segments[place]
            place += 1
            if last.kinematic:
                error = EventError(0.0, _RATE)
            flown += last.t_end - last.t_start
            deviations = _flown(system, known, last, deviations)
        arrival = _Arrival(event, last, flown, error)
        if event.kind is EventKind.COLLISION:
            deviations, error = _struck(system, known, arrival, deviations)
            found.append(error)
        elif event.kind is EventKind.REST:
            deviations, stated = _rested(system, known, arrival, deviations)
            found.append(stated)
        else:
            error = _released(system, arrival, deviations)
            found.append(error)
    return tuple(found)


class _Arrival(NamedTuple):
    """How a run comes to an event.

    Attributes:
        event: The event.
        segment: The last segment before it; None if there is none.
        flown: Time since the event before [s].
        before: Errors of that event.
    """

    event: Event
    segment: Segment | None
    flown: float
    before: EventError


def _of_rates(v: FloatArray) -> Deviations:
    """Round-off of rates that follow from drives and closures."""
    return Deviations.independent(np.zeros_like(v), _RATE * np.abs(v))


def _flown(
    system: System, known: LinearMaps, segment: Segment, deviations: Deviations
) -> Deviations:
    """Deviations at the end of a segment from those at its start."""
    if segment.kinematic:
        panel = segment.panels[-1]
        q, v = panel.interpolate_at(segment.t_end)
        opened = of_closures(system, panel, q, v)
        return _of_rates(v).joined(Deviations(opened, np.zeros(opened.shape[1])))
    if segment.t_end <= segment.t_start:
        return deviations
    rows, first = system.constraint_set(segment.closed), segment.panels[0]
    found = deviations.later(-deviations.late, np.concatenate([first.v[0], first.a[0]]))
    touching = [s.index for s in system.mechanism.stops if first.q[0, s.index] == s.at]
    for panel, begin, end in segment.pieces():
        free = free_coordinates(rows, panel.split)
        loose = np.zeros(system.body.nv)
        if panel is first:
            # Where a gap has not just opened its start has the round-off of the closures.
            loose[free] = round_off(system, panel, panel.q[:1])[free]
            loose[touching] = 0.0
        else:
            # Where panels meet a gap has the round-off of its coordinate, however small it is.
            loose[free] = _EPS * np.abs(panel.q[0, free])
        flight = known.flight(rows, panel, end - begin)
        own = Deviations(flight.own, np.zeros(flight.own.shape[1]))
        found = found.joined(Deviations.independent(loose, np.zeros_like(loose)))
        found = found.through(flight.matrix).joined(own).merged()
    return found


def _struck(
    system: System, known: LinearMaps, arrival: _Arrival, deviations: Deviations
) -> tuple[Deviations, EventError]:
    """Deviations after a collision and its errors, from the deviations before it."""
    event, nv = arrival.event, system.body.nv
    index = system.mechanism.stop(event.stops[0]).index
    rate = float(event.v_before[index])
    if rate == 0.0:
        return deviations, arrival.before
    impact = known.impact(event)
    # Linear maps know nothing of flights that miss the stop: no collision is off by all its flight.
    most = arrival.before.time + arrival.flown
    late = -deviations.states[index] / rate
    total = float(np.abs(late).sum())
    if total > most:
        late *= most / total
    rates = np.concatenate([event.v_before, impact.a])
    seen = min(_seen_late(system, known, arrival, index), most)
    found = deviations.later(late, rates)
    found = found.joined(Deviations((seen * rates)[:, None], np.array([seen])))
    time = float(np.abs(found.late).sum())
    found = found.within(index, 0.0)
    relative = found.size(nv + index) / abs(rate)
    found = found.within(nv + index, abs(rate))
    if stops := pushing(system, event):
        pushed = np.abs(impact.pushes @ found.states).sum(axis=1)
        relative = max(relative, float(pushed[0]) / abs(event.P_N[stops[0].name])) + impact.lost
        # The law itself determines the rates of the stops that are struck.
        rough = impact.lost * np.abs(event.delta)
        rough[[stop.index for stop in stops]] = 0.0
        loose = Deviations.independent(np.zeros_like(rough), rough)
        found = found.through(impact.matrix).joined(loose)
    return found.merged(), EventError(time, min(relative, 1.0))


def _seen_late(system: System, known: LinearMaps, arrival: _Arrival, index: int) -> float:
    """By how much a gap is seen to close late: round-off of time, and of a dependent gap [s]."""
    event, segment = arrival.event, arrival.segment
    if segment is None or arrival.flown <= 0.0:
        return 0.0
    panel, wrong = segment.panels[-1], 0.0
    if panel.integrated and index in panel.split.dependent:
        wrong = float(round_off(system, panel, event.q[None])[index])
        wrong += float(known.position(panel)[index])
    return _CLOCK * event.t + wrong / abs(float(event.v_before[index]))


def _rested(
    system: System, known: LinearMaps, arrival: _Arrival, deviations: Deviations
) -> tuple[Deviations, EventError]:
    """Deviations after a rest and its errors, from the deviations after the last collision."""
    event, late = arrival.event, deviations.late
    index = system.mechanism.stop(event.stops[0]).index
    rate = float(event.v_before[index])
    if rate != 0.0 and pushing(system, event):
        # What is left of the series lasts in proportion to its rate.
        beyond = event.t - (arrival.segment.t_end if arrival.segment is not None else 0.0)
        late = late + beyond * deviations.states[system.body.nv + index] / rate
        deviations = deviations.through(known.impact(event).matrix).merged()
    time = float(np.abs(late).sum()) + event.series_error
    return deviations, EventError(time, arrival.before.impulse)


def _released(system: System, arrival: _Arrival, deviations: Deviations) -> EventError:
    """Errors of a release, from the deviations there; it changes none of them."""
    event, segment = arrival.event, arrival.segment
    if segment is None or arrival.flown <= 0.0:
        return arrival.before
    rows = system.constraint_set(segment.closed)
    index = system.mechanism.stop(event.stops[0]).index
    if index not in rows.stops:
        return arrival.before
    late = release_error(system, rows, segment.panels[-1], event.t, deviations, index)
    return EventError(min(late, arrival.flown) + _CLOCK * event.t, arrival.before.impulse)
