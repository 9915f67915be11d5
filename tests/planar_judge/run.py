"""A run from event to event: collisions, rests and releases."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .contacts import collision, responses, staying
from .dynamics import Dynamics
from .flight import Flight, Precision
from .machine import Machine, Stop, read_machine
from .record import Event, Verdict
from .start import start
from .triggers import State
from .verdict import Reason, Refusal

Array = np.ndarray
# A gap this small at the start is a contact [rad or m].
_TOUCHING = 1e-12
# A series ends where what is left of it is known this well [s], by the change of its deceleration.
_REST = 1e-14
_MOST = 20_000
# Turns that are no time.
_INSTANT = 1e-13
# So many events within this part of a turn are a series of series: most last a few dozen.
_SERIES, _SHORT = 600, 1e-8


class Bounce(NamedTuple):
    """The last collision of a stop that bounces alone: time, rate after, deceleration."""

    t: float
    rate: float
    deceleration: float


# Steps that are too long may run away in their iterations, before they are halved.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def judge(
    model: Machine | Path | str,
    speed_rpm: float,
    start_index: float = 24.0,
    drive: str = "held",
    turns: int = 1,
    *,
    coordinates: Mapping[str, float] | None = None,
    rates: Mapping[str, float] | None = None,
    precision: Precision | None = None,
    most: int = _MOST,
) -> Verdict:
    """Follow a machine, or that of a model folder, over whole turns; drives are held or inertial.

    At the start it is in its initial phase. Joint coordinates and their rates are given where the
    drives and closed stops leave some free.
    """
    verdict = Verdict()
    try:
        machine = model if isinstance(model, Machine) else read_machine(model)
        rate = machine.sense * speed_rpm * 2.0 * math.pi / 60.0
        dynamics = Dynamics(machine, rate, machine.start_angle(start_index), drive == "held")
        run = Run(dynamics, precision or Precision(), verdict, most)
        run.begin(coordinates, rates)
        run.go(turns * 2.0 * math.pi / abs(rate))
    except Refusal as refusal:
        verdict.reason, verdict.detail = refusal.reason, str(refusal)
    return verdict


class Run:
    """State and events of one run."""

    def __init__(
        self, dynamics: Dynamics, precision: Precision, verdict: Verdict, most: int = _MOST
    ) -> None:
        self.dynamics, self.verdict, self.most = dynamics, verdict, most
        self.flight = Flight(dynamics, precision, verdict)
        self.machine = dynamics.machine
        self.series: dict[str, Bounce] = {}
        self.thrown: dict[tuple[str, frozenset[str]], tuple[float, float]] = {}
        self.first = math.inf
        self.instant: list[tuple[float, float]] = []
        self.state: State

    # The start.

    def begin(
        self, coordinates: Mapping[str, float] | None, rates: Mapping[str, float] | None
    ) -> None:
        """Assemble the machine, and collide or close what touches."""
        q, v = start(self.dynamics, coordinates, rates)
        closed, gaps = self.machine.initial, {}
        for stop in self.machine.stops:
            if stop.name not in closed:
                gap, rate = self.flight.fresh_gap(stop, q, v)
                if gap < -_TOUCHING:
                    raise Refusal(Reason.BEYOND, f"{stop.name} by {-gap:.3g} at the start")
                fastest = float(np.abs(v / self.dynamics.unit).max())
                still = abs(rate) <= 1e-12 * fastest
                gaps[stop.name] = (0.0 if abs(gap) < _TOUCHING else gap, 0.0 if still else rate)
        self.state = State(0.0, q, v, closed, gaps)
        still = [n for n, (gap, rate) in gaps.items() if gap == rate == 0.0]
        hit = [n for n, (gap, rate) in gaps.items() if gap == 0.0 and rate < 0.0]
        if hit:
            self.collide(hit)
        else:
            self.settle(closed | set(still))

    def settle(self, at_rest: frozenset[str]) -> None:
        """Close and open stops at rest as their forces want it."""
        state = self.state
        stays = staying(self.dynamics, state.t, state.q, state.v, self.flight.shut(at_rest))
        opened, newly = state.closed - stays, stays - state.closed
        gaps = {n: pair for n, pair in state.gaps.items() if n not in stays}
        gaps |= dict.fromkeys(opened, (0.0, 0.0))
        if opened:
            self.note("release", state.t, sorted(opened), closed=stays - newly)
        if newly:
            self.note("rest", state.t, sorted(newly), closed=stays)
        self.state = state._replace(closed=stays, gaps=gaps)

    def note(self, kind: str, t: float, stops: list[str], closed: frozenset[str]) -> None:
        """Record an event without impulse; no rest comes before the limit of a series."""
        limits = (event.t for event in self.verdict.events if event.kind == "rest")
        t = max([t, *limits]) if kind == "rest" else t
        self.verdict.events.append(Event(kind, t, tuple(stops), {}, {}, {}, 0.0, closed))

    # The way.

    def go(self, t_end: float) -> None:
        """Follow the motion to a time."""
        while self.state.t < t_end:
            falling = [n for n, (gap, rate) in self.state.gaps.items() if gap <= 0.0 and rate < 0.0]
            if falling:
                self.collide(falling)
                continue
            limit, self.first = self.first, math.inf
            state, hit, released = self.flight.advance(self.state, self._until(t_end), limit)
            self.state = state
            self.verdict.t = state.t
            if released:
                self._release(released)
            if hit:
                for name in hit:
                    state.gaps[name] = (0.0, state.gaps[name][1])
                worst = min(state.gaps[name][1] for name in hit)
                hit = [n for n in hit if state.gaps[n][1] <= max(worst, 0.0)]
                self.collide(hit)

    def _until(self, t_end: float) -> float:
        """The end, or the next time at which a law changes its polynomial."""
        dynamics, best = self.dynamics, t_end
        psi = dynamics.start + dynamics.rate * self.state.t
        sense = math.copysign(1.0, dynamics.rate)
        for drive in self.machine.drives:
            for knot in drive.law.knots:
                ahead = (sense * (knot - psi)) % (2.0 * math.pi)
                if ahead > 1e-9:
                    best = min(best, self.state.t + ahead / abs(dynamics.rate))
        return best

    def _release(self, released: list[str]) -> None:
        state, closed = self.state, self.state.closed
        self.series.clear()
        self.thrown.clear()
        if len(released) > 1:
            # Forces that vanish together: what comes next tells which stops open.
            ahead = self.flight.turn * 1e-7
            a = self.dynamics.accelerate(
                np.array([state.t]), state.q[None], state.v[None], self.flight.shut(closed)
            ).a[0]
            q = state.q + ahead * (state.v + 0.5 * ahead * a)
            q, v = self.dynamics.project(
                state.t + ahead, q, state.v + ahead * a, self.flight.shut(closed)
            )
            stays = staying(self.dynamics, state.t + ahead, q, v, self.flight.shut(closed))
            released = sorted(closed - stays) or released
        gaps = state.gaps | dict.fromkeys(released, (0.0, 0.0))
        self.state = state._replace(closed=closed - set(released), gaps=gaps)
        self.note("release", state.t, sorted(released), closed=self.state.closed)

    # Collisions.

    def collide(self, hit: list[str]) -> None:
        """Apply the law of impact, see what stays closed, and whether a series ends."""
        state = self.state
        if len(self.verdict.events) > self.most:
            self.verdict.known = self.state.t
            raise Refusal(Reason.COLLISIONS, f"more than {self.most} events")
        self._endless()
        stops = self.flight.shut(state.closed | set(hit))
        before = np.array([state.gaps[s.name][1] if s.name in hit else 0.0 for s in stops])
        self._jammed(float(-before.min()))
        change, P, after = collision(self.dynamics, state.q, stops, before)
        lost = -0.5 * float(P @ (before + after))
        names = [stop.name for stop in stops]
        v = state.v + change
        gaps = {n: (g, r + self._rate_change(n, change)) for n, (g, r) in state.gaps.items()}
        gaps |= {n: (0.0, float(rate)) for n, rate in zip(names, after, strict=True)}
        at_rest = frozenset(n for n, rate in zip(names, after, strict=True) if rate == 0.0)
        stays = staying(self.dynamics, state.t, state.q, v, self.flight.shut(at_rest))
        gaps = {n: pair for n, pair in gaps.items() if n not in stays}
        struck = tuple(n for n, p in zip(names, P, strict=True) if p > 0.0 or n in hit)
        self.verdict.events.append(
            Event("collision", state.t, struck, dict(zip(names, before.tolist(), strict=True)),
                  dict(zip(names, after.tolist(), strict=True)),
                  dict(zip(names, P.tolist(), strict=True)), lost, stays)
        )  # fmt: skip
        self.state = state._replace(v=v, closed=stays, gaps=gaps)
        ended = stays & set(hit)
        if ended:
            self.note("rest", state.t, sorted(ended), closed=stays)
        self._end_of_series(hit, state.closed - stays, -float(before[names.index(hit[0])]))

    def _endless(self) -> None:
        """Give up a series of series, whose limit only the simpler ones tell."""
        if len(self.verdict.events) < _SERIES:
            return
        began = self.verdict.events[-_SERIES].t
        if self.state.t - began < _SHORT * self.flight.turn:
            self.verdict.known = began
            raise Refusal(Reason.SERIES, f"{_SERIES} events from {began:.9g} s on")

    def _jammed(self, rate: float) -> None:
        """Many collisions in one instant that get no slower are a jam."""
        since = self.state.t - _INSTANT * self.flight.turn
        self.instant = [(t, r) for t, r in self.instant if t >= since]
        self.instant.append((self.state.t, rate))
        if len(self.instant) > 60 and rate > 0.5 * self.instant[0][1]:
            raise Refusal(Reason.JAM, "collisions without end in one instant")

    def _rate_change(self, name: str, change: Array) -> float:
        (stop,) = (s for s in self.machine.stops if s.name == name)
        rows = self.dynamics.evaluate(self.state.q[None], change[None])
        return stop.sense * float(rows.jacobian[0, self.dynamics.stop_rows[name]] @ change)

    def _deceleration(self, stop: Stop) -> float:
        state = self.state
        found = self.dynamics.accelerate(
            np.array([state.t]), state.q[None], state.v[None], self.flight.shut(state.closed)
        )
        row = self.dynamics.stop_rows[stop.name]
        return -stop.sense * float(
            found.rows.jacobian[0, row] @ found.a[0] + found.rows.bias[0, row]
        )

    def _end_of_series(self, hit: list[str], opened: frozenset[str], approach: float) -> None:
        """Let stops that bounce come to rest once what is left of it is known.

        Of those that have just closed the first one did so at this rate; others it has opened.
        """
        bouncing = [
            stop for stop in self.machine.stops
            if self.state.gaps.get(stop.name, (1.0, 0.0))[0] == 0.0
            and self.state.gaps[stop.name][1] > 0.0
        ]  # fmt: skip
        if not bouncing:
            return
        left = [self._left(stop) for stop in bouncing]
        (self.first,) = (2.0 * min(item[1] for item in left),)
        remaining = max(item[0] for item in left)
        change = 10.0 * abs(self.dynamics.rate)
        if len(hit) == 1 and not opened and len(bouncing) == 1:
            (stop,) = bouncing
            # Other stops meet what follows as long after it, roughly, as they have been left alone.
            change = max(change, 10.0 / max(self.state.t - self._begun(stop.name), 1e-300))
            last = self.series.get(stop.name)
            rate = self.state.gaps[stop.name][1]
            here = Bounce(self.state.t, rate, 2.0 * rate / left[0][1])
            self.series[stop.name] = here
            if last is not None and here.t > last.t and 0.0 < last.deceleration < math.inf:
                passed = here.t - last.t
                change += abs(here.deceleration / last.deceleration - 1.0) / passed
        elif len(hit) == 1 and opened:
            # A collision that throws stops open which were at rest: one of a series of series.
            key = hit[0], self.state.closed | opened
            last_time, last_rate = self.thrown.get(key, (math.nan, math.nan))
            self.thrown[key] = self.state.t, approach
            share, passed = approach / last_rate, self.state.t - last_time
            known = passed * share / (1.0 - share) if 0.0 < share < 1.0 else math.inf
            remaining = max(remaining, known)
        elif remaining > _INSTANT * self.flight.turn:
            return
        if remaining < math.inf and min(change * remaining**2, remaining) < _REST:
            self._rest(bouncing, remaining)

    def _begun(self, name: str) -> float:
        """Time since which only this stop has been struck [s]."""
        first = self.state.t
        for event in reversed(self.verdict.events):
            others = any(rate != 0.0 for other, rate in event.before.items() if other != name)
            if name not in event.before or others:
                break
            first = event.t
        return first

    def _left(self, stop: Stop) -> tuple[float, float]:
        """Time until rest, and the length of the next flight, at constant deceleration."""
        rate, pressing = self.state.gaps[stop.name][1], self._deceleration(stop)
        if pressing <= 0.0:
            return math.inf, math.inf
        flight = 2.0 * rate / pressing
        return (flight / (1.0 - stop.restitution) if stop.restitution < 1.0 else math.inf), flight

    def _rest(self, bouncing: list[Stop], remaining: float) -> None:
        """Take the last rates away; the collisions left out push by as much as they would have."""
        state = self.state
        names = state.closed | {stop.name for stop in bouncing}
        for name, (gap, rate) in state.gaps.items():
            if name not in names and gap + 1.1 * rate * remaining <= 0.0:
                return
        shut = self.flight.shut(names)
        v = self._arrested(shut)
        change = v - state.v
        stays = staying(self.dynamics, state.t, state.q, v, shut)
        newly = sorted(stop.name for stop in bouncing if stop.name in stays)
        if len(newly) < len(bouncing) or not state.closed <= stays:
            return
        gaps = {
            n: (gap, rate + self._rate_change(n, change))
            for n, (gap, rate) in state.gaps.items() if n not in stays
        }  # fmt: skip
        self.state = state._replace(v=v, closed=stays, gaps=gaps)
        self.first = math.inf
        self.note("rest", state.t + remaining, newly, closed=stays)

    def _arrested(self, shut: list[Stop]) -> Array:
        """Rates without what is left of the bounces, by the impulse that takes it away."""
        changes, D = responses(self.dynamics, self.state.q, shut)
        rates = np.array([self.state.gaps.get(s.name, (0.0, 0.0))[1] for s in shut])
        return self.state.v - changes @ np.linalg.solve(D, rates)
