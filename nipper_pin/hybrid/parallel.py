"""Events and motion of a machine whose stops close together, and those of their leaders alone.

A run follows leaders: what it finds is written down for all stops, and its errors are found from
the leaders' events again.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ..mechanism import Mechanism, Stop
from ..mechanism.parallel import group, impulse_shares, led, together
from .error_estimate.event_errors import EventError
from .history import Event, Segment


def for_all(
    mechanism: Mechanism, events: Iterable[Event], segments: Iterable[Segment]
) -> tuple[tuple[Event, ...], tuple[Segment, ...]]:
    """Events and segments of leaders as those of all stops."""
    stops = mechanism.stops
    if led(mechanism) is mechanism:
        return tuple(events), tuple(segments)
    return (
        tuple(_for_all(stops, event) for event in events),
        tuple(replace(item, closed=together(stops, item.closed)) for item in segments),
    )


def _for_all(stops: tuple[Stop, ...], event: Event) -> Event:
    """An event of leaders, in which each shares its impulse with those that close with it."""
    impulses = {
        name: share * impulse
        for leader, impulse in event.P_N.items()
        for name, share in impulse_shares(stops, leader).items()
    }
    names = [item.name for name in event.stops for item in group(stops, name)]
    return replace(
        event,
        stops=tuple(sorted(names, key=lambda name: impulses.get(name, 0.0) == 0.0)),
        P_N=impulses,
        closed_before=together(stops, event.closed_before),
        closed_after=together(stops, event.closed_after),
    )


def of_leaders(mechanism: Mechanism, events: tuple[Event, ...]) -> tuple[Event, ...]:
    """Events of all stops as those of leaders, which have the whole impulse."""
    if led(mechanism) is mechanism:
        return events
    leaders = frozenset(stop.name for stop in led(mechanism).stops)
    return tuple(
        replace(
            event,
            stops=tuple(name for name in event.stops if name in leaders),
            P_N={
                name: impulse / impulse_shares(mechanism.stops, name)[name]
                for name, impulse in event.P_N.items()
                if name in leaders
            },
            closed_before=event.closed_before & leaders,
            closed_after=event.closed_after & leaders,
        )
        for event in events
    )


def errors_for_all(mechanism: Mechanism, errors: Iterable[EventError]) -> tuple[EventError, ...]:
    """Errors of events of leaders as those of all stops: shares have their part of an impulse's."""
    stops = mechanism.stops
    if led(mechanism) is mechanism:
        return tuple(errors)
    return tuple(
        replace(
            error,
            impulses={
                name: share * wrong
                for leader, wrong in error.impulses.items()
                for name, share in impulse_shares(stops, leader).items()
            },
            strikes={
                item.name: strike
                for leader, strike in error.strikes.items()
                for item in group(stops, leader)
            },
        )
        for error in errors
    )
