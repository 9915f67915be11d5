"""The phase manager: follows the motion from event to event and changes the closed stops."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..dynamics.impact import Impact, arrest, collide, no_impact
from ..dynamics.shaft import ShaftMotion
from ..dynamics.system import System
from ..errors import (
    ConvergenceError,
    ImpactError,
    InputError,
    SimulationError,
    SingularConfigurationError,
)
from ..mechanism import Mechanism, Stop
from ..mechanism.cylinder import rad_s_from_rpm
from .case import Case, Window
from .cycles import repeats
from .event import Event, EventKind
from .locate import located
from .phases import Closed, after_collision, after_release, pressed
from .segment import Segment, advance
from .series import BounceSeries
from .solution import Outcome, Solution
from .state import State, initial_state
from .triggers import SIMULTANEOUS, TriggerKind

_DROPPED = 100.0
# As many collisions in one instant, the later half of them no slower than the earlier one but for
# this share, are a jam.
_JAM, _NO_SLOWER = 20, 1e-3


def simulate(
    mechanism: Mechanism, case: Case, progress: Callable[[int, int], None] | None = None
) -> Solution:
    """Simulate a mechanism.

    Args:
        mechanism: The mechanism.
        case: What to simulate.
        progress: Called with (turns done, turns in all) after each turn.

    Returns:
        The solution; its ``outcome`` says how the run ended.

    Raises:
        SimulationError: The motion cannot be followed; the message says where and why.
        InputError: The mechanism does not close in its touch configuration.
    """
    began = time.perf_counter()
    transition = case.window is Window.TRANSITION
    cylinder = mechanism.cylinder
    angle = (
        cylinder.angle_at_touch_rad if transition else cylinder.angle_from_index(case.start_index)
    )
    shaft = ShaftMotion(mechanism, rad_s_from_rpm(case.speed_rpm), angle)
    system = System(mechanism, shaft, case.drive)
    before = system.body.evaluations
    run = _Run(system, case)
    if transition:
        outcome, repeated = run.transition(), None
    else:
        outcome, repeated = run.turns(progress)
    return Solution(
        mechanism=mechanism,
        case=case,
        shaft=shaft,
        events=tuple(run.events),
        segments=tuple(run.segments),
        outcome=outcome,
        evaluations=run.system.body.evaluations - before,
        wall_s=time.perf_counter() - began,
        repeated_from=repeated,
    )


class _Run:
    """Events and segments of one run as they grow."""

    def __init__(self, system: System, case: Case) -> None:
        self.system = system
        self.case = case
        self.mechanism = system.mechanism
        self.events: list[Event] = []
        self.segments: list[Segment] = []
        self._collisions = 0
        self._latest: deque[tuple[float, frozenset[str], float]] = deque(maxlen=_JAM)
        self._known: tuple[FloatArray | None, FloatArray] = (None, np.empty(0))
        try:
            self.state = initial_state(system, case.start_index)
        except (ConvergenceError, SingularConfigurationError) as error:
            raise located(error, system) from error

    def transition(self) -> Outcome:
        """From the touch configuration, where the transition stop collides, to its rest."""
        name = self.mechanism.transition_stop
        if not name:
            message = (
                f"{self.mechanism.name} has no stop, so there is no transition: simulate whole "
                "turns (window cycle), or give it a stop"
            )
            raise InputError(message, model=self.mechanism.name)
        stop = self.mechanism.stop(name)
        gap, rate = stop.gap(self.state.q), stop.rate(self.state.v)
        if gap != 0.0:
            message = (
                f"stop {name!r} stands open by {gap:.3g} in the touch configuration, where a "
                "transition starts: simulate whole turns (window cycle), or make transition_stop "
                "one that is closed there"
            )
            raise InputError(message, stop=name, gap=gap)
        if rate >= 0.0:
            message = (
                f"stop {name!r} is not closing in the touch configuration (rate {rate:.3g}); "
                "check cylinder.angle_at_touch_deg and cylinder.direction"
            )
            raise InputError(message, stop=name, rate=rate)
        self.collide(self.state, {name})
        period = self.system.shaft.period
        while True:
            last = self.events[-1]
            if last.kind is EventKind.REST and name in last.stops:
                return Outcome.AT_REST
            if self._collisions >= self.case.max_collisions:
                return Outcome.TOO_MANY_COLLISIONS
            if not self.step(period):
                return Outcome.NO_REST

    def turns(self, progress: Callable[[int, int], None] | None) -> tuple[Outcome, int | None]:
        """Whole turns, until one is known to repeat."""
        period, cycles = self.system.shaft.period, self.case.cycles
        previous: list[Segment] = []
        self._touch()
        for turn in range(1, cycles + 1):
            first_segment, first_event = len(self.segments), len(self.events)
            start = self.state
            before = self._collisions
            while self.step(turn * period):
                if self._collisions - before >= self.case.max_collisions:
                    return Outcome.TOO_MANY_COLLISIONS, None
            if progress is not None:
                progress(turn, cycles)
            current = self.segments[first_segment:]
            if (
                self.case.reuse_cycles
                and turn < cycles
                and repeats(self.system, previous, current, start, self.state)
            ):
                self._copy(current, self.events[first_event:], cycles - turn)
                if progress is not None:
                    progress(cycles, cycles)
                return self._outcome(), turn
            previous = current
        return self._outcome(), None

    def _touch(self) -> None:
        """Collide or close the open stops that touch at the start.

        A gap is watched from the moment it has opened, so one that starts at zero and closes would
        never be seen.
        """
        state = self.state
        rates = {
            stop.name: stop.rate(state.v)
            for stop in self.mechanism.stops
            if stop.name not in state.closed and stop.gap(state.q) == 0.0
        }
        hit = {name for name, rate in rates.items() if rate < 0.0}
        if hit:
            self.collide(state, hit)
            return
        still = frozenset(name for name, rate in rates.items() if rate == 0.0)
        if not still:
            return
        closed = self._pressed(state, state.v, state.closed | still)
        opened = state.closed - closed
        if opened:
            state = self._open(state, opened)
        newly = closed - state.closed
        if newly:
            none = no_impact(self.system, state.v)
            self._record(EventKind.REST, state, state.t, sorted(newly), none, closed)
            self.state = state._replace(closed=closed)

    def step(self, t_limit: float) -> bool:
        """Advance to the next event or to the limit; False at the limit."""
        try:
            return self._step(t_limit)
        except SimulationError as error:
            raise located(error, self.system, self.state) from error

    def _step(self, t_limit: float) -> bool:
        state = self.state
        if state.t >= t_limit:
            # The last event fell on the limit: nothing is left to follow.
            return False
        rows = self.system.constraint_set(state.closed)
        a = self._acceleration(state)
        reached = advance(
            self.system,
            rows,
            state.t,
            state.q,
            state.v,
            a,
            state.jacobian,
            t_limit,
            self.case.resolution,
        )
        self.segments.append(reached.segment)
        q, v, jacobian, motion = reached.end
        state = state._replace(t=reached.segment.t_end, q=q, v=v, jacobian=jacobian, motion=motion)
        if not reached.triggers:
            self.state = state
            return False
        hit = {item.stop for item in reached.triggers if item.kind is TriggerKind.GAP}
        released = {item.stop for item in reached.triggers if item.kind is TriggerKind.FORCE}
        if released:
            state = self._release(state, released)
        if hit:
            rates = {name: self.mechanism.stop(name).rate(state.v) for name in hit}
            # Of stops that touch within round-off of one time some may be on their way out.
            self.collide(
                state, {name for name in hit if rates[name] <= max(min(rates.values()), 0)}
            )
        return True

    def collide(self, state: State, hit: set[str]) -> None:
        """Apply the impact law to the stops that have just closed and those closed before."""
        self._collisions += 1
        contacts = [s for s in self.mechanism.stops if s.name in hit or s.name in state.closed]
        restitution = [stop.restitution for stop in contacts]
        self._check_jam(state, hit)
        impact = collide(self.system, state.q, state.v, state.jacobian, contacts, restitution)
        rates = {stop.name: stop.rate(impact.v_after) for stop in contacts}
        at_rest = after_collision(state.closed, rates)
        closed = self._pressed(state, impact.v_after, at_rest)
        struck = sorted(
            (name for name, impulse in impact.P_N.items() if impulse > 0.0 or name in hit),
            key=lambda name: (impact.P_N[name] == 0.0, name not in hit),
        )
        self._record(EventKind.COLLISION, state, state.t, struck, impact, closed)
        after = state._replace(v=impact.v_after, closed=closed, series=None)
        newly = hit & closed
        if newly:
            # Without rebound, the collision is the end of its own series.
            still = no_impact(self.system, after.v)
            self._record(EventKind.REST, after, state.t, sorted(newly), still, closed)
        self.state = after
        bouncing = [s for s in contacts if s.name in hit and rates[s.name] > 0.0]
        if len(bouncing) == 1:
            self._bounced(bouncing[0], state.series)

    def _check_jam(self, state: State, hit: set[str]) -> None:
        """Refuse to go on where drives press a link against two stops at once.

        It flies from one stop to the other in ever shorter times, whose sum is finite, and is no
        slower in the end: no motion goes on from there.
        """
        fastest = max(abs(self.mechanism.stop(name).rate(state.v)) for name in hit)
        latest = self._latest
        latest.append((state.t, frozenset(hit), fastest))
        instant = SIMULTANEOUS * self.system.shaft.period
        if len(latest) < _JAM or state.t - latest[0][0] > instant:
            return
        rates = [rate for *_, rate in latest]
        stops = sorted(frozenset().union(*(names for _, names, _ in latest)))
        late, early = sum(rates[_JAM // 2 :]), sum(rates[: _JAM // 2])
        if len(stops) > 1 and late > 0.0 and late >= (1.0 - _NO_SLOWER) * early:
            message = (
                f"the stops {', '.join(stops)} are struck {_JAM} times within {instant:.1g} s and "
                "nothing gets slower: they jam what moves between them against its drives; give it "
                "room, or let the drives be inertial"
            )
            raise ImpactError(message, stops=stops, rates_before=rates)

    def _bounced(self, stop: Stop, series: BounceSeries | None) -> None:
        """Go on with a series of bounces, or end it at its limit or the threshold of the case."""
        state = self.state
        rate = stop.rate(state.v)
        if series is None or series.stop != stop.name:
            series = BounceSeries(stop.name, state.t)
        deceleration = -stop.rate(self._acceleration(state))
        series = series.bounced(state.t, rate, deceleration)
        state = self.state = state._replace(series=series)
        if self.case.rest_rate is not None:
            t_rest, error = (state.t if rate < self.case.rest_rate else np.inf), 0.0
        else:
            t_rest, error = self._limit(stop, series)
        if not math.isfinite(t_rest):
            return
        shut = self.system.constraint_set(state.closed).shut
        impact = arrest(self.system, state.q, state.v, state.jacobian, stop, shut)
        closed = self._pressed(state, impact.v_after, state.closed | {stop.name})
        if stop.name not in closed:
            return
        self._record(EventKind.REST, state, t_rest, [stop.name], impact, closed, error)
        self.state = state._replace(v=impact.v_after, closed=closed, series=None)

    def _limit(self, stop: Stop, series: BounceSeries) -> tuple[float, float]:
        """Time at which a series comes to rest, and its error [s]; infinite while not known yet."""
        t, tolerance = self.state.t, self.case.resolution.tolerance
        e_N, rate, deceleration = stop.restitution, series.rates[-1], series.decelerations[-1]
        unknown = np.inf, np.inf
        if deceleration <= 0.0 or e_N >= 1.0:
            return unknown
        remaining, period = 2.0 * rate / (deceleration * (1.0 - e_N)), self.system.shaft.period
        if remaining <= tolerance * period:
            # The deceleration changes in some tenths of a turn.
            return t + remaining, 10.0 * remaining**2 / period
        # What is left of the motion is dropped. It leaves an error of the motion afterwards of
        # order w^3, found to be at most 2e-3 w^3 in relative rates of inertial shafts.
        if rate**3 > _DROPPED * tolerance * series.fastest**3:
            return unknown
        t_rest, error = series.limit(e_N)
        if error > tolerance * (t - series.start + remaining) or self._met(stop, t_rest):
            return unknown
        return t_rest, error

    def _met(self, bouncing: Stop, t_rest: float) -> bool:
        """True if another stop may close while the bounces that are left out go on.

        It would meet a stop that still bounces, not one at rest.
        """
        state, a = self.state, self._acceleration(self.state)
        left = t_rest - state.t
        return any(
            stop.gap(state.q) <= -left * (min(stop.rate(state.v), 0.0) + left * stop.rate(a))
            for stop in self.mechanism.stops
            if stop.name not in state.closed and stop.name != bouncing.name
        )

    def _acceleration(self, state: State) -> FloatArray:
        """Acceleration of a state, shape (nv,); asked twice for the same state after a bounce."""
        known, a = self._known
        if known is not state.v:
            rows = self.system.constraint_set(state.closed)
            a = self.system.accelerations(state.motion, state.q[None], state.v[None], rows)[0]
            self._known = state.v, a
        return a

    def _release(self, state: State, released: set[str]) -> State:
        """Open the stops whose force has fallen to zero."""
        if len(released) > 1:
            # Those that pull at the start of a phase may push once another one is open.
            held = self._pressed(state, state.v, state.closed)
            return self._open(state, (state.closed - held) or released)
        return self._open(state, released)

    def _open(self, state: State, released: Iterable[str]) -> State:
        """Open stops that do not push."""
        closed = after_release(state.closed, released)
        still = no_impact(self.system, state.v)
        self._record(EventKind.RELEASE, state, state.t, sorted(released), still, closed)
        self.state = state._replace(closed=closed, series=None)
        return self.state

    def _record(
        self,
        kind: EventKind,
        state: State,
        t: float,
        stops: Sequence[str],
        impact: Impact,
        closed: Closed,
        series_error: float = 0.0,
    ) -> None:
        if self.events and self.events[-1].t > t:
            self._bring_forward(t)
        self.events.append(
            Event(
                number=len(self.events) + 1,
                t=t,
                kind=kind,
                stops=tuple(stops),
                q=state.q,
                v_before=state.v,
                v_after=impact.v_after,
                delta=impact.delta,
                P_N=impact.P_N,
                P_g=impact.P_g,
                energy_lost=impact.energy_lost,
                closed_before=state.closed,
                closed_after=closed,
                series_error=series_error,
            )
        )

    def _bring_forward(self, t: float) -> None:
        """Let the last rests, limits beyond the state that goes on, come no later than time t."""
        for place in range(len(self.events) - 1, -1, -1):
            rest = self.events[place]
            if rest.t <= t:
                break
            error = rest.series_error + rest.t - t
            self.events[place] = replace(rest, t=t, series_error=error)

    def _pressed(self, state: State, v: FloatArray, at_rest: Closed) -> Closed:
        if not at_rest:
            return at_rest
        return pressed(self.system, state.motion, state.q, v, state.jacobian, at_rest)

    def _copy(self, segments: list[Segment], events: list[Event], times: int) -> None:
        """Append copies of a turn."""
        period = self.system.shaft.period
        for turn in range(1, times + 1):
            delay = turn * period
            self.segments.extend(segment.shifted(delay) for segment in segments)
            for event in events:
                self.events.append(replace(event, t=event.t + delay, number=len(self.events) + 1))
        self.state = self.state._replace(t=self.state.t + times * period)

    def _outcome(self) -> Outcome:
        return Outcome.COMPLETED if self.state.series is None else Outcome.STILL_BOUNCING
