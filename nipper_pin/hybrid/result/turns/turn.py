"""One turn of a run: when the transition stop clamps, with which force, and what collisions do."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

from ....errors import InputError
from ....mechanism.cylinder import INDEX_PER_TURN
from ...case import Window
from ...event import Event, EventKind
from ...run.outcome import Outcome
from ..rebound_errors import rebound_error
from ..solution import Solution
from ..tables import Collision
from .held import Held, held
from .period import repetition

_ENDED = (Outcome.COMPLETED, Outcome.STILL_BOUNCING)


@dataclass(frozen=True, eq=False, repr=False)
class StopTurn:
    """Collisions of one stop in one turn, those that were computed: a series has infinitely many.

    Attributes:
        solution: The run.
        stop: Name of the stop.
        hits: Collisions in which it receives an impulse.
    """

    solution: Solution
    stop: str
    hits: tuple[Event, ...]

    @property
    def collisions(self) -> int:
        """Their number."""
        return len(self.hits)

    @property
    def impulse_sum(self) -> float:
        """Sum of impulses at the contact point [N s]; without one along the joint, too [N m s]."""
        return math.fsum(self._impulses)

    @property
    def impulse_sum_error(self) -> float:
        """Estimated error of that."""
        errors = (self.solution.errors[event.number - 1].impulse for event in self.hits)
        return math.fsum(
            error * impulse for error, impulse in zip(errors, self._impulses, strict=True)
        )

    @property
    def largest_impulse(self) -> float:
        """Largest of them, zero without any."""
        return max(self._impulses, default=0.0)

    @property
    def _impulses(self) -> list[float]:
        lever = self.solution.mechanism.stop(self.stop).lever
        return [event.P_N[self.stop] / lever for event in self.hits]


@dataclass(frozen=True, eq=False, repr=False)
class Turn:
    """One turn of a run; indices count on from the one at which turns start, to 40 more.

    What a turn does not have is None. Everything is computed when it is first asked for.

    Attributes:
        solution: The run, up to the turn that follows.
        number: Number of the turn, from 1.
        repeats_after: After how many turns it repeats an earlier one, so that turns go on like
            this; 0 if it does not.
        least_force: Force above which the transition stop clamps [N].
    """

    solution: Solution
    number: int
    repeats_after: int
    least_force: float = 0.0

    @property
    def closing_index(self) -> float | None:
        """Index of the first collision of the transition stop."""
        return self._index(next((hit.t for hit in self._hits), None))

    @property
    def rest_index(self) -> float | None:
        """Index of its first rest."""
        return self._index(self._first(EventKind.REST))

    @property
    def loss_index(self) -> float | None:
        """Index at which its force falls to zero and it opens by itself."""
        return self._index(self._first(EventKind.RELEASE))

    @property
    def opening_index(self) -> float | None:
        """Index at which a collision of another stop throws it open."""
        name = self._stop
        opened = (
            event.t
            for event in self._events
            if event.kind is EventKind.COLLISION
            and name in event.closed_before
            and name not in event.closed_after
        )
        return self._index(next(opened, None))

    @property
    def clamped_time(self) -> float:
        """Time with it closed and its force above the least one [s]."""
        return 0.0 if self._held is None else self._held.above

    @property
    def clamped_share(self) -> float:
        """The same by the time of a turn."""
        return self.clamped_time / self._period

    @property
    def least_clamping_force(self) -> float | None:
        """Smallest force while it is closed, in the unit of its contact [N or N m]."""
        return None if self._held is None else self._held.least

    @property
    def largest_clamping_force(self) -> float | None:
        """Largest force while it is closed."""
        return None if self._held is None else self._held.largest

    @property
    def largest_gap(self) -> float | None:
        """Largest gap of its rebounds, those that end at the stop itself [rad or m].

        A rebound that is not followed, since rest is known or it is too slow, has none.
        """
        hit = self._highest
        return None if hit is None else hit.rebound_amplitude

    @property
    def largest_gap_error(self) -> float | None:
        """Estimated error of that."""
        hit = self._highest
        return None if hit is None else rebound_error(self.solution, hit).amplitude

    @property
    def energy_lost(self) -> float:
        """Kinetic energy lost in all collisions that were computed [J]."""
        return math.fsum(event.energy_lost for event in self._collisions)

    def at(self, stop: str) -> StopTurn:
        """Collisions of a stop.

        Args:
            stop: Its name.
        """
        hits = (event for event in self._collisions if event.P_N.get(stop, 0.0) > 0.0)
        return StopTurn(self.solution, stop, tuple(hits))

    @property
    def _stop(self) -> str:
        return self.solution.mechanism.transition_stop

    @property
    def _period(self) -> float:
        return self.solution.shaft.period

    @cached_property
    def _events(self) -> tuple[Event, ...]:
        """Events of the turn; one at its very end is the next turn's."""
        begin, end = (self.number - 1) * self._period, self.number * self._period
        return tuple(event for event in self.solution.events if begin <= event.t < end)

    @property
    def _collisions(self) -> list[Event]:
        return [event for event in self._events if event.kind is EventKind.COLLISION]

    @cached_property
    def _hits(self) -> list[Collision]:
        """Collisions of the transition stop in the turn."""
        numbers = {event.number for event in self._events}
        return [
            hit
            for hit in self.solution.collisions
            if hit.stop == self._stop and hit.event.number in numbers
        ]

    @cached_property
    def _highest(self) -> Collision | None:
        """The collision with the highest rebound that ends at its own stop."""
        own = [(hit.rebound_amplitude, hit) for hit in self._hits if self._ends_there(hit)]
        known = [(height, hit) for height, hit in own if height is not None]
        return max(known, key=lambda item: item[0])[1] if known else None

    def _ends_there(self, hit: Collision) -> bool:
        """Whether a rebound was followed, and no other stop is struck before it ends."""
        end, left_out = hit.rebounds.until(hit.event)
        if end is None or end is hit.event or left_out is not None:
            return False
        between = self.solution.events[hit.event.number : end.number]
        return all(
            event.stops[0] == self._stop for event in between if event.kind is EventKind.COLLISION
        )

    @cached_property
    def _held(self) -> Held | None:
        begin, end = (self.number - 1) * self._period, self.number * self._period
        parts = [
            (max(item.t_start, begin), min(item.t_end, end))
            for item in self.solution.phases
            if self._stop in item.closed and item.t_start < end and item.t_end > begin
        ]
        return held(self.solution, self._stop, parts, self.least_force)

    def _first(self, kind: EventKind) -> float | None:
        """Time of its first event of a kind [s]."""
        found = (item.t for item in self._events if item.kind is kind and self._stop in item.stops)
        return next(found, None)

    def _index(self, t: float | None) -> float | None:
        if t is None:
            return None
        travel = t / self._period - (self.number - 1)
        return self.solution.case.start_index + INDEX_PER_TURN * travel


def reported_turn(solution: Solution, least_force: float = 0.0) -> Turn:
    """The turn that stands for all further ones: the first that repeats another, or the last one.

    Args:
        solution: A run of whole turns.
        least_force: Force above which the transition stop clamps [N].

    Raises:
        InputError: The run is none of whole turns, did not reach their end, or has no such stop.
    """
    if solution.case.window is not Window.CYCLE or solution.outcome not in _ENDED:
        message = f"quantities of a turn need a run of whole turns to their end: {solution.outcome}"
        raise InputError(message, outcome=solution.outcome.name)
    if not solution.mechanism.transition_stop:
        message = f"{solution.mechanism.name} has no stop that could clamp"
        raise InputError(message, model=solution.mechanism.name)
    found = repetition(solution)
    # Errors of events far beyond the turn would cost as much as the turns.
    end = (found.turn + 1) * solution.shaft.period
    short = replace(
        solution,
        segments=tuple(item for item in solution.segments if item.t_start < end),
        events=tuple(item for item in solution.events if item.t <= end),
    )
    return Turn(short, found.turn, found.after, least_force)
