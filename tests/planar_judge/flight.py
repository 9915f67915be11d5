"""One phase, step by step, to its next event; the end of a step is put onto the event."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .dynamics import SINGULAR, Dynamics
from .gauss import Accelerations, Step, integrated, rule, step, values_between
from .machine import Stop
from .record import Stretch, Verdict
from .roots import first_fall
from .verdict import Reason, Refusal

Array = np.ndarray


class Precision(NamedTuple):
    """How finely a run is resolved.

    Attributes:
        stages: Nodes of a step.
        tail: Largest unresolved share of an acceleration.
        longest: Longest step, in turns.
    """

    stages: int = 16
    tail: float = 3e-11
    longest: float = 1.0 / 16.0


class State(NamedTuple):
    """Time, coordinates, rates, closed stops, and gap and rate of every open one."""

    t: float
    q: Array
    v: Array
    closed: frozenset[str]
    gaps: dict[str, tuple[float, float]]


class Trigger(NamedTuple):
    """What ends a step early, its place on it, and its value and slope at the end of a step."""

    kind: str
    stop: str
    place: float
    residual: Callable[[Step], tuple[float, float]]


# Above this a gap is taken from the coordinates again [rad or m].
_FRESH = 1e-6
_SHORTEST = 1e-15
# Unresolved shares below this may be round-off, of stiff drive trains for example.
_NOISE = 1e-8


class Flight:
    """Follows phases of one machine and keeps what it sees."""

    def __init__(self, dynamics: Dynamics, precision: Precision, verdict: Verdict) -> None:
        self.dynamics, self.precision, self.verdict = dynamics, precision, verdict
        self.turn = 2.0 * math.pi / abs(dynamics.rate)
        self.h, self.tail = self.turn * precision.longest, precision.tail
        self.floor = 1e-3 * dynamics.rate**2
        names = list(dynamics.machine.coordinates)
        verdict.coordinates = tuple(names)
        self.rows = slice(dynamics.geometry.constraints, dynamics.geometry.size)

    def shut(self, closed: frozenset[str]) -> list[Stop]:
        """Closed stops in their order."""
        return [stop for stop in self.dynamics.machine.stops if stop.name in closed]

    def fresh_gap(self, stop: Stop, q: Array, v: Array) -> tuple[float, float]:
        """Gap of a stop and its rate, from the coordinates."""
        rows = self.dynamics.evaluate(q[None], v[None])
        row = self.dynamics.stop_rows[stop.name]
        return (
            stop.sense * (float(rows.value[0, row]) - stop.at),
            stop.sense * float(rows.jacobian[0, row] @ v),
        )

    def advance(
        self, state: State, t_end: float, first: float
    ) -> tuple[State, list[str], list[str]]:
        """One step: the state at its end, the stops that are hit there and those that let go.

        Args:
            state: Where it starts.
            t_end: Where the run ends, or a law changes its polynomial [s].
            first: Longest step to try [s].
        """
        shut = self.shut(state.closed)
        h = min(first, self.h, t_end - state.t)
        done = self._resolved(state, shut, h)
        self.h = min(2.0 * done.h if done.h >= h else done.h, self.turn * self.precision.longest)
        triggers = self._triggers(state, shut, done)
        hit: list[str] = []
        released: list[str] = []
        if triggers:
            early = min(triggers, key=lambda item: item.place)
            done = self._onto(state, shut, done, early)
            near = early.place + 1e-13 * self.turn / max(done.h, 1e-300)
            same = [item for item in triggers if item.place <= near]
            hit = [item.stop for item in same if item.kind == "gap"]
            released = [item.stop for item in same if item.kind == "force"]
        if done is None:
            return state, hit, released
        return self._ended(state, shut, done, t_end), hit, released

    def _accelerations(self, shut: Sequence[Stop]) -> Accelerations:
        return lambda t, q, v: self.dynamics.accelerate(t, q, v, shut).a

    def _step(self, f: Accelerations, state: State, h: float, guess: Array) -> Step | None:
        """One step; None if its iteration runs away."""
        unit, stages = self.dynamics.unit, self.precision.stages
        try:
            return step(f, state.t, h, state.q, state.v, guess, unit, stages, self.floor)
        except Refusal:
            return None

    def _resolved(self, state: State, shut: Sequence[Stop], h: float) -> Step:
        """A step that is resolved, of length h or shorter."""
        f = self._accelerations(shut)
        guess = f(np.array([state.t]), state.q[None], state.v[None])[0]
        before, first = math.inf, h
        while True:
            done = self._step(f, state, h, guess)
            # What does not fall with the length of the step is round-off.
            if done is not None and 0.3 * before < done.tail < _NOISE:
                self.tail = max(self.tail, 3.0 * done.tail)
                h, before = first, math.inf
                continue
            if done is not None and done.tail <= self.tail:
                self.verdict.unresolved = max(self.verdict.unresolved, done.tail)
                return done
            share = 0.5
            if done is not None:
                before = done.tail
                share = (self.tail / done.tail) ** (1.0 / self.precision.stages)
                share = min(max(0.9 * share, 0.2), 0.8)
            h *= share
            if h < _SHORTEST * self.turn:
                worth = self.dynamics.independence(state.q[None], shut)
                self.verdict.independence = min(self.verdict.independence, worth)
                reason = Reason.SINGULAR if worth < 1e-3 else Reason.UNRESOLVED
                raise Refusal(reason, f"steps fall to {h:.1g} s, independence {worth:.1g}")

    def _gap_accelerations(self, stop: Stop, done: Step) -> Array:
        rows = self.dynamics.evaluate(done.q, done.v)
        row = self.dynamics.stop_rows[stop.name]
        second = np.einsum("ki,ki->k", rows.jacobian[:, row], done.a) + rows.bias[:, row]
        return stop.sense * second

    def _gap(self, state: State, stop: Stop, done: Step) -> tuple[float, float]:
        """Gap and rate at the end of a step, integrated, so that small ones keep their digits."""
        gap, rate = state.gaps[stop.name]
        once, twice = integrated(self._gap_accelerations(stop, done), np.array([1.0]))
        h = done.h
        return gap + h * rate + h * h * float(twice[0]), rate + h * float(once[0])

    def _stop_force(self, stop: Stop, t: Array, q: Array, v: Array, shut: Sequence[Stop]) -> Array:
        place = len(self.dynamics.base) + shut.index(stop)
        return stop.sense * self.dynamics.accelerate(t, q, v, shut).multipliers[:, place]

    def _triggers(self, state: State, shut: Sequence[Stop], done: Step) -> list[Trigger]:
        """All falls of gaps and forces through zero on a step."""
        found = []
        for stop in self.dynamics.machine.stops:
            if stop.name in state.closed:
                found.append(self._letting_go(stop, shut, done))
            else:
                found.append(self._closing(state, stop, done))
        return [item for item in found if item is not None]

    def _closing(self, state: State, stop: Stop, done: Step) -> Trigger | None:
        gap, rate = state.gaps[stop.name]
        second, h = self._gap_accelerations(stop, done), done.h

        def height(sigma: Array) -> Array:
            twice = h * integrated(second, sigma)[1]
            if gap != 0.0:
                return gap + h * sigma * (rate + sigma * twice)
            return rate + sigma * twice if rate != 0.0 else twice

        def residual(other: Step) -> tuple[float, float]:
            return self._gap(state, stop, other)

        place = first_fall(height, 1e-9 if gap == rate == 0.0 else 0.0)
        return None if place is None else Trigger("gap", stop.name, place, residual)

    def _letting_go(self, stop: Stop, shut: Sequence[Stop], done: Step) -> Trigger | None:
        times = done.t0 + done.h * (0.5 + 0.5 * np.polynomial.legendre.leggauss(len(done.a))[0])
        la = self._stop_force(stop, times, done.q, done.v, shut)

        def residual(other: Step) -> tuple[float, float]:
            t = np.array([other.t0 + other.h])
            force = self._stop_force(stop, t, other.q_end[None], other.v_end[None], shut)
            near = np.array([1.0, 1.0 - 1e-4]) * other.h / done.h
            ahead = values_between(la, near)
            return float(force[0]), float((ahead[0] - ahead[1]) / (1e-4 * other.h))

        place = first_fall(lambda sigma: values_between(la, sigma))
        return None if place is None else Trigger("force", stop.name, place, residual)

    def _onto(
        self, state: State, shut: Sequence[Stop], done: Step, trigger: Trigger
    ) -> Step | None:
        """The step again, shortened so that it ends on the event; None if it has no length."""
        h, best = trigger.place * done.h, None
        f = self._accelerations(shut)
        for _ in range(4):
            if not h > 0.0:
                return best
            guess = values_between(done.a, rule(len(done.a)).nodes * h / done.h)
            best = self._step(f, state, h, guess)
            if best is None:
                raise Refusal(Reason.UNRESOLVED, "a step onto an event does not settle")
            value, slope = trigger.residual(best)
            correction = value / slope if slope < 0.0 else 0.0
            # Far off it is no root any more but a grazing; near it is round-off.
            if abs(correction) > 0.1 * h or abs(correction) <= 4e-16 * h:
                break
            h -= correction
        return best

    def _ended(self, state: State, shut: Sequence[Stop], done: Step, t_end: float) -> State:
        """The state at the end of a step, on all constraints; keeps the step."""
        machine, dynamics = self.dynamics.machine, self.dynamics
        t = state.t + done.h
        if abs(t - t_end) < 1e-15 * self.turn:
            t = t_end
        gaps = {name: self._gap(state, stop, done) for stop in machine.stops
                for name in [stop.name] if name not in state.closed}  # fmt: skip
        q, v = dynamics.project(t, done.q_end, done.v_end, shut)
        for stop in machine.stops:
            if stop.name in gaps and abs(gaps[stop.name][0]) > _FRESH:
                gaps[stop.name] = self.fresh_gap(stop, q, v)
        worth = dynamics.independence(done.q, shut)
        self.verdict.independence = min(self.verdict.independence, worth)
        if worth < SINGULAR:
            raise Refusal(Reason.SINGULAR, f"the machine comes to a dead centre at {t:.6g} s")
        self._keep(shut, done)
        return State(t, q, v, state.closed, gaps)

    def _keep(self, shut: Sequence[Stop], done: Step) -> None:
        """Store a step with the forces at its nodes."""
        dynamics, machine = self.dynamics, self.dynamics.machine
        nodes = 0.5 + 0.5 * np.polynomial.legendre.leggauss(len(done.a))[0]
        times = done.t0 + done.h * nodes
        found = dynamics.accelerate(times, done.q, done.v, shut)
        rates = np.einsum("kij,kj->ki", found.rows.jacobian[:, self.rows], done.v)
        first = dynamics.geometry.constraints
        drives = {d.name: found.multipliers[:, first + i] for i, d in enumerate(machine.drives)}
        for i, drive in enumerate(machine.drives if dynamics.shafts else ()):
            # The train drives its shaft, too.
            own = drive.inertia * found.a[:, dynamics.bodies + i]
            drives[drive.name] = drives[drive.name] + own
        stops = {
            stop.name: stop.sense * found.multipliers[:, len(dynamics.base) + i]
            for i, stop in enumerate(shut)
        }
        coordinates = found.rows.value[:, self.rows]
        for spring in machine.springs:
            if spring.table is not None:
                x = coordinates[:, spring.coordinate]
                if x.min() < spring.table.x[0] or x.max() > spring.table.x[-1]:
                    raise Refusal(Reason.TABLE, "a spring leaves its table")
        self.verdict.stretches.append(Stretch(done, coordinates, rates, stops, drives))
