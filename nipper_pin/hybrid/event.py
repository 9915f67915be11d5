"""Events: what interrupts the motion, what it changes, and how a run ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ..arrays import FloatArray
from ..mechanism import Mechanism, Stop


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
        """Stops that a collision strikes: the first one, and all others that close at a rate.

        Args:
            mechanism: The mechanism.
        """
        first, *others = (mechanism.stop(name) for name in self.stops)
        open_before = (stop for stop in others if stop.name not in self.closed_before)
        return first, *(stop for stop in open_before if stop.rate(self.v_before) < 0.0)

    def energy_lost_at(self, stop: Stop) -> float:
        """Kinetic energy that the impulse of one stop takes away [J]; all stops together lose all.

        Args:
            stop: A stop in contact.
        """
        through = stop.rate(self.v_before) + stop.rate(self.v_after)
        return -0.5 * self.P_N[stop.name] * through


def found_after(events: Sequence[Event], rest: Event) -> Event:
    """Return the event after which a rest was found: the last bounce, whose state it has.

    Events of parts that it has nothing to do with may lie between them. Any other event, and a rest
    that none comes before, is its own.
    """
    if rest.kind is not EventKind.REST:
        return rest
    for place in range(rest.number - 2, -1, -1):
        event = events[place]
        if event.kind is not EventKind.REST and np.array_equal(event.q, rest.q):
            return event
    return rest


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
