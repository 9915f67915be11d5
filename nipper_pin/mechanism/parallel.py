"""Stops that close together: one of them, their leader, is followed for all."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from ..made_once import made_once
from .mechanism import Mechanism
from .parts import Stop


def led(mechanism: Mechanism) -> Mechanism:
    """The mechanism with leaders alone: itself, unless some of its stops close together."""
    return _led(mechanism) if any(stop.leader for stop in mechanism.stops) else mechanism


@made_once
def _led(mechanism: Mechanism) -> Mechanism:
    followers = {stop.name: stop.leader for stop in mechanism.stops if stop.leader}
    stop = mechanism.transition_stop
    return replace(
        mechanism,
        stops=tuple(item for item in mechanism.stops if not item.leader),
        phases=tuple(
            replace(item, closed=item.closed.difference(followers)) for item in mechanism.phases
        ),
        transition_stop=followers.get(stop, stop),
    )


def group(stops: Collection[Stop], name: str) -> tuple[Stop, ...]:
    """The stops that close with one, itself among them, in the order of the model."""
    leader = next(stop.leader or stop.name for stop in stops if stop.name == name)
    return tuple(stop for stop in stops if leader in (stop.name, stop.leader))


def together(stops: Collection[Stop], closed: frozenset[str]) -> frozenset[str]:
    """Closed stops with all that close with them."""
    if not any(stop.leader for stop in stops):
        return closed
    return frozenset(item.name for name in closed for item in group(stops, name))


def force_shares(stops: Collection[Stop], name: str) -> dict[str, float]:
    """Shares of the force of a leader, for each stop of its group.

    By least squares of the forces, each counted by the rate that it gives its own gap, all push
    their one freedom alike.
    """
    found = group(stops, name)
    return {stop.name: 1.0 / (len(found) * stop.ratio) for stop in found}


def impulse_shares(stops: Collection[Stop], name: str) -> dict[str, float]:
    """The same of impulses: none for a stop that would be thrown back slower than the leader."""
    found = group(stops, name)
    most = max(stop.restitution for stop in found)
    struck = sum(stop.restitution == most for stop in found)
    return {
        stop.name: 1.0 / (struck * stop.ratio) if stop.restitution == most else 0.0
        for stop in found
    }
