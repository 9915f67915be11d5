"""The events of a run as they are written down."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ...arrays import FloatArray
from ...dynamics import Impact
from ..contact.complementarity import Closed
from ..event import Event, EventKind
from ..state import State


class EventLog:
    """Events of a run, in order of time.

    Args:
        coupled: Returns the stops that have to do with some stops, by their names.
    """

    def __init__(self, coupled: Callable[[Sequence[str]], frozenset[str]]) -> None:
        """Begin without any."""
        self.events: list[Event] = []
        self._coupled = coupled

    def record(
        self,
        kind: EventKind,
        state: State,
        t: float,
        stops: Sequence[str],
        impact: Impact,
        closed: Closed,
        series_error: float = 0.0,
    ) -> int:
        """Write an event down: before those rests of parts that it does not touch that come later.

        Args:
            kind: Its kind.
            state: State just before it.
            t: Its time [s]; that of a limit of bounces lies beyond the state.
            stops: Names of the stops that it concerns.
            impact: What it changes.
            closed: Closed stops after it.
            series_error: Estimated error of such a limit [s].

        Returns:
            The number of the event.
        """
        closed_before, later = state.closed, list[Event]()
        if self.events and self.events[-1].t > t:
            later = self._later(t, stops)
            waiting = {name for rest in later for name in rest.stops}
            closed_before, closed = closed_before - waiting, closed - waiting
        number = len(self.events) + 1
        self.events.append(
            Event(
                number=number,
                t=t,
                kind=kind,
                stops=tuple(stops),
                q=state.q,
                v_before=state.v,
                v_after=impact.v_after,
                delta=impact.delta,
                P_N=impact.P_N,
                P_g=impact.P_g,
                energy_lost=impact.energy_lost,
                closed_before=closed_before,
                closed_after=closed,
                series_error=series_error,
                source=number,
            )
        )
        for rest in later:
            self._append(rest)
        return number

    def repeat(self, event: Event, delay: float, wound: FloatArray) -> None:
        """Write an event down again, with its impulses; arguments as :meth:`Panel.shifted`."""
        q = event.q + wound if wound.any() else event.q
        number = len(self.events) + 1
        self.events.append(replace(event, t=event.t + delay, q=q, number=number))

    def _later(self, t: float, stops: Sequence[str]) -> list[Event]:
        """Take out the rests after time t that have nothing to do with some stops.

        The others are limits beyond the state that goes on, and come no later than that time.
        """
        part, place = self._coupled(stops), len(self.events)
        while place and self.events[place - 1].t > t:
            place -= 1
        rests, later = self.events[place:], []
        del self.events[place:]
        for rest in rests:
            if part.isdisjoint(rest.stops):
                later.append(rest)
            else:
                error = rest.series_error + rest.t - t
                self._append(replace(rest, t=t, series_error=error))
        return later

    def _append(self, rest: Event) -> None:
        """Append a rest, whose stops close then and no sooner."""
        number = len(self.events) + 1
        before = self.events[-1].closed_after if self.events else rest.closed_before
        after = (before | rest.closed_after) - (rest.closed_before - rest.closed_after)
        self.events.append(
            replace(rest, number=number, source=number, closed_before=before, closed_after=after)
        )
