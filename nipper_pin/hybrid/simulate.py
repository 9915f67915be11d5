"""The phase manager: follows the motion from event to event and changes the closed stops."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Set

import numpy as np

from ..arrays import FloatArray
from ..dynamics.impact import arrest, collide, no_impact
from ..dynamics.shaft import ShaftMotion
from ..dynamics.system import System
from ..errors import (
    ConvergenceError,
    ImpactError,
    InputError,
    SimulationError,
    SingularConfigurationError,
)
from ..mechanism import Mechanism, Stop, need_mechanism
from ..mechanism.cylinder import rad_s_from_rpm
from .advance import Segment, advance
from .case import Case, Window
from .contact.bounce_series import BounceSeries
from .contact.complementarity import Closed, after_collision, after_release, pressed, pressed_next
from .contact.nested_series import NestedSeries
from .event import Event, EventKind
from .event_location.guards import SIMULTANEOUS, TriggerKind
from .motion.panel import Panel
from .result.solution import Outcome, Solution
from .run.diagnosis import located
from .run.event_log import EventLog
from .run.jamming import check_jam
from .run.periodicity import repeats
from .run.rest import rest_of_nested, rest_of_series
from .run.start import initial_state
from .state import State


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
        InputError: The mechanism does not close in its touch configuration, or is only its name.
    """
    need_mechanism(mechanism, "simulate")
    if not isinstance(case, Case):
        message = f"simulate takes a case, and this is {case!r}: nip.Case(speed_rpm=650.0)"
        raise InputError(message, case=case)
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
        events=tuple(run.log.events),
        segments=tuple(run.segments),
        outcome=outcome,
        evaluations=run.system.body.evaluations - before,
        wall_s=time.perf_counter() - began,
        repeated_from=repeated,
    )


def go_on(
    system: System, case: Case, start: State, t_limit: float
) -> tuple[State | None, tuple[Event, ...]]:
    """Follow the motion on from a state to a time, whatever the window of the case.

    Args:
        system: The system.
        case: The case; so many collisions are followed.
        start: The state.
        t_limit: Where to stop [s].

    Returns:
        The state there, None after too many collisions; and the events until then.

    Raises:
        SimulationError: The motion cannot be followed; the message says where and why.
    """
    run = _Run(system, case, start)
    while run.step(t_limit):
        if run.collisions >= case.max_collisions:
            return None, tuple(run.log.events)
    return run.state, tuple(run.log.events)


