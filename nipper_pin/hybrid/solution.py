"""What a simulation returns: events, motion between them, and how the run ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from ..arrays import FloatArray
from ..dynamics.shaft import ShaftMotion
from ..mechanism import Mechanism
from .case import Case
from .segment import Segment


class EventKind(StrEnum):
    """What happens at an event."""

    COLLISION = "collision"
    REST = "rest"
    RELEASE = "release"


class Outcome(StrEnum):
    """How a run ended; the value is the sentence for the user."""

    COMPLETED = "The window was simulated to its end."
    AT_REST = "The transition ended with the stop at rest."
    STILL_BOUNCING = "The window ended while a stop was still bouncing; it came to no rest."
    NO_REST = (
        "The stop did not come to rest within one turn of the first collision; lower the speed or "
        "the restitution, or raise the preload."
    )
    TOO_MANY_COLLISIONS = (
        "The run was stopped at its largest number of collisions; raise max_collisions, or end the "
        "series by a rate (rest_rate)."
    )


@dataclass(frozen=True)
class Event:
    """One event.

    Attributes:
        number: Number of the event, from 1.
        t: Time [s] from the start of the run.
        kind: Collision, rest (a series of bounces has reached its limit) or release.
        stops: Stops that it concerns; of a collision those that receive an impulse first.
        q: Configuration, shape (nv,) [rad or m].
        v_before: Velocity just before, shape (nv,).
        v_after: Velocity just after, shape (nv,).
        P_N: Impulses of the stops in contact along their coordinates, by name [N m s or N s].
        P_g: Closure impulses, shape (m,) [N s].
        P_drive: Impulses of held drives, shape (drives,) [N m s].
        energy_lost: Kinetic energy lost [J].
        energy_from_drives: Work of the held drives' impulses [J].
        closed_before: Closed stops before.
        closed_after: Closed stops after.
    """

    number: int
    t: float
    kind: EventKind
    stops: tuple[str, ...]
    q: FloatArray
    v_before: FloatArray
    v_after: FloatArray
    P_N: dict[str, float]
    P_g: FloatArray
    P_drive: FloatArray
    energy_lost: float
    energy_from_drives: float
    closed_before: frozenset[str]
    closed_after: frozenset[str]


@dataclass(frozen=True)
class Solution:
    """A simulated stretch of motion.

    Attributes:
        mechanism: The mechanism.
        case: The case.
        shaft: Motion of the cylinder; its start angle belongs to time zero.
        events: Events in order of time.
        segments: Motion between events, in order of time, without gaps.
        outcome: How the run ended.
        evaluations: Evaluations of the constrained dynamics.
        wall_s: Wall time of the run [s].
        repeated_from: Turn after which all further ones are copies, or None.
    """

    mechanism: Mechanism
    case: Case
    shaft: ShaftMotion
    events: tuple[Event, ...]
    segments: tuple[Segment, ...]
    outcome: Outcome
    evaluations: int
    wall_s: float
    repeated_from: int | None
