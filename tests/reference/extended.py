"""The planar nipper in 80-bit arithmetic: the 60-digit solution's machine, a thousand times faster.

The geometry is that of ``planar.py``, evaluated at many instants at once on arrays of
``numpy.longdouble``. Between events the equation of motion is solved by Gauss-Legendre collocation
of 24 points in time, for the jaw angle and the steeve stroke alike, so that both gaps keep their
relative precision however short a flight is. A bounce series is followed until its flights last
less than 1e-11 s; what is left is a geometric series. The agreement with the certified solutions
is tested in ``test_extended.py``; nothing here is shared with the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from planar import Machine

JAW, STEEVE = "jaw", "steeve"
COLLISION, REST, RELEASE = "collision", "rest", "release"
L = np.longdouble
PI = L("3.14159265358979323846264338327950288")
ORDER, SAMPLES = 24, 96
SHORTEST = L("1e-11")
# Of x'' beside its size; its double integral is another thousand times better.
_TAIL = L("1e-16")
_MOST_SWEEPS = 60
_PANELS_PER_TURN = 60
# Times the surroundings of a minimum are looked at more closely, by 64 each.
_FINER = 5


class Extended:
    """What ``planar.Machine`` asks of an mpmath context, for arrays of 80-bit numbers."""

    zero, one, pi = L(0), L(1), PI

    @staticmethod
    def mpf(value: Any) -> Any:
        """A real number, from its decimals."""
        return L(value)

    @staticmethod
    def mpc(real: Any, imaginary: Any) -> Any:
        """A complex number."""
        return L(real) + 1j * L(imaginary)

    @staticmethod
    def expj(angle: Any) -> Any:
        """exp(i x) of a real number."""
        return np.cos(angle) + 1j * np.sin(angle)

    @staticmethod
    def arg(value: Any) -> Any:
        """Angle of a complex number."""
        return np.arctan2(np.imag(value), np.real(value))

    @staticmethod
    def fdot(left: Any, right: Any) -> Any:
        """Sum of products."""
        return sum(a * b for a, b in zip(left, right, strict=True))

    asin, sqrt = staticmethod(np.arcsin), staticmethod(np.sqrt)


def _legendre(x: Any, count: int) -> Any:
    """Legendre polynomials 0 .. count - 1 at some places, shape (count, places)."""
    rows = [np.ones_like(x), x]
    for k in range(1, count - 1):
        rows.append(((2 * k + 1) * x * rows[k] - k * rows[k - 1]) / L(k + 1))
    return np.array(rows)


def _integrals(sigma: Any) -> tuple[Any, Any, Any]:
    """Shifted Legendre polynomials on [0, 1], their integrals and double ones from 0."""
    p = _legendre(2 * sigma - 1, ORDER + 2)
    once = np.empty((ORDER + 1, len(sigma)), dtype=L)
    once[0] = sigma
    for k in range(1, ORDER + 1):
        once[k] = (p[k + 1] - p[k - 1]) / L(2 * (2 * k + 1))
    twice = np.empty((ORDER, len(sigma)), dtype=L)
    twice[0] = sigma**2 / 2
    # The integral of P_k is a difference of two polynomials.
    twice[1] = (once[2] - once[0]) / 6 + 0 * sigma
    for k in range(2, ORDER):
        twice[k] = (once[k + 1] - once[k - 1]) / L(2 * (2 * k + 1))
    return p[:ORDER], once[:ORDER], twice


_P, _ONE, _TWO = [L(2 * k + 1) for k in range(ORDER + 2)], L(1), L(2)


def _integrals_at(sigma: Any) -> tuple[Any, Any, Any]:
    """What ``_integrals`` gives at one place, each of shape (ORDER,); numbers are faster there."""
    x = _TWO * sigma - _ONE
    p = [_ONE, x]
    for k in range(1, ORDER + 1):
        p.append((_P[k] * x * p[k] - k * p[k - 1]) / (k + 1))
    once = [sigma, *((p[k + 1] - p[k - 1]) / (_TWO * _P[k]) for k in range(1, ORDER + 1))]
    twice = [sigma * sigma / _TWO, (once[2] - once[0]) / 6]
    twice += [(once[k + 1] - once[k - 1]) / (_TWO * _P[k]) for k in range(2, ORDER)]
    return np.array(p[:ORDER]), np.array(once[:ORDER]), np.array(twice)


def _nodes() -> tuple[Any, Any]:
    """Gauss-Legendre points on [0, 1] and the map from values there to coefficients."""
    k = np.arange(ORDER)
    x = np.cos(PI * (k + L("0.75")) / (ORDER + L("0.5")))[::-1].astype(L)
    for _ in range(6):
        p = _legendre(x, ORDER + 1)
        slope = ORDER * (x * p[ORDER] - p[ORDER - 1]) / (x**2 - 1)
        x = x - p[ORDER] / slope
    p = _legendre(x, ORDER + 1)
    slope = ORDER * (x * p[ORDER] - p[ORDER - 1]) / (x**2 - 1)
    weights = 2 / ((1 - x**2) * slope**2)
    scale = (2 * np.arange(ORDER) + 1) / L(2)
    return (1 + x) / 2, scale[:, None] * p[:ORDER] * weights


SIGMA, _COEFFICIENTS = _nodes()
_, _once, _twice = _integrals(SIGMA)
ONCE, TWICE = _once.T @ _COEFFICIENTS, _twice.T @ _COEFFICIENTS
PLACES = np.arange(1, SAMPLES + 1) / L(SAMPLES)
_, _SAMPLED_ONCE, _SAMPLED_TWICE = (part.T for part in _integrals(PLACES))


@dataclass
class Happening:
    """An event; rates are of the stop's coordinate (rad/s or m/s), impulses N m s or N s.

    Attributes:
        kind: collision, rest or release.
        stop: the stop.
        time: of it, s.
        approach: rate before a collision.
        separation: rate after it.
        impulse: of a collision.
        amplitude: of the rebound after it.
        rebound: its duration, s.
    """

    kind: str
    stop: str
    time: Any
    approach: Any = None
    separation: Any = None
    impulse: Any = None
    amplitude: Any = None
    rebound: Any = None


@dataclass
class Gap:
    """A gap on a panel: x = x0 + h sigma v0 + h^2 (double integral of its acceleration)."""

    x: Any
    v: Any
    h: Any
    c: Any

    def at(self, sigma: Any) -> tuple[Any, Any]:
        """Gap and rate at one place of the panel."""
        x, v, _ = self.all_at(sigma)
        return x, v

    def all_at(self, sigma: Any) -> tuple[Any, Any, Any]:
        """Gap, rate and acceleration at one place of the panel."""
        p, once, twice = _integrals_at(L(sigma))
        x = self.x + self.h * (sigma * self.v + self.h * (twice @ self.c))
        return x, self.v + self.h * (once @ self.c), p @ self.c

    def sampled(self) -> tuple[Any, Any]:
        """Gaps and rates at ``PLACES``."""
        x = self.x + self.h * (PLACES * self.v + self.h * (_SAMPLED_TWICE @ self.c))
        return x, self.v + self.h * (_SAMPLED_ONCE @ self.c)

    def root(self) -> Any | None:
        """First place in (0, 1] where the gap falls to zero, or None."""
        x, v = self.sampled()
        for i in range(SAMPLES):
            before = PLACES[i - 1] if i else L(0)
            if x[i] <= 0 and (i or self.x > 0 or self.v > 0):
                return self._polished(before, PLACES[i])
            if i and v[i - 1] < 0 <= v[i]:
                bottom = self._turning(before, PLACES[i])
                if self.at(bottom)[0] <= 0:
                    return self._polished(before, bottom)
        return None

    def highest(self, end: Any) -> Any:
        """Greatest gap on [0, end]."""
        x, v = self.sampled()
        inside = int(np.searchsorted(PLACES, end, side="left"))
        best = max([self.x, self.at(end)[0], *x[:inside]])
        rates, places = [self.v, *v[:inside], self.at(end)[1]], [L(0), *PLACES[:inside], end]
        for i in range(len(rates) - 1):
            if rates[i] > 0 >= rates[i + 1]:
                best = max(best, self.at(self._turning(places[i], places[i + 1]))[0])
        return best

    def _turning(self, low: Any, high: Any) -> Any:
        """Where the rate vanishes in a bracket, to the square root of what its value needs."""
        falls, place = self.at(low)[1] > 0, (low + high) / 2
        for _ in range(200):
            _, rate, a = self.all_at(place)
            low, high = (place, high) if (rate > 0) == falls else (low, place)
            new = place - rate / (self.h * a) if a != 0 else low
            new = new if low < new < high else (low + high) / 2
            if abs(new - place) <= L("1e-11"):
                return new
            place = new
        return place

    def _polished(self, low: Any, high: Any) -> Any:
        """Zero of the gap over the place if it starts at zero: relative precision is kept."""

        def value(place: Any) -> tuple[Any, Any]:
            x, v = self.at(place)
            if self.x != 0:
                return x, self.h * v
            return x / place, (self.h * v - x / place) / place

        place = (low + high) / 2
        for _ in range(200):
            f, slope = value(place)
            low, high = (place, high) if f > 0 else (low, place)
            new = place - f / slope if slope != 0 else low
            inside = low < new < high
            new = new if inside else (low + high) / 2
            if abs(new - place) <= L("3e-19") * place:
                return new
            place = new
        return place


class Solution:
    """Motion of one machine from a cylinder angle on, as its events.

    Args:
        changes: parameters (names of ``planar.PARAMETERS``) that differ, as decimals.

    Attributes:
        events: what happened, in order of time.
        most: give up after so many flights.
    """

    def __init__(self, changes: dict[str, str], most: int = 3000) -> None:
        self.machine = Machine(Extended(), changes)
        self.events: list[Happening] = []
        self.most = most
        self.longest = 2 * PI / self.machine.speed / _PANELS_PER_TURN
        self.start = self.machine.psi_touch

    # ---- the equation of motion at many instants -----------------------------------------------

    def driven(self, times: Any) -> tuple[Any, ...]:
        """What the drives prescribe: jaw pivot, eccentric pin, bottom nipper with derivatives."""
        return self._carried(self.machine.frame(self.start - self.machine.speed * times))

    @staticmethod
    def _carried(frame: Any) -> tuple[Any, ...]:
        pivot, eccentric = frame.pivot.upto(2), frame.eccentric.upto(2)
        spin = frame.bottom_rate.upto(1)
        return (*pivot[:2], 2 * pivot[2], *eccentric[:2], 2 * eccentric[2], frame.bottom[0], *spin)

    def motion(self, driven: tuple[Any, ...], th: Any, rate: Any) -> dict[str, Any]:
        """Equation of motion and stroke at jaw angles and rates, th'' = (Q - r) / A."""
        m = self.machine
        j, j1, j2, x, x1, x2, bottom, w2, w2_rate = driven
        top = bottom * Extended.expj(th)
        w4 = w2 + rate
        h, c = top * m.rod_in_top, top * m.com4_in_top
        spin = 1j * w2_rate - w4 * w4
        rod, rod1, rod2 = j + h, j1 + 1j * w4 * h, j2 + spin * h
        d, d1, d2 = x - rod, x1 - rod1, x2 - rod2
        length = np.abs(d)
        u = d / length
        length1, turn = _dot(u, d1), _cross(u, d1) / length
        turn1 = (_cross(u, d2) - 2 * length1 * turn) / length
        bent = u * (1j * turn1 - turn * turn)
        com4, com5, com6 = j2 + spin * c, x2 - m.com5 * bent, rod2 + m.com6 * bent
        h_th, c_th = 1j * h, 1j * c
        s_th, turn_th = _dot(u, h_th), -_cross(u, h_th) / length
        u_th = 1j * u * turn_th
        com5_th, com6_th = -m.com5 * u_th, h_th + m.com6 * u_th
        parts = (m.mass4, c_th, com4), (m.mass5, com5_th, com5), (m.mass6, com6_th, com6)
        inertia = m.inertia4 + m.inertia56 * turn_th**2
        bias = m.inertia4 * w2_rate + m.inertia56 * turn_th * turn1
        stroke = m.steeve_length - length
        force = -m.stiffness * (m.preload + stroke) * s_th
        for mass, by, at_rest in parts:
            inertia = inertia + mass * _dot(by, by)
            bias = bias + mass * _dot(by, at_rest)
            force = force - m.gravity * mass * by.imag
        a = (force - bias) / inertia
        return {
            "a": a, "stroke": stroke, "stroke_rate": -length1, "s_th": s_th, "inertia": inertia,
            "stroke_a": s_th * a - _dot(u, d2) - length * turn**2, "torque": bias - force,
        }  # fmt: skip

    def at(self, time: Any, th: Any, rate: Any) -> dict[str, Any]:
        """Equation of motion at one instant."""
        found = self.motion(self.driven(np.array([time], dtype=L)), th, rate)
        return {key: np.ravel(value)[0] for key, value in found.items()}

    # ---- flights -------------------------------------------------------------------------------

    def panel(
        self, time: Any, state: dict[str, Any], h: Any, start: Any
    ) -> tuple[Any, dict[str, Gap]]:
        """Solve both gaps on a panel, which is halved until it is resolved.

        The iteration begins with the acceleration ``start`` of the jaw.
        """
        a = start * np.ones(ORDER, dtype=L)
        while True:
            driven = self.driven(time + h * SIGMA)
            change, found = L("inf"), {}
            for sweep in range(_MOST_SWEEPS):
                rate = state["rate"] + h * (ONCE @ a)
                th = state["th"] + h * (SIGMA * state["rate"] + h * (TWICE @ a))
                found = self.motion(driven, th, rate)
                before, change = change, np.abs(found["a"] - a).max()
                size = np.abs(found["a"]).max() + abs(state["rate"]) / h
                a = found["a"]
                if change <= L("1e-18") * size or (sweep > 3 and change >= before / 2):
                    break
            c, c_s = _COEFFICIENTS @ a, _COEFFICIENTS @ found["stroke_a"]
            tail = np.abs(c[-3:]).max() <= _TAIL * size
            # A stroke that is released begins without acceleration: what it sums up counts.
            tail_s = np.abs(c_s[-3:]).max() - L("1e-18") * size
            tail = tail and tail_s <= _TAIL * np.abs(c_s).max()
            if tail and change <= L("1e-16") * size:
                gaps = {
                    JAW: Gap(state["th"], state["rate"], h, c),
                    STEEVE: Gap(state["s"], state["s_rate"], h, c_s),
                }
                return h, gaps
            h, a = h / 2, a[0] * np.ones(ORDER, dtype=L)
            # Dimensions that do not close make numbers that are none, at any length.
            if not np.isfinite(change) or h < self.longest * L("1e-30"):
                message = "a flight cannot be resolved"
                raise ArithmeticError(message)

    def fly(self, time: Any, state: dict[str, Any], end: Any) -> tuple[str, Any, dict[str, Any]]:
        """Flights and collisions until one stop rests; returns it, the time and the state."""
        last: dict[str, Happening] = {}
        if self.events and self.events[-1].time == time and self.events[-1].kind == COLLISION:
            last[self.events[-1].stop] = self.events[-1]
        peak, flown = {JAW: L(0), STEEVE: L(0)}, {JAW: L(0), STEEVE: L(0)}
        for _ in range(self.most):
            now = self.at(time, state["th"], state["rate"])
            h = min(self.longest, end - time)
            for x, v, a in (
                (state["th"], state["rate"], now["a"]),
                (state["s"], state["s_rate"], now["stroke_a"]),
            ):
                # After a release a gap and its first two derivatives are zero.
                if a < 0 and (x != 0 or v != 0):
                    h = min(h, L("1.02") * (v + np.sqrt(max(v * v - 2 * a * x, L(0)))) / -a)
            if h <= 0:
                break
            h, gaps = self.panel(time, state, h, now["a"])
            roots = {stop: gap.root() for stop, gap in gaps.items()}
            hits = sorted((root, stop) for stop, root in roots.items() if root is not None)
            sigma = hits[0][0] if hits else L(1)
            (th, rate), (s, s_rate) = gaps[JAW].at(sigma), gaps[STEEVE].at(sigma)
            for stop, gap in gaps.items():
                peak[stop] = max(peak[stop], gap.highest(sigma))
                flown[stop] += h * sigma
            time = time + h * sigma
            state = {"th": th, "rate": rate, "s": s, "s_rate": s_rate}
            if not hits:
                if time >= end:
                    return "", time, state
                continue
            stop = hits[0][1]
            state[{JAW: "th", STEEVE: "s"}[stop]] = L(0)
            hit, state = self.struck(stop, time, state)
            if stop in last:
                last[stop].rebound, last[stop].amplitude = flown[stop], peak[stop]
                if flown[stop] < SHORTEST:
                    e = self.restitution(stop)
                    rest = time + flown[stop] * e / (1 - e)
                    self.events.append(Happening(REST, stop, rest))
                    return stop, rest, state
            last[stop], peak[stop], flown[stop] = hit, L(0), L(0)
        message = "no rest"
        raise ArithmeticError(message)

    def restitution(self, stop: str) -> Any:
        """Coefficient of restitution of a stop."""
        machine = self.machine
        return machine.jaw_restitution if stop == JAW else machine.stop_restitution

    def struck(
        self, stop: str, time: Any, state: dict[str, Any]
    ) -> tuple[Happening, dict[str, Any]]:
        """A collision with the drives held; returns it and the state after it."""
        now = self.at(time, state["th"], state["rate"])
        s_th, e = now["s_th"], self.restitution(stop)
        before = state["rate"] if stop == JAW else state["s_rate"]
        mass = now["inertia"] if stop == JAW else now["inertia"] / s_th**2
        jump = -(1 + e) * before
        after = dict(state)
        after["rate"] = state["rate"] + (jump if stop == JAW else jump / s_th)
        after["s_rate"] = state["s_rate"] + (jump if stop == STEEVE else jump * s_th)
        after["rate" if stop == JAW else "s_rate"] = -e * before
        hit = Happening(COLLISION, stop, time, before, -e * before, mass * jump)
        self.events.append(hit)
        return hit, after

    # ---- phases with a closed stop -------------------------------------------------------------

    def held(self, stop: str, times: Any) -> dict[str, Any]:
        """Motion with one stop closed: the gap of the other one, its rate, and the stop's force."""
        machine = self.machine
        frame = machine.frame(self.start - machine.speed * times)
        driven, zero = self._carried(frame), np.zeros_like(times)
        if stop == JAW:
            now = self.motion(driven, zero, zero)
            return {"gap": now["stroke"], "rate": now["stroke_rate"], "force": now["torque"],
                    "th": zero, "th_rate": zero}  # fmt: skip
        th = machine.jaw_on_stop_in_phase_1(frame).upto(2)
        now = self.motion(driven, th[0], th[1])
        force = (now["inertia"] * 2 * th[2] + now["torque"]) / now["s_th"]
        return {"gap": th[0], "rate": th[1], "force": force, "th": th[0], "th_rate": th[1]}

    def hold(self, stop: str, time: Any, end: Any) -> tuple[str, Any]:
        """One stop closed until the other one closes or its force ends; returns which, and when."""
        step = 2 * PI / self.machine.speed / 720
        while time < end:
            times = np.minimum(time + step * np.arange(0, 129).astype(L), end)
            found = self.held(stop, times)
            events = []
            for key, name in (("gap", JAW if stop == STEEVE else STEEVE), ("force", RELEASE)):
                root = self._crossing(stop, key, times, found[key])
                if root is not None:
                    events.append((root, name))
            if events:
                root, name = min(events)
                return name, root
            time = times[-1]
        return "", end

    def begin(self, held: str, name: str, time: Any) -> dict[str, Any]:
        """State after the collision or the release that ends a phase with a closed stop."""
        now = self.held(held, np.array([time], dtype=L))
        gap, rate = now["gap"][0], now["rate"][0]
        state = {"th": L(0), "rate": L(0), "s": L(0), "s_rate": L(0)}
        other = ("th", "rate") if held == STEEVE else ("s", "s_rate")
        state[other[1]] = rate
        if name == RELEASE:
            state[other[0]] = gap
            self.events.append(Happening(RELEASE, held, time))
            return state
        return self.struck(name, time, state)[1]

    def _crossing(self, stop: str, key: str, times: Any, values: Any) -> Any | None:
        """First time at which a value falls through zero, between instants and in dips."""
        for i in range(1, len(times)):
            if values[i - 1] > 0 >= values[i]:
                return self._falls(stop, key, times[i - 1], times[i])
            if 0 < i < len(times) - 1 and values[i - 1] >= values[i] < values[i + 1]:
                most = max(values[i - 1], values[i + 1]) - values[i]
                if 0 < values[i] <= most / 4:
                    root = self._dip(stop, key, times[i - 1], times[i + 1])
                    if root is not None:
                        return root
        return None

    def _dip(self, stop: str, key: str, low: Any, high: Any) -> Any | None:
        """First zero of a value with one minimum between two times, or None."""
        for _ in range(_FINER):
            times = np.linspace(low, high, 129, dtype=L)
            inside = self.held(stop, times)[key]
            below = np.flatnonzero(inside <= 0)
            if len(below):
                first = int(below[0])
                return self._falls(stop, key, times[first - 1], times[first]) if first else None
            place = int(np.argmin(inside))
            low, high = times[max(place - 1, 0)], times[min(place + 1, 128)]
        return None

    def _falls(self, stop: str, key: str, low: Any, high: Any) -> Any:
        """Zero of a value in a bracket: secants, and halves where they leave it."""
        a, b = (self.held(stop, np.array([t], dtype=L))[key][0] for t in (low, high))
        older, old, f_older, f_old = low, high, a, b
        for _ in range(100):
            new = old - f_old * (old - older) / (f_old - f_older) if f_old != f_older else old
            if not low < new < high:
                new = (low + high) / 2
            if abs(new - old) <= L("2e-19") * high or high - low <= L("2e-19") * high:
                break
            f = self.held(stop, np.array([new], dtype=L))[key][0]
            low, high = (new, high) if f > 0 else (low, new)
            older, old, f_older, f_old = old, new, f_old, f
        return new


