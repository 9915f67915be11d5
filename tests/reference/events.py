"""Flights, impacts, rests and phases of the planar nipper, by Taylor series and Newton.

Impacts with the drives held. With one free coordinate th the impulses are

* jaw (th = 0):     th'+ = -e th'-,  P = A (th'+ - th'-) about the jaw, P / lever at the lip;
* steeve (s = 0):   s'+ = -e_s s'-, so th'+ - th'- = (s'+ - s'-) / (ds/dth) and, from
                    A (th'+ - th'-) = P ds/dth,  P = m (s'+ - s'-) with m = A / (ds/dth)^2.

The energy lost is 1/2 m_eff (rate-)^2 (1 - e^2), m_eff = A for the jaw and m for the steeve stop.

Near an impact a gap vanishes at the start of the flight, with as many derivatives as are known to
be zero: that power of time is divided out before a root is looked for, so the root keeps its full
relative precision however short the flight is. A bounce series is followed until its flights last
less than ``shortest``; the rest is a geometric series with ratio e, T e / (1 - e), right to a
relative O(T), that is, to O(T^2) in time.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from planar import Machine, Motion
from taylor import Number, first_root, horner, safe_step, slope

JAW, STEEVE = "jaw", "steeve"


@dataclass
class Settings:
    """Accuracy of a solution.

    Attributes:
        order: order of the Taylor polynomials.
        tolerance: bound of the last kept terms in a step: of th (rad), of s (m), and of a stop
            force relative to its size.
        shortest: flights shorter than this (s) are closed by the geometric series.
    """

    order: int
    tolerance: str
    shortest: str


@dataclass
class Collision:
    """One collision with a stop; rates are of the stop's coordinate (rad/s or m/s)."""

    stop: str
    time: Number
    psi: Number
    approach_rate: Number
    separation_rate: Number
    effective_inertia: Number
    impulse: Number
    energy_lost: Number
    th: Number
    th_rate_before: Number
    th_rate_after: Number
    stroke: Number
    stroke_rate_before: Number
    stroke_rate_after: Number
    rebound_amplitude: Number | None = None
    rebound_time: Number | None = None


@dataclass
class Phase:
    """One phase of the motion; times in s, forces in N (steeve stop) or N m (jaw).

    Attributes:
        closed: the closed stop (None in a flight phase).
        start: time of its start.
        end: time of its end.
        ended_by: what ended it.
        force_start: multiplier of the closed stop at the start.
        force_end: multiplier of the closed stop at the end.
        force_min: least multiplier.
        force_min_time: when.
        force_max: greatest multiplier.
        force_max_time: when.
    """

    closed: str | None
    start: Number
    end: Number = None
    ended_by: str = ""
    force_start: Number = None
    force_end: Number = None
    force_min: Number = None
    force_min_time: Number = None
    force_max: Number = None
    force_max_time: Number = None


@dataclass
class Trace:
    """What a simulation found."""

    collisions: list[Collision] = field(default_factory=list)
    phases: list[Phase] = field(default_factory=list)
    rests: list[tuple[str, Number, Number]] = field(default_factory=list)
    steps: int = 0


