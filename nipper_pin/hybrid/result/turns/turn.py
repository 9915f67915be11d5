"""One turn of a run: when the transition stop clamps, with which force, and what collisions do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....arrays import FloatArray
from ....errors import InputError
from ....mechanism import INDEX_PER_TURN, within_turn
from ....tolerances.reduced import SAME_TURN
from ...case import Window
from ...history import Event, EventKind, Outcome
from ...run.windows import winding
from ..rebound_errors import rebound_error
from ..solution import Solution
from ..tables import Collision
from .held import Held, held, largest_torque


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
    """A drive in one turn, from its begin to its end [s]."""

    solution: Solution
    drive: str
    begin: float
    end: float

    @property
    def largest_torque(self) -> float:
        """Largest magnitude of its torque between events [N m]; of one along a slide [N]."""
        return largest_torque(self.solution, self.drive, self.begin, self.end)


# Longest period that is looked for [turns].
_MOST_PERIOD = 64
# Segments that tell how far coordinates move, more than a turn has.
_SHOWN = 200
_ENDED = (Outcome.COMPLETED, Outcome.STILL_BOUNCING)


class _Index:
    """Index of the first event of a kind that tells, or its estimated error; None without one."""

    def __init__(self, kind: EventKind, tells: Callable[[Turn, Event], bool], error: bool) -> None:
        self._kind, self._tells, self._error = kind, tells, error

    def __get__(self, turn: Turn, owner: type[Turn]) -> float | None:
        """Read it off a turn."""
        found = (e for e in turn.events if e.kind is self._kind and self._tells(turn, e))
        event, run, period = next(found, None), turn.solution, turn.solution.shaft.period
        if event is None:
            return None
        if self._error:
            return INDEX_PER_TURN * run.errors[event.number - 1].time / period
        travel = event.t / period - (turn.number - 1)
        return float(within_turn(run.case.start_index + INDEX_PER_TURN * travel))


def _index_of(
    kind: EventKind,
    tells: Callable[[Turn, Event], bool] = lambda turn, event: turn.stop in event.stops,
) -> tuple[_Index, _Index]:
    return _Index(kind, tells, error=False), _Index(kind, tells, error=True)


@dataclass(frozen=True, eq=False, repr=False)
class Turn:
    """One turn of a run; indices are from 0 to below 40.

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

    closing_index, closing_index_error = _index_of(
        EventKind.COLLISION, lambda turn, event: turn.stop in turn.struck(event)
    )
    """Index of the first collision of the transition stop; and the estimated error of that."""
    rest_index, rest_index_error = _index_of(EventKind.REST)
    """Index of its first rest."""
    loss_index, loss_index_error = _index_of(EventKind.RELEASE)
    """Index at which its force falls to zero and it opens by itself."""
    opening_index, opening_index_error = _index_of(
        EventKind.COLLISION,
        lambda turn, event: turn.stop in event.closed_before - event.closed_after,
    )
    """Index at which a collision of another stop throws it open."""

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

        It counts in the turn in which it ends. One that is slower than ``rest_rate`` is none.
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
        """Kinetic energy lost in all collisions [J], those of a series beyond the last too."""
        return math.fsum(event.energy_lost for event in self._losing)

    @property
    def energy_lost_error(self) -> float:
        """Estimated error of that [J]: a loss goes with the square of an impulse."""
        errors = self.solution.errors
        return math.fsum(
            2.0 * errors[event.number - 1].impulse * event.energy_lost for event in self._losing
        )

    def at(self, name: str) -> StopTurn | DriveTurn:
        """What a stop or a drive does in the turn; of two with one name, the stop."""
        if name in {stop.name for stop in self.solution.mechanism.stops}:
            return StopTurn(self.solution, name, self.events)
        return self.drive(name)

    def drive(self, name: str) -> DriveTurn:
        """What a drive does in the turn."""
        return DriveTurn(self.solution, name, *self._span)

    @property
    def stop(self) -> str:
        """Name of the transition stop."""
        return self.solution.mechanism.transition_stop

    @property
    def _period(self) -> float:
        return self.solution.shaft.period

    @property
    def _span(self) -> tuple[float, float]:
        """Begin and end [s]."""
        return (self.number - 1) * self._period, self.number * self._period

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events of the turn; one at its very end is the next turn's."""
        begin, end = self._span
        return tuple(event for event in self.solution.events if begin <= event.t < end)

    @property
    def _losing(self) -> list[Event]:
        """Collisions, and limits of series, which hold what the bounces before them lose."""
        kinds = [EventKind.COLLISION]
        if self.solution.case.rest_rate is None:
            kinds.append(EventKind.REST)
        return [event for event in self.events if event.kind in kinds]

    @cached_property
    def _highest(self) -> Collision | None:
        """The collision with the highest rebound that ends in the turn, at its own stop."""
        own = [
            (hit.rebound_amplitude, hit)
            for hit in self.solution.collisions
            if hit.stop == self.stop and self._ends_there(hit)
        ]
        known = [(height, hit) for height, hit in own if height is not None]
        return max(known, key=lambda item: item[0])[1] if known else None

    def _ends_there(self, hit: Collision) -> bool:
        """Whether a rebound ends in the turn, and no other stop is struck before."""
        begin, over = self._span
        end, left_out = hit.rebounds.until(hit.event, hit.stop)
        if end is None or end is hit.event or not begin <= end.t < over:
            return False
        if left_out is not None and self.solution.case.rest_rate is not None:
            return False
        if end.kind is EventKind.COLLISION and self.stop not in self.struck(end):
            return False
        between = self.solution.events[hit.event.number : end.number - 1]
        return all(event.kind is not EventKind.COLLISION for event in between)

    def struck(self, event: Event) -> list[str]:
        """Names of the stops that an event strikes."""
        return [stop.name for stop in event.struck(self.solution.mechanism)]

    @cached_property
    def _held(self) -> Held | None:
        begin, end = self._span
        parts = [
            (max(item.t_start, begin), min(item.t_end, end))
            for item in self.solution.phases
            if self.stop in item.closed and item.t_start < end and item.t_end > begin
        ]
        return held(self.solution, self.stop, parts, self.least_force)


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
    turn, after = _repetition(solution)
    # Errors of events far beyond the turn would cost as much as the turns.
    end = (turn + 1) * solution.shaft.period
    short = replace(
        solution,
        segments=tuple(item for item in solution.segments if item.t_start < end),
        events=tuple(item for item in solution.events if item.t <= end),
    )
    return Turn(short, turn, after, least_force)


