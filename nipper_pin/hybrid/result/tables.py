"""Tables of a run: collisions with their rebounds, phases and the transition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ...dynamics import System
from ..event import Event, EventKind
from .rebounds import Rebounds


@dataclass(frozen=True)
class Collision:
    """One stop that is struck, and its rebound.

    Stops that are struck in one event have a collision each, one after another.

    Attributes:
        number: Number of the collision, from 1.
        stop: Stop that is struck.
        t: Time [s] from the start of the run.
        cylinder_angle: psi [rad].
        index: Index on the comber's scale.
        approach_rate: Rate of the stop's gap before, negative [rad/s or m/s].
        separation_rate: Rate after.
        impulse: Normal impulse at the contact point [N s]; along the joint of a stop without one
            [N s or N m s].
        energy_lost: Kinetic energy lost at this stop [J].
        event: The event itself, which may strike other stops, too.
        rebounds: What finds the rebound after it.
    """

    number: int
    stop: str
    t: float
    cylinder_angle: float
    index: float
    approach_rate: float
    separation_rate: float
    impulse: float
    energy_lost: float
    event: Event
    rebounds: Rebounds = field(repr=False, compare=False)

    @property
    def rebound_amplitude(self) -> float | None:
        """Largest gap until the stop's next event [rad or m]; None if the window ends before."""
        return self.rebounds.amplitude(self.event, self.stop)

    @property
    def rebound_time(self) -> float | None:
        """Time until the stop's next event [s]; None if the window ends before."""
        return self.rebounds.time(self.event, self.stop)


@dataclass(frozen=True)
class PhaseInterval:
    """A stretch of one phase.

    Attributes:
        number: Number of the phase; None for a set of closed stops without a number.
        closed: Closed stops.
        t_start: Start [s].
        t_end: End [s].
    """

    number: int | None
    closed: frozenset[str]
    t_start: float
    t_end: float


@dataclass(frozen=True)
class Transition:
    """A series of bounces of the transition stop, from its first collision to rest.

    Attributes:
        t_start: First collision [s].
        duration: Time from there to rest [s].
        collisions: Collisions computed; the series has infinitely many if it ends by its limit.
        first_two_share: Share of the first two rebounds in the duration; None with fewer.
    """

    t_start: float
    duration: float
    collisions: int
    first_two_share: float | None


def collision_table(
    system: System, events: Sequence[Event], rebounds: Rebounds
) -> tuple[Collision, ...]:
    """Collisions of a run, in order of time; of stops that are struck at once in their order."""
    table: list[Collision] = []
    for event in events:
        if event.kind is not EventKind.COLLISION:
            continue
        struck = event.struck(system.mechanism)
        psi = float(system.shaft.angle(event.t))
        for stop in struck:
            lost = event.energy_lost if len(struck) == 1 else event.energy_lost_at(stop)
            table.append(
                Collision(
                    number=len(table) + 1,
                    stop=stop.name,
                    t=event.t,
                    cylinder_angle=psi,
                    index=system.mechanism.cylinder.index_from_angle(psi),
                    approach_rate=stop.rate(event.v_before),
                    separation_rate=stop.rate(event.v_after),
                    impulse=event.P_N[stop.name] / stop.lever,
                    energy_lost=lost,
                    event=event,
                    rebounds=rebounds,
                )
            )
    return tuple(table)


def phase_intervals(
    system: System, events: Sequence[Event], initial: frozenset[str], t_end: float
) -> tuple[PhaseInterval, ...]:
    """Phases of a run; a phase after a series of bounces starts at the time of rest."""
    intervals = []
    start, closed = 0.0, initial
    for event in events:
        if event.closed_after == closed:
            continue
        if event.t > start:
            intervals.append(_interval(system, closed, start, event.t))
        start, closed = event.t, event.closed_after
    if t_end > start:
        intervals.append(_interval(system, closed, start, t_end))
    return tuple(intervals)


def transitions(
    collisions: Sequence[Collision], events: Sequence[Event], stop: str
) -> tuple[Transition, ...]:
    """Completed series of bounces of one stop, in order of time."""
    series: list[Collision] = []
    found = []
    by_event = {item.event.number: item for item in collisions if item.stop == stop}
    for event in events:
        if event.number in by_event:
            series.append(by_event[event.number])
        elif event.kind is EventKind.REST and stop in event.stops and series:
            duration = event.t - series[0].t
            share = None
            if len(series) > 2 and duration > 0.0:
                share = (series[2].t - series[0].t) / duration
            found.append(Transition(series[0].t, duration, len(series), share))
            series = []
        elif event.kind is EventKind.RELEASE and stop in event.stops:
            series = []
    return tuple(found)


def _interval(system: System, closed: frozenset[str], start: float, end: float) -> PhaseInterval:
    phase = system.mechanism.phase_of(closed)
    return PhaseInterval(None if phase is None else phase.number, closed, start, end)
