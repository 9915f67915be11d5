"""What a run is: events, which interrupt the motion and change it, and segments between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import wraps
from typing import Any, NamedTuple, TypeVar, TypeVarTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics import Driven, System
from ..mechanism import Mechanism, Stop
from .contact.bounce_series import BounceSeries
from .motion.panel import Panel

Closed = frozenset[str]
"""Names of closed stops."""


class EventKind(StrEnum):
    """What happens at an event."""

    COLLISION = "collision"
    REST = "rest"
    RELEASE = "release"


@dataclass(frozen=True, eq=False)
class Event:
    """One event.

    Attributes:
        number: Number of the event, from 1.
        t: Time [s] from the start of the run.
        kind: Collision, rest (a series of bounces has reached its limit) or release.
        stops: Stops that it concerns; of a collision those that receive an impulse first, and among
            these the ones that have closed before those that were closed.
        q: Configuration, shape (nv,) [rad or m]. Of a rest at the limit of a series, this and the
            velocities are those of the last collision computed, a little before ``t``;
            ``Solution.motion_at`` gives the state at ``t``.
        v_before: Velocity just before, shape (nv,).
        v_after: Velocity just after, shape (nv,).
        delta: Change of velocity to its own relative precision, shape (nv,).
        P_N: Impulses of the stops in contact along their gaps, by name [N m s or N s].
        P_g: Closure impulses, shape (m,) [N s].
        energy_lost: Kinetic energy lost [J].
        closed_before: Closed stops before.
        closed_after: Closed stops after.
        series_error: Estimated error of the limit of a series of bounces that gives a rest its
            time [s]; zero for other events.
        source: Number of the event that this one is a copy of; its own if it is none.
    """

    number: int
    t: float
    kind: EventKind
    stops: tuple[str, ...]
    q: FloatArray
    v_before: FloatArray
    v_after: FloatArray
    delta: FloatArray
    P_N: dict[str, float]
    P_g: FloatArray
    energy_lost: float
    closed_before: frozenset[str]
    closed_after: frozenset[str]
    series_error: float
    source: int

    def struck(self, mechanism: Mechanism) -> tuple[Stop, ...]:
        """Stops that a collision strikes: the first one, and all others that close at a rate."""
        first, *others = (mechanism.stop(name) for name in self.stops)
        open_before = (stop for stop in others if stop.name not in self.closed_before)
        return first, *(stop for stop in open_before if stop.rate(self.v_before) < 0.0)


def found_after(events: Sequence[Event], rest: Event) -> Event:
    """Return the event after which a rest was found: the last bounce, whose state it has.

    Events of parts that it has nothing to do with may lie between them. Any other event, and a rest
    that none comes before, is its own.
    """
    if rest.kind is not EventKind.REST:
        return rest
    before = (events[place] for place in range(rest.number - 2, -1, -1))
    others = (event for event in before if event.kind is not EventKind.REST)
    return next((event for event in others if np.array_equal(event.q, rest.q)), rest)


class Outcome(StrEnum):
    """How a run ended; the value is the sentence for the user."""

    COMPLETED = "The window was simulated to its end."
    AT_REST = "The transition ended with the stop at rest."
    STILL_BOUNCING = "The window ended while a stop was still bouncing; it came to no rest."
    NO_REST = (
        "The stop did not come to rest within one turn of the first collision: its bounces outlast "
        "the time in which it is pressed shut; lower the speed or the restitution."
    )
    TOO_MANY_COLLISIONS = (
        "The run was stopped at its largest number of collisions: the bounces are long, or stops "
        "keep throwing one another open; raise max_collisions, or let bounces slower than a rate "
        "end (rest_rate)."
    )


class State(NamedTuple):
    """State of a run between two segments.

    Attributes:
        t: Time [s].
        q: Configuration, shape (nv,).
        v: Velocity (right limit), shape (nv,).
        jacobian: Closure Jacobian, shape (m, nv).
        motion: Driven coordinates at this time, as one row.
        closed: Closed stops.
        series: Bounces that have not come to rest yet, of each stop that bounces.
    """

    t: float
    q: FloatArray
    v: FloatArray
    jacobian: FloatArray
    motion: Driven
    closed: Closed
    series: tuple[BounceSeries, ...] = ()

    @classmethod
    def at(cls, system: System, t: float, q: FloatArray, v: FloatArray, closed: Closed) -> State:
        """Return the state of closed coordinates, where nothing bounces."""
        jacobian = system.body.closures(q[None])[1][0]
        return cls(t, q, v, jacobian, system.shaft.driven_at(t), closed)


@dataclass(frozen=True, eq=False)
class Segment:
    """Motion with one set of closed stops.

    Attributes:
        t_start: Start [s].
        t_end: End [s].
        panels: Panels in order of time; the last one may reach beyond the end.
        kinematic: True if the drives determine the motion.
        source: Place in the run of the segment that this one is a copy of; its own if it is none.
    """

    t_start: float
    t_end: float
    closed: frozenset[str]
    panels: tuple[Panel, ...]
    kinematic: bool
    source: int = 0

    def shifted(self, delay: float, wound: FloatArray) -> Segment:
        """Return the same motion at a later time; arguments as :meth:`Panel.shifted`."""
        return replace(
            self,
            t_start=self.t_start + delay,
            t_end=self.t_end + delay,
            panels=tuple(panel.shifted(delay, wound) for panel in self.panels),
        )

    def pieces(self) -> Iterator[tuple[Panel, float, float]]:
        """Panels with the part of each that belongs to the segment: begin and end [s]."""
        for panel in self.panels:
            begin, end = max(panel.t, self.t_start), min(panel.t + panel.h, self.t_end)
            if end > begin:
                yield panel, begin, end


_Item = TypeVar("_Item", Event, Segment)
_Found = TypeVar("_Found")
_Rest = TypeVarTuple("_Rest")


def once_a_source(
    find: Callable[[Any, _Item, *_Rest], _Found],
) -> Callable[[Any, _Item, *_Rest], _Found]:
    """Keep what a method finds of an event or a segment, for all copies of it."""
    name = f"{find.__name__} of sources"

    @wraps(find)
    def found(owner: Any, item: _Item, *rest: *_Rest) -> _Found:
        known: dict[tuple[object, ...], _Found] = vars(owner).setdefault(name, {})
        key = item.source, *rest
        if key not in known:
            known[key] = find(owner, item, *rest)
        return known[key]

    return found
