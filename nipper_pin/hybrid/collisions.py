"""Tables of a run: collisions with their rebounds, phases and the transition."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..dynamics.system import System
from .case import Resolution
from .collocation import evaluate, nodes
from .energy import pieces
from .event import Event, EventKind
from .panel import Panel
from .roots import first_descent, polish
from .segment import Segment, advance


@dataclass(frozen=True)
class Collision:
    """One collision and the rebound after it.

    Attributes:
        number: Number of the collision, from 1.
        stop: Stop that receives the impulse.
        t: Time [s] from the start of the run.
        cylinder_angle: psi [rad].
        index: Index on the comber's scale.
        approach_rate: Rate of the stop's coordinate before, negative [rad/s or m/s].
        separation_rate: Rate after.
        impulse: Normal impulse at the contact point [N s].
        energy_lost: Kinetic energy lost [J].
        rebound_amplitude: Largest gap until the stop's next event [rad or m]; None if the window
            ends before.
        rebound_time: Time until then [s]; None likewise.
        event: The event itself.
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
    rebound_amplitude: float | None
    rebound_time: float | None
    event: Event


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
    system: System,
    segments: Sequence[Segment],
    events: Sequence[Event],
    resolution: Resolution,
) -> tuple[Collision, ...]:
    """Collisions of a run, in order of time."""
    impacts = [event for event in events if event.kind is EventKind.COLLISION]
    rebounds = _Rebounds(system, segments, events, resolution)
    table = []
    for number, event in enumerate(impacts, start=1):
        stop = system.mechanism.stop(event.stops[0])
        amplitude, duration = rebounds.after(event, stop.name, stop.index)
        psi = float(system.shaft.angle(event.t))
        table.append(
            Collision(
                number=number,
                stop=stop.name,
                t=event.t,
                cylinder_angle=psi,
                index=system.mechanism.cylinder.index_from_angle(psi),
                approach_rate=float(event.v_before[stop.index]),
                separation_rate=float(event.v_after[stop.index]),
                impulse=event.P_N[stop.name] / stop.lever,
                energy_lost=event.energy_lost,
                rebound_amplitude=amplitude,
                rebound_time=duration,
                event=event,
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


class _Rebounds:
    """Amplitudes and times of rebounds; those of copied turns, which share arrays, only once."""

    def __init__(
        self,
        system: System,
        segments: Sequence[Segment],
        events: Sequence[Event],
        resolution: Resolution,
    ) -> None:
        self._system, self._resolution = system, resolution
        self._segments, self._events = segments, events
        self._starts = [segment.t_start for segment in segments]
        self._known: dict[tuple[int, str], tuple[float | None, float | None]] = {}

    def after(self, event: Event, name: str, index: int) -> tuple[float | None, float | None]:
        """Amplitude and time of the rebound of a stop after a collision."""
        if event.v_after[index] <= 0.0:
            return 0.0, 0.0
        following = None
        for place in range(event.number, len(self._events)):
            if name in self._events[place].P_N:
                following = self._events[place]
                break
        if following is None:
            return None, None
        key = (id(event.q), name)
        if key not in self._known:
            last = following.kind is EventKind.REST and np.array_equal(following.q, event.q)
            self._known[key] = (
                _last_rebound(self._system, event, name, index, self._resolution)
                if last
                else (self._highest(event.t, following.t, index), following.t - event.t)
            )
        return self._known[key]

    def _highest(self, begin: float, end: float, index: int) -> float:
        highest = 0.0
        for place in range(bisect_left(self._starts, begin), len(self._segments)):
            segment = self._segments[place]
            if segment.t_end > end:
                break
            for panel, t_start, t_end in pieces(segment):
                highest = max(highest, _highest(panel, t_start, t_end, index))
        return highest


def _last_rebound(
    system: System, event: Event, name: str, index: int, resolution: Resolution
) -> tuple[float | None, float | None]:
    """Rebound that a run leaves out because rest is known already."""
    rows = system.constraint_set(event.closed_after - {name})
    motion = system.shaft.driven(np.array([event.t]))
    q, v = event.q, event.v_after
    a = system.accelerations(motion, q[None], v[None], rows)[0]
    _, jacobian = system.body.closures(q[None])
    t_limit = event.t + system.shaft.period
    reached = advance(system, rows, event.t, q, v, a, jacobian[0], t_limit, resolution)
    if not reached.triggers:
        return None, None
    parts = pieces(reached.segment)
    highest = max(_highest(panel, begin, end, index) for panel, begin, end in parts)
    return highest, reached.segment.t_end - event.t


def _highest(panel: Panel, begin: float, end: float, index: int) -> float:
    """Largest value of a coordinate on a part of a panel."""
    grid = nodes(panel.order)
    a, v = panel.a[:, index], panel.v[:, index]

    def rate(t: float) -> tuple[float, float]:
        sigma = np.array([(t - panel.t) / panel.h])
        value = (
            v[0] + panel.h * evaluate(a, sigma, 1)[0]
            if panel.integrated
            else evaluate(v, sigma, 0)[0]
        )
        return float(value), float(evaluate(a, sigma, 0)[0])

    candidates = [begin, end]
    rates = grid.sample_value @ v
    bracket = first_descent(grid.samples, rates, lambda sigma: rate(panel.t + panel.h * sigma)[0])
    if bracket is not None:
        left, right = (panel.t + panel.h * sigma for sigma in bracket)
        peak = polish(rate, left, right)
        if begin < peak < end:
            candidates.append(peak)
    return float(_values(panel, np.array(candidates), index).max())


def _values(panel: Panel, t: FloatArray, index: int) -> FloatArray:
    return panel.interpolate(t)[0][:, index]
