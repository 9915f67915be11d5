"""Collisions of a run with their rebounds, phases and transitions: the rows of its tables.

A rebound tells how far a stop opens after a collision, and for how long.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from ...chebyshev import Series, nodes
from ...dynamics import System
from ...mechanism import Stop
from ..advance import advance
from ..case import Case
from ..event_location.roots import first_descent, polish
from ..history import Event, EventKind, Segment, State, once_a_source
from ..motion.panel import Panel
from ..run.phase_manager import PhaseManager


@dataclass(frozen=True, eq=False)
class Rebounds:
    """Amplitudes and times of rebounds, found when asked for; those of copied turns only once.

    Attributes:
        case: The case, for motion that a run has left out.
        led: The system with leaders alone.
    """

    system: System
    segments: Sequence[Segment]
    events: Sequence[Event]
    case: Case
    led: System

    def time(self, event: Event, name: str) -> float | None:
        """Time of the rebound of a stop that a collision struck [s]; None if unknown."""
        end, left_out = self.until(event, name)
        if end is None:
            return None
        if left_out is None:
            return end.t - event.t
        return left_out[-1].t_end - left_out[0].t_start if left_out else None

    def amplitude(self, event: Event, name: str) -> float | None:
        """Largest gap of that rebound [rad or m]; None if unknown."""
        end, left_out = self.until(event, name)
        if end is None:
            return None
        if left_out is not None:
            stop = self.system.mechanism.stop(name)
            return max((_highest_of(segment, stop) for segment in left_out), default=None)
        highest = 0.0
        first = bisect_left(self.segments, event.t, key=lambda segment: segment.t_start)
        for segment in islice(self.segments, first, None):
            if segment.t_end > end.t:
                break
            highest = max(highest, self._highest(segment, name))
        return highest

    def until(self, event: Event, name: str) -> tuple[Event | None, tuple[Segment, ...] | None]:
        """The end of a rebound, None if unknown, and the flight to it if a run leaves that out.

        It is the next event at which the stop takes part, and the same one if it does not open.
        """
        if self.system.mechanism.stop(name).rate(event.v_after) <= 0.0:
            return event, None
        later = (self.events[place] for place in range(event.number, len(self.events)))
        end = next((item for item in later if name in item.P_N), None)
        if end is None or end.kind is not EventKind.REST or not np.array_equal(end.q, event.q):
            return end, None
        # Rest was known already.
        return end, self._flight(event, name)

    @once_a_source
    def _highest(self, segment: Segment, name: str) -> float:
        return _highest_of(segment, self.system.mechanism.stop(name))

    @once_a_source
    def _flight(self, event: Event, name: str) -> tuple[Segment, ...]:
        """The flight of a rebound that a run leaves out; empty if it does not end."""
        system, leader = self.led, self.system.mechanism.stop(name).leader or name
        leaders = {item.name for item in system.mechanism.stops}
        closed = (event.closed_after & leaders) - {leader}
        start = State.at(system, event.t, event.q, event.v_after, closed)
        phase = system.constraint_set(closed)
        a = system.accelerations(start.motion, start.q[None], start.v[None], phase)[0]
        limit, part = event.t + system.shaft.period, system.coupled([leader])
        reached = advance(system, start, a, limit, self.case.resolution, watched=part)
        struck = [trigger.stop for trigger in reached.triggers]
        if leader in struck or not struck:
            return (reached.segment,) if struck else ()
        # Of stops that bounce in step another one is back first: on to this one past their events.
        manager = PhaseManager(system, self.case, start)
        while manager.step(limit):
            if any(leader in event.P_N for event in manager.events):
                return tuple(manager.segments)
        return ()


def _highest_of(segment: Segment, stop: Stop) -> float:
    """Largest gap of a stop on a segment."""
    return max((_highest(*piece, stop) for piece in segment.pieces()), default=0.0)


def _highest(panel: Panel, begin: float, end: float, stop: Stop) -> float:
    """Largest gap of a stop on a part of a panel: at its ends or where its rate is zero."""
    grid, h = nodes(panel.order), panel.h
    left, right = (begin - panel.t) / h, (end - panel.t) / h
    if panel.integrated:
        a, gap, slope = stop.rates(panel.a), stop.gap(panel.q[0]), h * stop.rate(panel.v[0])
        coefficients = h**2 * (grid.integrals[2] @ a)
        coefficients[:2] += gap + 0.5 * slope, 0.5 * slope
        rates = h**2 * (grid.integrals[1] @ a)
        rates[0] += slope
    else:
        coefficients = grid.integrals[0] @ stop.gaps(panel.q)
        rates = h * (grid.integrals[0] @ stop.rates(panel.v))
    value, rate = Series(coefficients), Series(rates)
    single = rate.falls_once(left, right)
    if single is not None:
        return value.value(polish(rate.value_and_slope, *single))
    found = [value.value(left), value.value(right)]
    sampled = h * (grid.sample_value @ stop.rates(panel.v))
    first = 0
    while bracket := first_descent(grid.samples[first:], sampled[first:], rate.value):
        peak = polish(rate.value_and_slope, *bracket)
        if left < peak < right:
            found.append(value.value(peak))
        # Behind a crest there may be a higher one.
        first = int(np.searchsorted(grid.samples, bracket[1]))
    return max(found)


@dataclass(frozen=True)
class Collision:
    """One stop that is struck, and its rebound.

    Stops that are struck in one event have a collision each, one after another.

    Attributes:
        number: Number of the collision, from 1.
        stop: Stop that is struck.
        t: Time [s] from the start of the run.
        cylinder_angle: psi [rad].
        index: Index on the comber's scale.
        approach_rate: Rate of the stop's gap before, negative [rad/s or m/s].
        separation_rate: Rate after.
        impulse: Normal impulse at the contact point [N s]; along the joint of a stop without one
            [N s or N m s].
        energy_lost: Kinetic energy lost at this stop [J].
        event: The event itself, which may strike other stops, too.
        rebounds: What finds the rebound after it.
    """

    number: int
    stop: str
    t: float
    cylinder_angle: float
    index: float
    approach_rate: float
    separation_rate: float
    impulse: float
    energy_lost: float
    event: Event
    rebounds: Rebounds = field(repr=False, compare=False)

    @property
    def rebound_amplitude(self) -> float | None:
        """Largest gap until the stop's next event [rad or m]; None if the window ends before."""
        return self.rebounds.amplitude(self.event, self.stop)

    @property
    def rebound_time(self) -> float | None:
        """Time until the stop's next event [s]; None if the window ends before."""
        return self.rebounds.time(self.event, self.stop)


@dataclass(frozen=True)
class PhaseInterval:
    """A stretch of one phase.

    Attributes:
        number: Number of the phase; None for a set of closed stops without a number.
        closed: Closed stops.
        t_start: Start [s].
        t_end: End [s].
    """

    number: int | None
    closed: frozenset[str]
    t_start: float
    t_end: float


@dataclass(frozen=True)
class Transition:
    """A series of bounces of the transition stop, from its first collision to rest.

    Attributes:
        t_start: First collision [s].
        duration: Time from there to rest [s].
        collisions: Collisions computed; the series has infinitely many if it ends by its limit.
        first_two_share: Share of the first two rebounds in the duration; None with fewer.
    """

    t_start: float
    duration: float
    collisions: int
    first_two_share: float | None
