"""One phase, step by step, to its next event; the end of a step is put onto the event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .dynamics import SINGULAR, Dynamics
from .gauss import Accelerations, Step, rule, step, values_between
from .machine import Stop
from .record import Sample, Stretch, Verdict
from .triggers import State, Trigger, coordinate, falls, gap_after
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
        # Drive trains are stiff springs.
        self.shafts = np.arange(dynamics.bodies, dynamics.bodies + dynamics.shafts)
        names = list(dynamics.machine.coordinates)
        verdict.coordinates = tuple(names)
        verdict.sampler = self.sample

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

        It is no longer than ``first``, and ends where the run does or a law changes its polynomial.
        """
        shut = self.shut(state.closed)
        h = min(first, self.h, t_end - state.t)
        done = self._resolved(state, shut, h)
        self.h = min(2.0 * done.h if done.h >= h else done.h, self.turn * self.precision.longest)
        triggers = falls(self.dynamics, state, shut, done)
        hit: list[str] = []
        released: list[str] = []
        if triggers:
            early = min(triggers, key=lambda item: item.place)
            near = early.place + 1e-13 * self.turn / done.h
            done = self._onto(state, shut, done, early)
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
            return step(
                f, state.t, h, state.q, state.v, guess, unit, stages, self.floor, self.shafts
            )
        except Refusal:
            return None

    def _resolved(self, state: State, shut: Sequence[Stop], h: float) -> Step:
        """A step that is resolved, of length h or shorter."""
        f = self._accelerations(shut)
        guess = f(np.array([state.t]), state.q[None], state.v[None])[0]
        before, first = math.inf, h
        while True:
            done = self._step(f, state, h, guess)
            if done is not None and done.tail <= self.tail:
                self.verdict.unresolved = max(self.verdict.unresolved, done.tail)
                return done
            # What does not fall with the length of the step is round-off.
            if done is not None and 0.3 * before < done.tail < _NOISE:
                self.tail = 3.0 * done.tail
                h, before = first, math.inf
                continue
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
        gaps = {name: gap_after(self.dynamics, state, stop, done) for stop in machine.stops
                for name in [stop.name] if name not in state.closed}  # fmt: skip
        q, v = dynamics.project(t, done.q_end, done.v_end, shut)
        for stop in machine.stops:
            if stop.name in gaps and abs(gaps[stop.name][0]) > _FRESH:
                gaps[stop.name] = self.fresh_gap(stop, q, v)
        worth = dynamics.independence(done.q, shut)
        self.verdict.independence = min(self.verdict.independence, worth)
        if worth < SINGULAR:
            raise Refusal(Reason.SINGULAR, f"the machine comes to a dead centre at {t:.6g} s")
        self._check_tables(done)
        self.verdict.stretches.append(Stretch(done, state.q, state.v, state.closed))
        return State(t, q, v, state.closed, gaps)

    def _check_tables(self, done: Step) -> None:
        """A motion may not leave the table of a spring."""
        for spring in self.dynamics.machine.springs:
            if spring.table is not None:
                x = coordinate(self.dynamics, spring.coordinate, done.q, done.v)[0]
                if x.min() < spring.table.x[0] or x.max() > spring.table.x[-1]:
                    raise Refusal(Reason.TABLE, "a spring leaves its table")

    def sample(self, stretch: Stretch, t: float) -> Sample:
        """Motion and forces at a time: the step again, ending there."""
        done, shut, dynamics = stretch.step, self.shut(stretch.closed), self.dynamics
        state = State(done.t0, stretch.q, stretch.v, stretch.closed, {})
        q, v = stretch.q, stretch.v
        if t > done.t0:
            guess = values_between(done.a, rule(len(done.a)).nodes * (t - done.t0) / done.h)
            part = self._step(self._accelerations(shut), state, t - done.t0, guess)
            if part is not None:
                q, v = dynamics.project(t, part.q_end, part.v_end, shut)
        found = dynamics.accelerate(np.array([t]), q[None], v[None], shut)
        rows = slice(dynamics.geometry.constraints, dynamics.geometry.size)
        first = dynamics.geometry.constraints
        drives = {}
        for i, drive in enumerate(dynamics.machine.drives):
            drives[drive.name] = float(found.multipliers[0, first + i])
            if dynamics.shafts:
                # The train drives its shaft, too.
                drives[drive.name] += drive.inertia * float(found.a[0, dynamics.bodies + i])
        stops = {
            stop.name: stop.sense * float(found.multipliers[0, len(dynamics.base) + i])
            for i, stop in enumerate(shut)
        }
        rates = found.rows.jacobian[0, rows] @ v
        return Sample(found.rows.value[0, rows], rates, stops, drives)