def transition(changes: dict[str, str]) -> list[Happening]:
    """From the first collision at the jaw (time zero, cylinder at touch) to rest of the jaw."""
    run = Solution(changes)
    now = run.held(STEEVE, np.zeros(1, dtype=L))
    state = {"th": L(0), "rate": now["th_rate"][0], "s": L(0), "s_rate": L(0)}
    time, period = L(0), 2 * PI / run.machine.speed
    _, state = run.struck(JAW, time, state)
    held = ""
    while held != JAW:
        held, time, state = run.fly(time, state, period)
        if held == JAW:
            return run.events
        if held == "":
            break
        # The steeve rests first: the jaw follows it until it touches again.
        name, time = run.hold(held, time, period)
        if not name:
            break
        state = run.begin(held, name, time)
    message = "no rest"
    raise ArithmeticError(message)


def cycle(changes: dict[str, str]) -> list[Happening]:
    """One turn from the foremost position, jaw open and steeve on its stop."""
    run = Solution(changes)
    run.start = run.machine.psi_foremost()
    held, time, end = STEEVE, L(0), 2 * PI / run.machine.speed
    while True:
        name, time = run.hold(held, time, end)
        if not name:
            return run.events
        held, time, _ = run.fly(time, run.begin(held, name, time), end)
        if not held:
            return run.events


def _dot(a: Any, b: Any) -> Any:
    return a.real * b.real + a.imag * b.imag


def _cross(a: Any, b: Any) -> Any:
    return a.real * b.imag - a.imag * b.real
