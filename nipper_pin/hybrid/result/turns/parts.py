"""What one stop and one drive do in a turn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ...event import Event, EventKind
from ..solution import Solution
from .held import largest_torque


@dataclass(frozen=True, eq=False, repr=False)
class StopTurn:
    """Collisions of one stop in one turn."""

    solution: Solution
    stop: str
    events: tuple[Event, ...]

    @property
    def collisions(self) -> int:
        """Number of those that were computed; a series with a limit has infinitely many."""
        return len(self._hits)

    @property
    def impulse_sum(self) -> float:
        """Sum of impulses, those of a series beyond the last too [N s or N m s]."""
        further = (impulse for impulse, _ in self._further())
        return math.fsum([*map(self._impulse, self._hits), *further])

    @property
    def impulse_sum_error(self) -> float:
        """Estimated error of that."""
        return math.fsum([*map(self._error, self._hits), *(error for _, error in self._further())])

    @property
    def largest_impulse(self) -> float:
        """Largest of them, zero without any."""
        return max(map(self._impulse, self._hits), default=0.0)

    @property
    def largest_impulse_error(self) -> float:
        """Estimated error of that."""
        event = max(self._hits, key=self._impulse, default=None)
        return 0.0 if event is None else self._error(event)

    @property
    def _hits(self) -> list[Event]:
        """Collisions in which the stop receives an impulse."""
        return [
            event
            for event in self.events
            if event.kind is EventKind.COLLISION and event.P_N.get(self.stop, 0.0) > 0.0
        ]

    def _impulse(self, event: Event) -> float:
        return event.P_N[self.stop] / self.solution.mechanism.stop(self.stop).lever

    def _error(self, event: Event) -> float:
        """Estimated error of an impulse, of this stop and not of the first one that is struck."""
        error = self.solution.errors[event.number - 1].impulses[self.stop]
        return error / self.solution.mechanism.stop(self.stop).lever

    def _further(self) -> Iterator[tuple[float, float]]:
        """Impulses beyond the last bounce of each series that ends at its limit, and their errors.

        They are a geometric series, as far as the time to the limit shows that it is one.
        """
        if self.solution.case.rest_rate is not None:
            return
        e_N = self.solution.mechanism.stop(self.stop).restitution
        for rest in self.events:
            if rest.kind is not EventKind.REST or self.stop not in rest.stops:
                continue
            before = self.solution.events[: rest.number - 1]
            last = next((item for item in reversed(before) if self.stop in item.stops), None)
            if last is None or last.kind is not EventKind.COLLISION or not rest.t > last.t:
                continue
            left = e_N / (1.0 - e_N)
            uneven = self._impulse(last) * rest.series_error / (rest.t - last.t)
            yield left * self._impulse(last), left * (self._error(last) + uneven)


@dataclass(frozen=True, eq=False, repr=False)
class DriveTurn:
    """A drive in one turn.

    Attributes:
        begin: Begin of the turn [s].
        end: Its end [s].
    """

    solution: Solution
    drive: str
    begin: float
    end: float

    @property
    def largest_torque(self) -> float:
        """Largest magnitude of its torque between events [N m]; of one along a slide [N]."""
        return largest_torque(self.solution, self.drive, self.begin, self.end)