class Simulation:
    """Hybrid motion of one machine; time zero is at the cylinder angle ``psi_start``.

    Args:
        machine: the machine.
        settings: accuracy.
        psi_start: cylinder angle at time zero, rad.
    """

    def __init__(self, machine: Machine, settings: Settings, psi_start: Number) -> None:
        self.machine, self.ctx = machine, machine.ctx
        self.order = settings.order
        self.tolerance = self.ctx.mpf(settings.tolerance)
        self.shortest = self.ctx.mpf(settings.shortest)
        self.psi_start = psi_start
        self.trace = Trace()

    def psi(self, time: Number) -> Number:
        """Cylinder angle at a time, rad."""
        return self.psi_start - self.machine.speed * time

    # ---- flights ---------------------------------------------------------------------------

    def bounce(
        self,
        time: Number,
        th: Number,
        rate: Number,
        vanish: dict[str, int],
        end: Number,
    ) -> tuple[str, Number]:
        """Flights and collisions until one stop has come to rest.

        Args:
            time: start, s.
            th: jaw angle at the start, rad.
            rate: jaw rate at the start, rad/s.
            vanish: for each stop, how many leading Taylor coefficients of its gap are zero.
            end: give up at this time (no event).

        Returns:
            The stop that rests ("" when ``end`` came first) and the time of rest.
        """
        ctx, machine = self.ctx, self.machine
        phase = Phase(None, time)
        self.trace.phases.append(phase)
        last: dict[str, Collision] = {}
        if self.trace.collisions and self.trace.collisions[-1].time == time:
            last[self.trace.collisions[-1].stop] = self.trace.collisions[-1]
        peak: dict[str, Number] = {JAW: ctx.zero, STEEVE: ctx.zero}
        # The stroke and its rate: a difference of two lengths keeps its absolute precision only.
        stroke = [last[stop].stroke_rate_after for stop in last]
        stroke = [ctx.zero, *stroke] if stroke else []
        while True:
            self.trace.steps += 1
            motion = machine.flight(machine.frame(self.psi(time)), th, rate)
            gaps = {JAW: motion.th, STEEVE: motion.stroke}
            full = {stop: list(gap.upto(self.order)) for stop, gap in gaps.items()}
            for stop, count in vanish.items():
                full[stop][:count] = [ctx.zero] * count
            full[STEEVE][: len(stroke)] = stroke
            step = min(safe_step(c, self.tolerance, ctx) for c in full.values())
            step = min(step, end - time)
            if not step > 0:
                # Dimensions that do not close make numbers that are none.
                message = "a flight cannot be resolved"
                raise ArithmeticError(message)
            hits = []
            for stop, c in full.items():
                root = first_root(c[vanish.get(stop, 0) :], step, ctx)
                if root is not None:
                    hits.append((root, stop))
            hit = min(hits) if hits else None
            step = hit[0] if hit else step
            for stop, c in full.items():
                peak[stop] = max(peak[stop], self._maximum(c, step))
            now = time + step
            if hit is None:
                th, rate = horner(full[JAW], step), horner(slope(full[JAW]), step)
                stroke = [horner(full[STEEVE], step), horner(slope(full[STEEVE]), step)]
                vanish, time = {}, now
                if time >= end:
                    phase.end, phase.ended_by = time, "end of the window"
                    return "", time
                continue
            stop = hit[1]
            collision, th, rate = self._impact(stop, now, motion, step, full)
            self.trace.collisions.append(collision)
            if stop in last:
                previous = last[stop]
                # A single flight gives its own length: no difference of large times.
                one_flight = vanish.get(stop, 0) > 0 and previous is self.trace.collisions[-2]
                previous.rebound_time = step if one_flight else now - previous.time
                previous.rebound_amplitude = peak[stop]
                if previous.rebound_time < self.shortest:
                    e = self.restitution(stop)
                    rest = now + previous.rebound_time * e / (1 - e)
                    self.trace.rests.append((stop, rest, now))
                    phase.end, phase.ended_by = rest, stop + " at rest"
                    return stop, rest
            last[stop] = collision
            stroke = [collision.stroke, collision.stroke_rate_after]
            peak[stop] = ctx.zero
            vanish, time = {stop: 1}, now

    def restitution(self, stop: str) -> Number:
        """Coefficient of restitution of a stop."""
        machine = self.machine
        return machine.jaw_restitution if stop == JAW else machine.stop_restitution

    def _maximum(self, c: list[Number], step: Number) -> Number:
        """Greatest value of a gap on a step, from its interior extremum or its ends."""
        values = [horner(c, self.ctx.zero), horner(c, step)]
        top = first_root(slope(c), step, self.ctx)
        if top is not None:
            values.append(horner(c, top))
        return max(values)

    def _impact(
        self,
        stop: str,
        time: Number,
        motion: Motion,
        step: Number,
        full: dict[str, list[Number]],
    ) -> tuple[Collision, Number, Number]:
        """Collision at the end of a step: the record, the angle and the rate after it."""
        ctx, n = self.ctx, self.order
        th = horner(full[JAW], step) if stop != JAW else ctx.zero
        rate = horner(slope(full[JAW]), step)
        stroke = horner(full[STEEVE], step) if stop != STEEVE else ctx.zero
        stroke_rate = horner(slope(full[STEEVE]), step)
        inertia = motion.inertia(step, n - 2)
        s_th = motion.stroke_th(step, n - 2)
        return self._collide(stop, time, th, rate, stroke, stroke_rate, inertia, s_th)

    def _collide(
        self,
        stop: str,
        time: Number,
        th: Number,
        rate: Number,
        stroke: Number,
        stroke_rate: Number,
        inertia: Number,
        s_th: Number,
    ) -> tuple[Collision, Number, Number]:
        e = self.restitution(stop)
        before = rate if stop == JAW else stroke_rate
        mass = inertia if stop == JAW else inertia / s_th**2
        after = -e * before
        jump = (after - before) if stop == JAW else (after - before) / s_th
        collision = Collision(
            stop=stop,
            time=time,
            psi=self.psi(time),
            approach_rate=before,
            separation_rate=after,
            effective_inertia=mass,
            impulse=mass * (after - before),
            energy_lost=mass * before**2 * (1 - e**2) / 2,
            th=th,
            th_rate_before=rate,
            th_rate_after=rate + jump,
            stroke=stroke,
            stroke_rate_before=stroke_rate,
            stroke_rate_after=stroke_rate + s_th * jump,
        )
        return collision, th, rate + jump

    # ---- phases with a closed stop -----------------------------------------------------------

    def hold(
        self, stop: str, time: Number, end: Number, glued: bool = False
    ) -> tuple[str, Number, Motion | None]:
        """Kinematic phase with one stop closed, until the other closes or its force ends.

        Args:
            stop: the closed stop.
            time: start, s.
            end: end of the window, s.
            glued: keep the stop closed even where its force pulls.

        Returns:
            Event ("jaw", "steeve": that stop collides; "release": the force of the closed stop
            passes zero; "end"), its time, and the motion expanded at the event.
        """
        ctx, machine = self.ctx, self.machine
        phase = Phase(stop, time)
        self.trace.phases.append(phase)
        expand = machine.phase1 if stop == STEEVE else machine.phase2
        n = self.order - 2
        while True:
            self.trace.steps += 1
            motion, force = expand(machine.frame(self.psi(time)))
            gap = (motion.th if stop == STEEVE else motion.stroke).upto(self.order)
            force_c = force.upto(n)
            size = max(abs(force_c[0]), ctx.one)
            step = min(
                safe_step(gap, self.tolerance, ctx),
                safe_step(force_c, self.tolerance * size, ctx),
                end - time,
            )
            events = []
            root = first_root(gap, step, ctx)
            if root is not None:
                events.append((root, JAW if stop == STEEVE else STEEVE))
            root = first_root(force_c, step, ctx)
            if root is not None and not glued:
                events.append((root, "release"))
            event = min(events) if events else None
            step = event[0] if event else step
            self._extremes(phase, force_c, time, step)
            time = time + step
            if event is None and time < end:
                continue
            phase.end = time
            phase.ended_by = event[1] if event else "end of the window"
            if event is None:
                return "end", time, None
            return event[1], time, expand(machine.frame(self.psi(time)))[0]

    def _extremes(self, phase: Phase, c: list[Number], time: Number, step: Number) -> None:
        """Fold the force polynomial of one step into the extremes of a phase."""
        ctx = self.ctx
        places = [ctx.zero, step]
        d = slope(c)
        for falling in (True, False):
            root = first_root(d if falling else [-x for x in d], step, ctx)
            if root is not None:
                places.append(root)
        for place in places:
            value = horner(c, place)
            if phase.force_min is None or value < phase.force_min:
                phase.force_min, phase.force_min_time = value, time + place
            if phase.force_max is None or value > phase.force_max:
                phase.force_max, phase.force_max_time = value, time + place
        if phase.force_start is None:
            phase.force_start = c[0]
        phase.force_end = horner(c, step)

    def collide_from(self, held: str, stop: str, time: Number, motion: Motion) -> Number:
        """First collision of a stop while the other one is closed; returns th' after it."""
        zero = self.ctx.zero
        rate = motion.th[1] if held == STEEVE else zero
        stroke_rate = motion.stroke_rate[0] if held == JAW else zero
        collision, _, after = self._collide(
            stop, time, zero, rate, zero, stroke_rate, motion.inertia[0], motion.stroke_th[0]
        )
        self.trace.collisions.append(collision)
        return after


