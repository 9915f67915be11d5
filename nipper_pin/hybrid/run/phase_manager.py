"""The phase manager: follows the motion from event to event and changes the closed stops."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence, Set
from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from ...dynamics import Impact, System, no_impact, weakest
from ...dynamics.impact_laws import solve_impact
from ...errors import ConvergenceError, SimulationError, SingularConfigurationError
from ...tolerances.hybrid import TIME_ROUND_OFF
from ..advance import advance
from ..case import Case
from ..contact.active_set import active_set, active_set_next, stilled, touching
from ..history import Closed, Event, EventKind, Segment, State
from ..motion.panel import Panel
from .series.bounces import Change, ImpactOutcome, Series
from .series.rules import NestedBounces, need_no_jam, series_rules


class EventLog:
    """Events of a run, in order of time; ``coupled`` tells the stops that have to do with some."""

    def __init__(self, coupled: Callable[[Sequence[str]], frozenset[str]]) -> None:
        """Begin without any."""
        self.events: list[Event] = []
        self._coupled = coupled

    def record(self, kind: EventKind, state: State, change: Change) -> int:
        """Write an event down: before those rests of parts that it does not touch that come later.

        Args:
            state: State just before it.

        Returns:
            The number of the event.
        """
        t, error, stops, impact, closed = change
        closed_before = state.closed
        later: list[Event] = []
        if self.events and self.events[-1].t > t:
            later = self._later(t, stops)
            waiting = {name for rest in later for name in rest.stops}
            closed_before, closed = closed_before - waiting, closed - waiting
        number = len(self.events) + 1
        self.events.append(
            Event(
                number=number,
                t=t,
                kind=kind,
                stops=tuple(stops),
                q=state.q,
                v_before=state.v,
                **vars(impact),
                closed_before=closed_before,
                closed_after=closed,
                series_error=error,
                source=number,
            )
        )
        for rest in later:
            self._append(rest)
        return number

    def repeat(self, event: Event, delay: float, wound: FloatArray) -> None:
        """Write an event down again, with its impulses; arguments as :meth:`Panel.shifted`."""
        q = event.q + wound if wound.any() else event.q
        number = len(self.events) + 1
        self.events.append(replace(event, t=event.t + delay, q=q, number=number))

    def _later(self, t: float, stops: Sequence[str]) -> list[Event]:
        """Take out the rests after time t that have nothing to do with some stops.

        The others are limits beyond the state that goes on, and come no later than that time.
        """
        part, place = self._coupled(stops), len(self.events)
        while place and self.events[place - 1].t > t:
            place -= 1
        rests, later = self.events[place:], []
        del self.events[place:]
        for rest in rests:
            if part.isdisjoint(rest.stops):
                later.append(rest)
            else:
                error = rest.series_error + rest.t - t
                self._append(replace(rest, t=t, series_error=error))
        return later

    def _append(self, rest: Event) -> None:
        """Append a rest, whose stops close then and no sooner."""
        number = len(self.events) + 1
        before = self.events[-1].closed_after if self.events else rest.closed_before
        after = (before | rest.closed_after) - (rest.closed_before - rest.closed_after)
        self.events.append(
            replace(rest, number=number, source=number, closed_before=before, closed_after=after)
        )


# From this condition of the closures on, a dead centre is worth a word.
_NEAR = 1e3


def located(error: SimulationError, system: System, state: State | None = None) -> SimulationError:
    """The error with the place and the state of the closures there in words and as evidence.

    Args:
        error: The error; its evidence may hold the time ``t`` and the configuration ``q``.
        state: State that the run goes on from; None before there is one.

    Returns:
        An error of the same type. Evidence: what the error had, ``t``, ``index``,
        ``cylinder_angle_rad``, the ``closure`` that stays open and, with a configuration,
        ``condition`` and ``joints``.
    """
    evidence = dict(error.evidence)
    t = float(evidence.get("t", 0.0 if state is None else state.t))
    angle = float(system.shaft.angle(t))
    index = system.mechanism.cylinder.index_from_angle(angle)
    evidence |= {"t": t, "index": index, "cylinder_angle_rad": angle}
    place = f"after t = {t:.6g} s" if state is not None else "at the start"
    message = f"{place} (index {index:.3f}): {error.message}"
    if "row" in evidence:
        mechanism = system.mechanism
        rows = [item.name for item in mechanism.closures for _ in "xz"]
        rows += [item.name for item in mechanism.couplings]
        evidence["closure"] = rows[evidence.pop("row")]
        message += f"; widest open is closure {evidence['closure']!r}"
    q = evidence.get("q", None if state is None else state.q)
    if q is not None and isinstance(error, ConvergenceError | SingularConfigurationError):
        phase = system.constraint_set(state.closed) if state is not None else None
        given = (*system.held_coordinates, *(phase.stops if phase is not None else ()))
        _, jacobian = system.body.closures(np.reshape(q, (-1, system.body.nv))[:1])
        if np.isfinite(jacobian).all():
            condition, coordinates = weakest(jacobian[0] * system.body.units, given)
            names = [joint.name for joint in system.mechanism.joints if joint.index in coordinates]
            evidence |= {"condition": condition, "joints": names}
            if condition > _NEAR:
                message += f"; the closures have condition {condition:.2g}, by {', '.join(names)}"
    return type(error)(message, **evidence)


class PhaseManager:
    """Events and segments of one run as they grow.

    Attributes:
        events: The events so far, in order of time.
        end: End of the window [s]: bounces that outlast it are followed, not summed up.
    """

    def __init__(self, system: System, case: Case, state: State) -> None:
        """Begin without any event."""
        self.system, self.case, self.state = system, case, state
        self.mechanism = system.mechanism
        self.segments: list[Segment] = []
        self.collisions = 0
        self.end = math.inf
        self._log = EventLog(system.coupled)
        self.events, self._nested = self._log.events, NestedBounces(system)
        self._rules = series_rules(system, case, self._nested)
        self._known: tuple[FloatArray | None, FloatArray] = (None, np.empty(0))

    def touch(self) -> None:
        """Collide or close the open stops that touch at the start.

        A gap is watched from the moment it has opened, so one that starts at zero and closes would
        never be seen.
        """
        state, lying = self._lying(self.state)
        hit = self.closing() - lying
        if hit:
            self.collide(hit)
            return
        if lying:
            self.state = state
            self._settle(frozenset(lying))

    def _settle(self, still: Closed) -> None:
        """Close the open stops with neither gap nor rate that are pressed shut."""
        state = self.state
        closed = active_set(self.system, state, state.closed | still, still)
        opened = state.closed - closed
        if opened:
            state = self._open(opened)
        newly = closed - state.closed
        if newly:
            self._close(state, newly, closed)
            self.state = state._replace(closed=closed, series=self._apart(newly))

    def closing(self) -> set[str]:
        """Names of the open stops with a gap of zero that close: they collide together."""
        q, v, closed = self.state.q, self.state.v, self.state.closed
        return {
            stop.name
            for stop in self.mechanism.stops
            if stop.name not in closed and stop.gap(q) == 0.0 and stop.rate(v) < 0.0
        }

    def step(self, t_limit: float) -> bool:
        """Advance to the next event or to the limit [s]; False at the limit.

        Raises:
            SimulationError: The motion cannot be followed; the message says where and why.
        """
        try:
            return self._step(t_limit)
        except SimulationError as error:
            raise located(error, self.system, self.state) from error

    def _step(self, t_limit: float) -> bool:
        state = self.state
        if state.t >= t_limit:
            # The last event fell on the limit: nothing is left to follow.
            return False
        # Where the drives determine the motion it has no use of an acceleration to begin with.
        free = self.system.constraint_set(state.closed).freedom != 0
        a = self._acceleration(state) if free else None
        place, resolution = len(self.segments), self.case.resolution
        reached = advance(self.system, state, a, t_limit, resolution, place)
        self.segments.append(reached.segment)
        state = self.state = reached.end
        if not reached.triggers:
            return False
        hit = {item.stop for item in reached.triggers if item.closes}
        released = {item.stop for item in reached.triggers if not item.closes}
        if released:
            state = self._release(released, reached.segment.panels[-1])
        if hit:
            self._meet(hit, reached.segment.panels[-1].a[-1])
        return True

    def _meet(self, hit: Set[str], a: FloatArray) -> None:
        """Collide with stops whose gaps close at an acceleration; without approach they touch."""
        stops = [self.mechanism.stop(name) for name in hit]
        # A rate that the acceleration turns within round-off of the time is none.
        none = 0.5 * TIME_ROUND_OFF * self.system.shaft.period
        v = self.state.v
        if any(stop.rate(v) < -none * abs(stop.rate(a)) for stop in stops):
            # Of stops that touch within round-off of one time some may be on their way out.
            self.collide({stop.name for stop in stops if stop.rate(v) <= 0.0})
            return
        still = [stop for stop in stops if stop.rate(v) <= none * abs(stop.rate(a))]
        if still:
            v = v.copy()
            v[[stop.index for stop in still]] = 0.0
            self.state = self.state._replace(v=v)
            self._settle(frozenset(stop.name for stop in still))

    def collide(self, hit: set[str]) -> None:
        """Apply the impact law to the stops that have just closed and all that touch."""
        state, lying = self._lying(self.state, hit)
        self.collisions += 1
        met = hit | lying
        meeting = met | (state.closed & self.system.coupled(met))
        contacts = [stop for stop in self.mechanism.stops if stop.name in meeting]
        impact = solve_impact(self.system, state.q, state.v, state.jacobian, contacts)
        rates = {stop.name: stop.rate(impact.v_after) for stop in contacts}
        # Those in contact that do not separate may stay closed, and all that is closed elsewhere.
        still = (name for name, rate in rates.items() if rate == 0.0)
        at_rest = state.closed.difference(rates).union(still)
        after = state._replace(v=impact.v_after, series=self._apart(met))
        closed = active_set(self.system, after, at_rest, met)
        change = Change(state.t, 0.0, _struck(impact, hit), impact, closed)
        number = self._log.record(EventKind.COLLISION, state, change)
        if closed != state.closed:
            after = after._replace(closed=closed)
        newly = met & closed
        if newly:
            # Without rebound, the collision is the end of its own series.
            self._close(after, newly, closed)
        self.state = after
        rebounding = [s for s in contacts if s.name in hit and rates[s.name] > 0.0]
        outcome = ImpactOutcome(
            self.system, self.case, number, state, after, hit, rates, rebounding, self._acceleration
        )
        self._go_on(outcome)

    def _lying(self, state: State, hit: Set[str] = frozenset()) -> tuple[State, Set[str]]:
        """The state without the round-off of stops that touch beside those that close; these."""
        system, q, known = self.system, state.q, hit | state.closed
        # At the end of a motion, and at the start, gaps that are round-off are made zero.
        near = [s for s in self.mechanism.stops if q[s.index] == s.at and s.name not in known]
        if near and hit and not system.whole:
            reached = system.coupled(hit)
            near = [stop for stop in near if stop.name in reached]
        found = touching(system, q, state.v, near, known) if near else near
        if not found:
            return state, frozenset()
        v = stilled(self.system, state.v, state.jacobian, found)
        return state._replace(v=v), {stop.name for stop in found}

    def _go_on(self, struck: ImpactOutcome) -> None:
        """Go on with the series that a collision belongs to, or end it."""
        if len(self.mechanism.stops) > 1:
            need_no_jam(self.system, self.events, struck.number)
        for follow in self._rules:
            series, rests = follow(struck)
            rests = [rest for rest in rests if rest.t <= self.end]
            if series is not self.state.series:
                self.state = self.state._replace(series=series)
            for rest in rests:
                self._rest(rest)
            if rests:
                at_rest = self.system.coupled([name for rest in rests for name in rest.stops])
                left = [stop for stop in struck.rebounding if stop.name not in at_rest]
                if not left:
                    return
                struck = struck._replace(after=self.state, rebounding=left)

    def _rest(self, rest: Change) -> None:
        """End a series at its limit, or at the threshold of the case."""
        state = self.state
        self._log.record(EventKind.REST, state, rest)
        series = self._apart(rest.stops)
        self.state = state._replace(v=rest.impact.v_after, closed=rest.closed, series=series)

    def _apart(self, names: Collection[str]) -> Series:
        """The series of stops that have nothing to do with these."""
        if not self.state.series or self.system.whole:
            return ()
        part = self.system.coupled(names)
        return tuple(item for item in self.state.series if item.stop not in part)

    def _close(self, state: State, newly: Set[str], closed: Closed) -> None:
        """Write down that stops rest without an impact."""
        still = no_impact(self.system, state.v)
        self._log.record(EventKind.REST, state, Change(state.t, 0.0, sorted(newly), still, closed))

    def _release(self, released: Set[str], panel: Panel) -> State:
        """Open the stops whose force has fallen to zero."""
        state = self.state
        if len(released) > 1:
            # Those that pull at the start of a phase may push once another one is open.
            phase = self.system.constraint_set(state.closed)
            stay = active_set_next(self.system, phase, panel, state.t, released)
            released = state.closed - stay or released
        return self._open(released)

    def _open(self, released: Collection[str]) -> State:
        """Open stops that do not push."""
        state = self.state
        closed = state.closed - frozenset(released)
        # Stops that are not pressed shut are no series any more.
        self._nested.forget(released)
        still = no_impact(self.system, state.v)
        change = Change(state.t, 0.0, sorted(released), still, closed)
        self._log.record(EventKind.RELEASE, state, change)
        self.state = state._replace(closed=closed, series=self._apart(released))
        return self.state

    def copy(
        self, segments: list[Segment], events: list[Event], times: int, wound: FloatArray
    ) -> None:
        """Append copies of a turn, each of which adds to q what hinges wind on, shape (nv,)."""
        period, end = self.system.shaft.period, self.state
        for turn in range(1, times + 1):
            delay, moved = turn * period, turn * wound
            self.segments.extend(segment.shifted(delay, moved) for segment in segments)
            for event in events:
                self._log.repeat(event, delay, moved)
        self.state = end._replace(t=end.t + times * period, q=end.q + times * wound)

    def _acceleration(self, state: State) -> FloatArray:
        """Acceleration of a state, shape (nv,); asked twice for the same state after a bounce."""
        known, a = self._known
        if known is not state.v:
            phase = self.system.constraint_set(state.closed)
            a = self.system.accelerations(state.motion, state.q[None], state.v[None], phase)[0]
            self._known = state.v, a
        return a


def _struck(impact: Impact, hit: set[str]) -> list[str]:
    """Stops of a collision: those with an impulse first, of these those that have just closed."""
    return sorted(
        (name for name, impulse in impact.P_N.items() if impulse > 0.0 or name in hit),
        key=lambda name: (impact.P_N[name] == 0.0, name not in hit),
    )


def go_on(
    system: System, case: Case, start: State, t_limit: float
) -> tuple[State | None, tuple[Event, ...]]:
    """Follow the motion on from a state to a time [s], whatever the window of the case.

    Returns:
        The state there, None after too many collisions; and the events until then.

    Raises:
        SimulationError: The motion cannot be followed; the message says where and why.
    """
    manager = PhaseManager(system, case, start)
    while manager.step(t_limit):
        if manager.collisions >= case.max_collisions:
            return None, tuple(manager.events)
    return manager.state, tuple(manager.events)