def _repetition(solution: Solution) -> tuple[int, int]:
    """Find the first turn that ends like an earlier one, so that all further ones are known.

    Ends are alike if the same stops are closed and the states differ by no more than the engines
    call the same turn, relative to the largest change of coordinates of their kind. Shafts that
    move on their own have their rates in the state, too.

    Returns:
        Number of that turn, or of the last one; and after how many turns it repeats the earlier
        one, 0 if none was met.
    """
    turns = solution.repeated_from or solution.case.cycles
    period = solution.shaft.period
    ends: FloatArray = np.arange(turns + 1.0) * period
    before = solution.trajectory.evaluate(ends[1:], left=True)
    first = solution.trajectory.evaluate(ends[:1])
    q, v = np.concatenate([first.q, before.q]), np.concatenate([first.v, before.v])
    closed = _closed_before(solution, ends)
    within_q, within_v = _sizes(solution)
    for turn in range(1, turns + 1):
        for back in range(1, min(turn, _MOST_PERIOD) + 1):
            old = turn - back
            if closed[old] != closed[turn]:
                continue
            wound = winding(solution.mechanism, q[old], q[turn], np.inf)
            moved = q[turn] - q[old] - (0.0 if wound is None else wound)
            if (np.abs(moved) <= within_q).all() and (np.abs(v[turn] - v[old]) <= within_v).all():
                return turn, back
    return turns, 0 if solution.repeated_from is None else 1


def _closed_before(solution: Solution, times: FloatArray) -> list[frozenset[str]]:
    """Stops that are closed up to each time; those at the start of the run at its start."""
    starts = np.array([segment.t_start for segment in solution.segments])
    places = np.maximum(np.searchsorted(starts, times, side="left") - 1, 0)
    return [solution.segments[place].closed for place in places]


def _sizes(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """What coordinates and rates of two ends that are alike may differ by, shape (nv,) each."""
    panels = [panel for segment in solution.segments[:_SHOWN] for panel in segment.panels]
    q = np.ptp(np.concatenate([panel.q for panel in panels]), axis=0)
    v = np.abs(np.concatenate([panel.v for panel in panels])).max(axis=0)
    for kind in ("prismatic", "revolute"):
        alike = [joint.index for joint in solution.mechanism.joints if joint.kind == kind]
        if alike:
            q[alike], v[alike] = q[alike].max(), v[alike].max()
    return SAME_TURN * q, SAME_TURN * v