class _Run:
    """Events and segments of one run as they grow."""

    def __init__(self, system: System, case: Case, start: State | None = None) -> None:
        self.system = system
        self.case = case
        self.mechanism = system.mechanism
        self.log = EventLog()
        self.segments: list[Segment] = []
        self.collisions = 0
        self._nested: dict[tuple[str, Closed], NestedSeries] = {}
        self._known: tuple[FloatArray | None, FloatArray] = (None, np.empty(0))
        if start is not None:
            self.state = start
            return
        try:
            # A transition starts in the touch configuration, whose coordinates are zero.
            starts = () if case.window is Window.TRANSITION else system.mechanism.starts
            self.state = initial_state(system, case.start_index, starts)
        except (ConvergenceError, SingularConfigurationError) as error:
            raise self._beginning(located(error, system)) from error

    def _beginning(self, error: SimulationError) -> SimulationError:
        """The error of a start at an index, with what has to be so there."""
        phase = self.mechanism.phase(self.mechanism.initial_phase)
        if self.case.window is Window.TRANSITION:
            return error
        closed = ", ".join(sorted(phase.closed)) or "no stop"
        message = (
            f"{error.message}; turns start in phase {phase.number} ({closed} closed): start_index "
            "has to lie in it, or initial_phase has to be another one"
        )
        if self.mechanism.starts:
            names = ", ".join(item.joint for item in self.mechanism.starts)
            message += f"; [initial] gives the start of {names}"
        return type(error)(message, **error.evidence)

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
        while True:
            last = self.log.events[-1]
            if last.kind is EventKind.REST and name in last.stops:
                return Outcome.AT_REST
            if self.collisions >= self.case.max_collisions:
                return Outcome.TOO_MANY_COLLISIONS
            if not self.step(self.system.shaft.period):
                return Outcome.NO_REST

    def turns(self, progress: Callable[[int, int], None] | None) -> tuple[Outcome, int | None]:
        """Whole turns, until one is known to repeat."""
        period, cycles = self.system.shaft.period, self.case.cycles
        previous: list[Segment] = []
        self._touch()
        for turn in range(1, cycles + 1):
            first_segment, first_event = len(self.segments), len(self.log.events)
            start = self.state
            before = self.collisions
            while self.step(turn * period):
                if self.collisions - before >= self.case.max_collisions:
                    return Outcome.TOO_MANY_COLLISIONS, None
            if progress is not None:
                progress(turn, cycles)
            current = self.segments[first_segment:]
            wound = None
            if self.case.reuse_cycles and turn < cycles:
                wound = repeats(self.system, previous, current, start, self.state)
            if wound is not None:
                self._copy(current, self.log.events[first_event:], cycles - turn, wound)
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
            self.log.record(EventKind.REST, state, state.t, sorted(newly), none, closed)
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
        reached = advance(
            self.system, state, self._acceleration(state), t_limit, self.case.resolution
        )
        self.segments.append(reached.segment)
        state = reached.end
        if not reached.triggers:
            self.state = state
            return False
        hit = {item.stop for item in reached.triggers if item.kind is TriggerKind.GAP}
        released = {item.stop for item in reached.triggers if item.kind is TriggerKind.FORCE}
        if released:
            state = self._release(state, released, reached.segment.panels[-1])
        if hit:
            rates = {name: self.mechanism.stop(name).rate(state.v) for name in hit}
            # Of stops that touch within round-off of one time some may be on their way out.
            self.collide(
                state, {name for name in hit if rates[name] <= max(min(rates.values()), 0)}
            )
        return True

    def collide(self, state: State, hit: set[str]) -> None:
        """Apply the impact law to the stops that have just closed and those closed before."""
        self.collisions += 1
        contacts = [s for s in self.mechanism.stops if s.name in hit or s.name in state.closed]
        restitution = [stop.restitution for stop in contacts]
        impact = collide(self.system, state.q, state.v, state.jacobian, contacts, restitution)
        rates = {stop.name: stop.rate(impact.v_after) for stop in contacts}
        at_rest = after_collision(state.closed, rates)
        closed = self._pressed(state, impact.v_after, at_rest)
        struck = sorted(
            (name for name, impulse in impact.P_N.items() if impulse > 0.0 or name in hit),
            key=lambda name: (impact.P_N[name] == 0.0, name not in hit),
        )
        self.log.record(EventKind.COLLISION, state, state.t, struck, impact, closed)
        check_jam(self.mechanism, self.log.events, SIMULTANEOUS * self.system.shaft.period)
        after = State(state.t, state.q, impact.v_after, state.jacobian, state.motion, closed)
        newly = hit & closed
        if newly:
            # Without rebound, the collision is the end of its own series.
            still = no_impact(self.system, after.v)
            self.log.record(EventKind.REST, after, state.t, sorted(newly), still, closed)
        self.state = after
        if self._rested_together(state, hit, rates):
            return
        bouncing = [s for s in contacts if s.name in hit and rates[s.name] > 0.0]
        if len(bouncing) == 1:
            self._bounced(bouncing[0], state.series)

    def _bounced(self, stop: Stop, series: BounceSeries | None) -> None:
        """Go on with a series of bounces, or end it at its limit or the threshold of the case."""
        state = self.state
        if series is None or series.stop != stop.name:
            series = BounceSeries(stop.name, state.t)
        elif series.times and self._knot_since(series.times[-1]):
            series = series.anew()
        a = self._acceleration(state)
        series = series.bounced(state.t, stop.rate(state.v), -stop.rate(a))
        state = self.state = state._replace(series=series)
        t_rest, error = rest_of_series(self.system, self.case, state, a, stop, series)
        if not math.isfinite(t_rest):
            return
        shut = self.system.constraint_set(state.closed).shut
        impact = arrest(self.system, state.q, state.v, state.jacobian, [stop, *shut])
        closed = self._pressed(state, impact.v_after, state.closed | {stop.name})
        if stop.name not in closed:
            return
        self.log.record(EventKind.REST, state, t_rest, [stop.name], impact, closed, error)
        self.state = state._replace(v=impact.v_after, closed=closed, series=None)

    def _rested_together(self, before: State, hit: set[str], rates: dict[str, float]) -> bool:
        """End a series whose collisions throw stops open that were at rest; False while it lasts.

        Args:
            before: State just before a collision.
            hit: Stops that have just closed.
            rates: Rate of every stop in contact after it, by name.
        """
        if len(hit) != 1 or not any(rates[name] > 0.0 for name in before.closed):
            return False
        state, names = self.state, before.closed | hit
        rows = self.system.constraint_set(names)
        if rows.freedom < 0:
            return False
        (name,) = hit
        key = name, before.closed
        series = self._nested.get(key, NestedSeries())
        if series.times and self._knot_since(series.times[-1]):
            series = NestedSeries()
        series = series.struck(state.t, -self.mechanism.stop(name).rate(before.v))
        self._nested[key] = series
        a, fastest = self._acceleration(state), max(rates.values())
        t_rest, error = rest_of_nested(self.system, self.case, state, a, names, fastest, series)
        if not math.isfinite(t_rest):
            return False
        try:
            impact = arrest(self.system, state.q, state.v, state.jacobian, rows.shut)
        except (ImpactError, SingularConfigurationError):
            # Stops that depend on one another through the closures do not rest together.
            return False
        if self._pressed(state, impact.v_after, names) != names:
            return False
        opened = sorted(names - state.closed)
        self.log.record(EventKind.REST, state, t_rest, opened, impact, names, error)
        self.state = state._replace(v=impact.v_after, closed=names, series=None)
        return True

    def _knot_since(self, t: float) -> bool:
        """True if the law of a drive has changed its polynomial between time t [s] and now."""
        return t + self.system.shaft.smooth_for(t) < self.state.t

    def _acceleration(self, state: State) -> FloatArray:
        """Acceleration of a state, shape (nv,); asked twice for the same state after a bounce."""
        known, a = self._known
        if known is not state.v:
            rows = self.system.constraint_set(state.closed)
            a = self.system.accelerations(state.motion, state.q[None], state.v[None], rows)[0]
            self._known = state.v, a
        return a

    def _release(self, state: State, released: Set[str], panel: Panel) -> State:
        """Open the stops whose force has fallen to zero."""
        if len(released) > 1:
            # Those that pull at the start of a phase may push once another one is open.
            rows = self.system.constraint_set(state.closed)
            released = state.closed - pressed_next(self.system, rows, panel, state.t) or released
        return self._open(state, released)

    def _open(self, state: State, released: Iterable[str]) -> State:
        """Open stops that do not push."""
        closed = after_release(state.closed, released)
        # Stops that are not pressed shut are no series any more.
        self._nested.clear()
        still = no_impact(self.system, state.v)
        self.log.record(EventKind.RELEASE, state, state.t, sorted(released), still, closed)
        self.state = state._replace(closed=closed, series=None)
        return self.state

    def _pressed(self, state: State, v: FloatArray, at_rest: Closed) -> Closed:
        if not at_rest:
            return at_rest
        return pressed(self.system, state.motion, state.q, v, state.jacobian, at_rest)

    def _copy(
        self, segments: list[Segment], events: list[Event], times: int, wound: FloatArray
    ) -> None:
        """Append copies of a turn, in each of which hinges wind on."""
        period, end = self.system.shaft.period, self.state
        for turn in range(1, times + 1):
            delay, moved = turn * period, turn * wound
            self.segments.extend(segment.shifted(delay, moved) for segment in segments)
            for event in events:
                self.log.repeat(event, delay, moved)
        self.state = end._replace(t=end.t + times * period, q=end.q + times * wound)

    def _outcome(self) -> Outcome:
        return Outcome.COMPLETED if self.state.series is None else Outcome.STILL_BOUNCING
