"""Estimated errors of event times and impulses, from what a run has left unresolved.

What flights leave unresolved (``local_error.py``) and round-off are the sources of deviations
(``zonotope.py``) of the computed motion. The variational equation carries them over flights
(``variational.py``), the saltation matrix over collisions (``saltation.py``). A deviation (dq, dv)
reaches a stop of the coordinate x late by dt = -dx/v-, with a rate that is wrong by dv + a- dt and
an impulse that is wrong by the derivative of the impact law. A phase without freedom forgets the
past: only the round-off of its closures and of time is left. Each part of a machine is followed
from event to event of its own (:class:`.Part`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ...dynamics import System, multipliers
from ...tolerances.hybrid import (
    CLOCK_ROUND_OFF,
    COORDINATE_ROUND_OFF,
    FORCE_SLOPE_STEP,
    RATE_ROUND_OFF,
    ROOT_RESOLUTION,
    SERIES_ERROR_SAFETY,
)
from ..history import Event, EventKind, Segment, State
from ..motion.panel import forces_at
from .linear_maps import ImpactMap, LinearMaps, PanelMaps, pushing
from .local_error import at_start, of_closures, round_off, unsure
from .saltation import StrikeError, after_all, beside, stated, still_apart
from .variational import Freedoms, free_coordinates, tangents
from .zonotope import Zonotope, parts_of


def _late_release(
    maps: LinearMaps, segment: Segment, t: float, deviations: Zonotope, index: int
) -> float:
    """Error [s] of the time t at which the force of a closed stop vanishes, infinite if none falls.

    It is what the force is wrong by over its slope.
    """
    system, part, panel = maps.system, maps.part, segment.panels[-1]
    phase = system.constraint_set(segment.closed)
    column, step = phase.stops.index(index), FORCE_SLOPE_STEP * min(panel.h, t - panel.t)
    if step <= 0.0:
        return np.inf
    q, v, _, forces = forces_at(system, phase, panel, np.array([t - step, t]))
    slope = float(forces.la_N[1, column] - forces.la_N[0, column]) / step
    q, v, nv, own = q[1:], v[1:], system.body.nv, part.coordinates
    free = free_coordinates(phase, panel.split) if panel.integrated else []
    along = Freedoms.of_one(system, [k for k in free if k in own], own)
    units, turned = (item[:, 0] for item in tangents(system, q, v, panel.split, along))
    x = along.steps(units[:, None])
    w = x * along.fastest(v)
    # Round-off of one coordinate, then of one rate at a time; then along the freedoms.
    by = unsure(system, panel.split)
    opened = of_closures(system, panel.split, q[0], v[0], by).T[own]
    rounded = np.diag(COORDINATE_ROUND_OFF * np.abs(v[0]))[own]
    places = [opened[:, :nv], 0.0 * rounded, x * units, 0.0 * units]
    rates = [opened[:, nv:], rounded, x * turned, w * units]
    moved, moving = q + np.vstack(places), v + np.vstack(rates)
    _, jacobian = system.body.closures(moved)
    motion = system.shaft.driven(np.full(len(moved), t))
    a = system.accelerations(motion, moved, moving, phase)
    there = multipliers(system, motion, moved, moving, a, jacobian, phase, panel.split)
    changes = there.la_N[:, column] - forces.la_N[1, column]
    wrong = float(np.abs(changes[: 2 * part.size]).sum())
    by_state = changes[2 * part.size :] / np.concatenate([x, w])[:, 0]
    rows = [part.place(k) for k in along.columns]
    rows += [part.size + place for place in rows]
    wrong += float(np.abs(by_state @ deviations.states[rows]).sum())
    return wrong / abs(slope) if slope else np.inf


@dataclass(frozen=True)
class EventError:
    """Estimated errors of an event.

    Attributes:
        time: Of its time [s]; of stops that are struck together the largest.
        impulse: Of the rates and the impulse of its first stop, ``event.stops[0]``, relative [-].
            At a release, of the collision before.
        since: Of the time since the event before it in the part of that stop [s].
        impulses: Of every impulse that the event lists in ``P_N``, by stop and in its unit
            [N m s or N s]. An impulse beside a much larger one of its part has at least the
            round-off of that.
        strikes: Of each stop, by name, where it strikes several or is one of several parts.
    """

    time: float
    impulse: float
    since: float
    impulses: dict[str, float]
    strikes: dict[str, StrikeError] = field(default_factory=dict)

    def at(self, stop: str) -> StrikeError:
        """Errors of one of the stops that it strikes, by name."""
        return self.strikes.get(stop, StrikeError(self.time, self.impulse, self.since))


# Where drives determine the motion, or nothing has happened yet.
_FRESH = EventError(0.0, RATE_ROUND_OFF, 0.0, {})


def event_errors(
    system: System, segments: Sequence[Segment], events: Sequence[Event]
) -> tuple[EventError, ...]:
    """Estimate the errors of all events, in their order."""
    if not events:
        return ()
    panels, start = PanelMaps(system, events), _at_start(system, segments, events[0])
    found: list[list[tuple[Event, EventError]]] = [[] for _ in events]
    for part in parts_of(system):
        own = [part.event(event) for event in events if not part.stops.isdisjoint(event.stops)]
        maps = LinearMaps(part, panels)
        errors = _of_part(maps, segments, own, _State(part.of(start.states), _FRESH))
        for event, error in zip(own, errors, strict=True):
            found[event.number - 1].append((event, error))
    return tuple(_of_all_parts(*item) for item in zip(events, found, strict=True))


def _of_all_parts(event: Event, found: Sequence[tuple[Event, EventError]]) -> EventError:
    """Errors of an event from those in each of its parts."""
    if len(found) == 1:
        return found[0][1]
    # That of its first stop comes first.
    found = sorted(found, key=lambda item: item[0].stops[0] != event.stops[0])
    impulses = {name: wrong for _, error in found for name, wrong in error.impulses.items()}
    return replace(
        found[0][1],
        time=max(error.time for _, error in found),
        impulses={name: impulses[name] for name in event.P_N if name in impulses},
        strikes={name: error.at(name) for own, error in found for name in own.stops},
    )


def _of_part(
    maps: LinearMaps, segments: Sequence[Segment], events: Sequence[Event], state: _State
) -> list[EventError]:
    """Errors of the events of a part, from what is known of it at the start."""
    place = 0
    last: dict[int, _Step] = {}
    found: list[EventError] = []
    for event in events:
        first, flights, forgotten = place, list[Segment](), False
        # A rest lies beyond the end of the motion before it.
        while (
            event.kind is not EventKind.REST
            and place < len(segments)
            and segments[place].t_end <= event.t
        ):
            segment = segments[place]
            place += 1
            if maps.determined(segment):
                state, forgotten = _State(maps.end(segment), _FRESH), True
                flights.clear()
            elif segment.t_end > segment.t_start:
                flights.append(segment)
        step = last.get(event.source)
        if step is None or step.before != state:
            flown = sum(segment.t_end - segment.t_start for segment in segments[first:place])
            arrival = _Arrival(event, segments[place - 1] if place else None, flown, flights)
            step = last[event.source] = _stepped(maps, state, arrival)
        state = step.after
        # What a copy is wrong by is what it is a copy of, and round-off of its time.
        shifted = CLOCK_ROUND_OFF * (event.t - step.t)
        stated = replace(step.stated, time=step.stated.time + shifted)
        if found and forgotten:
            # Nothing that makes the event before late goes on.
            stated = replace(stated, since=stated.time + found[-1].time)
        found.append(stated)
    return found


def _at_start(system: System, segments: Sequence[Segment], first: Event) -> Zonotope:
    """Round-off with which a run begins: before an event that it begins with."""
    if segments and segments[0].t_start < first.t:
        panel = segments[0].panels[0]
        state = State.at(system, panel.t, panel.q[0], panel.v[0], segments[0].closed)
        return at_start(system, state, panel.split)
    return at_start(system, State.at(system, first.t, first.q, first.v_before, first.closed_before))


class _State(NamedTuple):
    """Deviations at the time of an event, or after motion without freedom, and its errors."""

    deviations: Zonotope
    error: EventError


class _Step(NamedTuple):
    """An event at t [s], and what was known before and after it: the same for all copies."""

    t: float
    before: _State
    after: _State
    stated: EventError


class _Arrival(NamedTuple):
    """Motion of a part from one event to the next.

    Attributes:
        last: The segment that ends there, if there is one.
        flown: Time since the event before [s].
        flights: Flights of some length since then, or since a segment without freedom.
    """

    event: Event
    last: Segment | None
    flown: float
    flights: Sequence[Segment]


def _stepped(maps: LinearMaps, before: _State, arrival: _Arrival) -> _Step:
    """From one event to the next."""
    event, (deviations, error) = arrival.event, before
    for place, segment in enumerate(arrival.flights):
        flight = maps.flight(segment)
        if place == 0:
            deviations = deviations.departed(flight.rates)
        deviations = deviations.through(flight.matrix).joined(flight.own).merged()
    arrived = _State(deviations, error)
    if event.kind is EventKind.REST:
        deviations, stated = _rested(maps, arrived, arrival)
        return _Step(event.t, before, _State(deviations, error), stated)
    if event.kind is EventKind.COLLISION:
        deviations, error = _struck(maps, arrived, arrival)
    else:
        error = _released(maps, arrived, arrival)
    return _Step(event.t, before, _State(deviations, error), error)


def _struck(maps: LinearMaps, before: _State, arrival: _Arrival) -> tuple[Zonotope, EventError]:
    """Deviations after a collision and its errors, from the deviations before it."""
    system, part, event, flown = maps.system, maps.part, arrival.event, arrival.flown
    index = system.mechanism.stop(event.stops[0]).index
    place, n = part.place(index), part.size
    rate = float(event.v_before[index])
    if rate == 0.0:
        impulses = {name: before.error.impulse * abs(P) for name, P in event.P_N.items()}
        return before.deviations, replace(before.error, impulses=impulses)
    impact = maps.impact(event)
    whole = maps.panels.events[event.number - 1]
    found = still_apart(system, part, whole, arrival.last, before.deviations)
    # Linear maps know nothing of flights that miss the stop: no collision is off by all its flight.
    most = max(before.error.time + flown, 0.0)
    late = -found.states[place] / rate
    total = float(np.abs(late).sum())
    if total > most:
        late *= most / total
    seen = 0.0
    if flown > 0.0 and arrival.last is not None:
        seen = min(_seen_late(maps, event, arrival.last, index), most)
    found = found.later(late, impact.rates)
    found = found.joined(Zonotope((seen * impact.rates)[:, None], np.array([seen]), np.zeros(1)))
    time = float(np.abs(found.late).sum())
    since = float(np.abs(found.late - found.before).sum()) if flown > 0.0 else 0.0
    found = found.within(place, 0.0)
    relative = found.size(n + place) / abs(rate)
    found = found.within(n + place, abs(rate))
    found, others = beside(system, part, event, impact.rates[n:], found)
    impulses = dict.fromkeys(event.P_N, 0.0)
    if stops := pushing(system, event):
        pushed = _pushed(system, event, impact, found)
        first, size = stops[0].name, abs(event.P_N[stops[0].name])
        relative = max(relative, pushed[first] / size) + impact.lost * (impact.beside[first] / size)
        impulses = _with_round_off(event, impact, pushed)
        found = after_all(system, part, event, others, found.through(impact.matrix))
        found = found.joined(impact.own)
    own = StrikeError(time, min(relative, 1.0), since)
    strikes = stated(own, others, event, impulses)
    time = max([time, *(item.time for item in strikes.values())])
    return found.merged(), EventError(time, own.relative, since, impulses, strikes)


def _pushed(system: System, event: Event, impact: ImpactMap, before: Zonotope) -> dict[str, float]:
    """Errors of the impulses of an event by the deviations before it [N m s or N s], by stop."""
    sizes = np.abs(impact.pushes @ before.states).sum(axis=1).tolist()
    names = [stop.name for stop in pushing(system, event)]
    return dict(zip(names, sizes, strict=True))


def _with_round_off(event: Event, impact: ImpactMap, pushed: dict[str, float]) -> dict[str, float]:
    """The same with the round-off of the impulses; all stops of an event, pushing or not."""
    return {name: pushed.get(name, 0.0) + impact.lost * impact.beside[name] for name in event.P_N}


def _seen_late(maps: LinearMaps, event: Event, segment: Segment, index: int) -> float:
    """By how much a gap is seen to close late [s]: round-off of time, and of a dependent gap."""
    system, split, wrong = maps.system, segment.panels[-1].split, 0.0
    if segment.kinematic:
        return (CLOCK_ROUND_OFF + ROOT_RESOLUTION) * event.t
    if index in split.dependent:
        wrong = float(round_off(system, split, event.q)[index])
        wrong += maps.unresolved(segment, index)
    return CLOCK_ROUND_OFF * event.t + wrong / abs(float(event.v_before[index]))


def _rested(maps: LinearMaps, before: _State, arrival: _Arrival) -> tuple[Zonotope, EventError]:
    """Deviations after a rest and its errors, from the deviations after the last collision."""
    event, deviations, late = arrival.event, before.deviations, before.deviations.late
    left = late - deviations.before if arrival.flown > 0.0 else np.zeros_like(late)
    system, part = maps.system, maps.part
    columns = [system.mechanism.stop(name).index for name in event.stops]
    rates = event.v_before[columns]
    impulses = dict.fromkeys(event.P_N, 0.0)
    if rates.all() and pushing(system, event):
        # What is left of the series lasts in proportion to its rate; of several stops the one that
        # is known least tells.
        beyond = event.t - (arrival.last.t_end if arrival.last is not None else 0.0)
        wrong = deviations.states[[part.size + part.place(index) for index in columns]]
        wrong = wrong / rates[:, None]
        shorter = beyond * wrong[int(np.abs(wrong).sum(axis=1).argmax())]
        late, left = late + shorter, left + shorter
        impact = maps.impact(event)
        impulses = _with_round_off(event, impact, _pushed(system, event, impact, deviations))
        deviations = deviations.through(impact.matrix)
        deviations = deviations.joined(maps.left_out(event, beyond)).merged()
    limit = SERIES_ERROR_SAFETY * event.series_error
    time, since = (float(np.abs(item).sum()) + limit for item in (late, left))
    return deviations, EventError(time, before.error.impulse, since, impulses)


def _released(maps: LinearMaps, before: _State, arrival: _Arrival) -> EventError:
    """Errors of a release, from the deviations there; it changes none of them."""
    event, segment, flown = arrival.event, arrival.last, arrival.flown
    if segment is None or flown <= 0.0:
        return replace(before.error, impulses={})
    index = maps.system.mechanism.stop(event.stops[0]).index
    if index not in maps.system.constraint_set(segment.closed).stops:
        return replace(before.error, impulses={})
    late = _late_release(maps, segment, event.t, before.deviations, index)
    late = min(late, flown) + CLOCK_ROUND_OFF * event.t
    return EventError(late, before.error.impulse, late + before.error.time, {})