def transition(machine: Machine, settings: Settings) -> Trace:
    """From the first collision at the jaw (time zero, cylinder at touch) to rest of the jaw."""
    run = Simulation(machine, settings, machine.psi_touch)
    zero = machine.ctx.zero
    motion, _ = machine.phase1(machine.frame(machine.psi_touch))
    rate = run.collide_from(STEEVE, JAW, zero, motion)
    fly(run, zero, rate, machine.ctx.mpf("0.1"))
    return run.trace


def glued_stop_force(machine: Machine, settings: Settings) -> Phase:
    """Force of the steeve stop from index 24 to touch if the stop could also pull.

    Its minimum is what decides whether the steeve stays on its stop while the jaw is open.
    """
    run = Simulation(machine, settings, machine.psi_foremost())
    run.hold(STEEVE, machine.ctx.zero, 2 * machine.ctx.pi / machine.speed, glued=True)
    return run.trace.phases[0]


def fly(run: Simulation, time: Number, rate: Number, end: Number) -> tuple[str, Number]:
    """Bounces after the first collision of a phase (both gaps start at zero)."""
    return run.bounce(time, run.ctx.zero, rate, {JAW: 1, STEEVE: 1}, end)


def cycle(machine: Machine, settings: Settings, turns: int = 1) -> Trace:
    """Working cycles from index 24, jaw open and steeve on its stop.

    Args:
        machine: the machine.
        settings: accuracy.
        turns: number of cylinder turns.
    """
    run = Simulation(machine, settings, machine.psi_foremost())
    ctx = machine.ctx
    end = turns * 2 * ctx.pi / machine.speed
    held, time = STEEVE, ctx.zero
    while True:
        event, time, motion = run.hold(held, time, end)
        if event == "end" or motion is None:
            return run.trace
        if event == "release":
            # The multiplier is zero: the gap starts with zero value, rate and acceleration.
            held, time = run.bounce(time, motion.th[0], motion.th[1], {held: 3}, end)
        else:
            rate = run.collide_from(held, event, time, motion)
            held, time = fly(run, time, rate, end)
        if not held:
            return run.trace
