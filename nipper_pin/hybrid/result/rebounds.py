"""Rebounds: how far a stop opens after a collision, and for how long."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np

from ...dynamics.system import System
from ...mechanism import Stop
from ..advance import advance
from ..case import Resolution
from ..event import Event, EventKind
from ..event_location.roots import first_descent, polish
from ..motion.chebyshev import Series, nodes
from ..motion.panel import Panel
from ..segment import Segment
from ..state import State


class Rebounds:
    """Amplitudes and times of rebounds, found when asked for; those of copied turns only once.

    Args:
        system: The system.
        segments: Segments in order of time.
        events: Events in order of time.
        resolution: How finely a motion is resolved that a run has left out.
    """

    def __init__(
        self,
        system: System,
        segments: Sequence[Segment],
        events: Sequence[Event],
        resolution: Resolution,
    ) -> None:
        """Store what a rebound is looked up in."""
        self._system, self._resolution = system, resolution
        self._segments, self._events = segments, events
        self._starts = [segment.t_start for segment in segments]
        self._highest_gaps: dict[int, float] = {}
        self._flights: dict[int, Segment | None] = {}

    def time(self, event: Event) -> float | None:
        """Time of the rebound of the stop that a collision struck first [s]; None if unknown."""
        stop, end = self._end(event)
        if end is None:
            return None
        if not self._left_out(event, end):
            return end.t - event.t
        segment = self._followed(event, stop)
        # Copies of a turn share the flight of the turn that they are copies of.
        return None if segment is None else segment.t_end - segment.t_start

    def amplitude(self, event: Event) -> float | None:
        """Largest gap of that rebound [rad or m]; None if unknown."""
        stop, end = self._end(event)
        if end is None:
            return None
        if self._left_out(event, end):
            segment = self._followed(event, stop)
            return None if segment is None else _highest_of(segment, stop)
        if event.source not in self._highest_gaps:
            self._highest_gaps[event.source] = self._highest(event.t, end.t, stop)
        return self._highest_gaps[event.source]

    def until(self, event: Event) -> tuple[Event | None, Segment | None]:
        """The end of a rebound, None if unknown, and the flight to it if a run leaves that out."""
        stop, end = self._end(event)
        if end is None or not self._left_out(event, end):
            return end, None
        return end, self._followed(event, stop)

    def _end(self, event: Event) -> tuple[Stop, Event | None]:
        """The stop, and the next event at which it takes part; the same event if it does not open.

        None if the window ends before.
        """
        stop = self._system.mechanism.stop(event.stops[0])
        if stop.rate(event.v_after) <= 0.0:
            return stop, event
        later = (self._events[place] for place in range(event.number, len(self._events)))
        return stop, next((item for item in later if stop.name in item.P_N), None)

    @staticmethod
    def _left_out(event: Event, following: Event) -> bool:
        """True if the run did not follow the rebound, because rest was known already."""
        return following.kind is EventKind.REST and np.array_equal(following.q, event.q)

    def _highest(self, begin: float, end: float, stop: Stop) -> float:
        """Largest gap of a stop between two times."""
        highest = 0.0
        for place in range(bisect_left(self._starts, begin), len(self._segments)):
            segment = self._segments[place]
            if segment.t_end > end:
                break
            highest = max(highest, _highest_of(segment, stop))
        return highest

    def _followed(self, event: Event, stop: Stop) -> Segment | None:
        """The flight of a rebound that a run leaves out; None if it does not end."""
        if event.source not in self._flights:
            self._flights[event.source] = self._flight(event, stop)
        return self._flights[event.source]

    def _flight(self, event: Event, stop: Stop) -> Segment | None:
        system = self._system
        closed = event.closed_after - {stop.name}
        motion = system.shaft.driven_at(event.t)
        q, v = event.q, event.v_after
        phase = system.constraint_set(closed)
        a = system.accelerations(motion, q[None], v[None], phase)[0]
        _, jacobian = system.body.closures(q[None])
        start = State(event.t, q, v, jacobian[0], motion, closed)
        end, part = event.t + system.shaft.period, system.coupled([stop.name])
        reached = advance(system, start, a, end, self._resolution, watched=part)
        return reached.segment if reached.triggers else None


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
    bracket = first_descent(grid.samples, sampled, rate.value)
    if bracket is not None:
        peak = polish(rate.value_and_slope, *bracket)
        if left < peak < right:
            found.append(value.value(peak))
    return max(found)
