"""The events of a run as they are written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...arrays import FloatArray
from ...dynamics.impact import Impact
from ..contact.complementarity import Closed
from ..event import Event, EventKind
from ..state import State


class EventLog:
    """Events of a run, in order of time."""

    def __init__(self) -> None:
        """Begin without any."""
        self.events: list[Event] = []

    def record(
        self,
        kind: EventKind,
        state: State,
        t: float,
        stops: Sequence[str],
        impact: Impact,
        closed: Closed,
        series_error: float = 0.0,
    ) -> None:
        """Write an event down.

        Args:
            kind: Its kind.
            state: State just before it.
            t: Its time [s]; that of a limit of bounces lies beyond the state.
            stops: Names of the stops that it concerns.
            impact: What it changes.
            closed: Closed stops after it.
            series_error: Estimated error of such a limit [s].
        """
        if self.events and self.events[-1].t > t:
            self._bring_forward(t)
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
                closed_before=state.closed,
                closed_after=closed,
                series_error=series_error,
                source=number,
            )
        )

    def repeat(self, event: Event, delay: float, wound: FloatArray) -> None:
        """Write an event down again, with its impulses; arguments as :meth:`Panel.shifted`."""
        q = event.q + wound if wound.any() else event.q
        number = len(self.events) + 1
        self.events.append(replace(event, t=event.t + delay, q=q, number=number))

    def _bring_forward(self, t: float) -> None:
        """Let the last rests, limits beyond the state that goes on, come no later than time t."""
        for place in range(len(self.events) - 1, -1, -1):
            rest = self.events[place]
            if rest.t <= t:
                break
            error = rest.series_error + rest.t - t
            self.events[place] = replace(rest, t=t, series_error=error)
