"""Fixed-step RK4 with located impacts on the hand-derived equation, everything compiled.

A step that ends below the stop is taken again, shortened by Newton's method to end on it; the
greatest jaw angle is found likewise. The drives are evaluated twice a step, not four times.
"""

from __future__ import annotations

import math

from nipper_pin.mechanism import Mechanism

from .planar import Frame, Planar, acceleration, compiled, frame
from .planar_model import first_rebound_rate, planar_model
from .protocol import MOST_COLLISIONS, Run, Setting, stepped

NAME = "fixed-step RK4, located impacts (numba, hand-derived equation)"
PACKAGE = "numba"
SETTINGS = tuple(
    Setting(f"{us} us", float(f"{us}e-6"), quick=us >= 20)
    for us in (1000, 500, 200, 100, 50, 20, 10, 1)
)


def closing(step: float, psi_rate: float) -> float:
    """Relative uncertainty at which the series is closed: well below the error of the steps."""
    return float(max(1e-14, 0.01 * (step * psi_rate) ** 4))


@compiled
def rk4_step(
    p: Planar, f0: Frame, t: float, th: float, w: float, h: float
) -> tuple[float, float, Frame]:
    """Classical Runge-Kutta step of length h [s] from a time whose frame is known."""
    middle, end = frame(p, t + 0.5 * h), frame(p, t + h)
    a1 = acceleration(p, f0, th, w)
    w2 = w + 0.5 * h * a1
    a2 = acceleration(p, middle, th + 0.5 * h * w, w2)
    w3 = w + 0.5 * h * a2
    a3 = acceleration(p, middle, th + 0.5 * h * w2, w3)
    w4 = w + h * a3
    a4 = acceleration(p, end, th + h * w3, w4)
    return (
        th + h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4),
        w + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
        end,
    )


@compiled
def limit(times: list[float], rates: list[float]) -> tuple[float, float]:
    """Time of rest and its uncertainty [s], by Neville's scheme in the rebound rate."""
    column = times[-8:]
    w = rates[-8:]
    previous = column[-1]
    best, error = math.inf, math.inf
    for order in range(1, len(w)):
        for i in range(len(w) - order):
            column[i] = (w[i] * column[i + 1] - w[i + order] * column[i]) / (w[i] - w[i + order])
        found = column[len(w) - order - 1]
        if abs(found - previous) < error:
            best, error = found, abs(found - previous)
        previous = found
    return best, error


@compiled
def transition(
    p: Planar, rate: float, step: float, certain: float
) -> tuple[float, float, float, float, int]:
    """The numbers of a transition from its first rebound rate [rad/s]; see ``protocol.Four``.

    The bounces are closed at this relative uncertainty of their limit; the time of rest is not
    finite if they do not end.
    """
    t, th, w = 0.0, 0.0, rate
    f = frame(p, t)
    times, rates = [0.0], [rate]
    amplitude, rest, error, steps = 0.0, math.inf, math.inf, 0
    while len(times) < 4 or error > certain * rest:
        new, new_w, new_f = rk4_step(p, f, t, th, w, step)
        steps += 1
        if len(times) == 1 and w > 0.0 >= new_w:
            part = step * w / (w - new_w)
            top, slope, top_f = rk4_step(p, f, t, th, w, part)
            steps += 1
            # What is left of the rate is lost on a parabola.
            amplitude = top - 0.5 * slope * slope / acceleration(p, top_f, top, slope)
        if new > 0.0:
            t, th, w, f = t + step, new, new_w, new_f
            continue
        part = step
        if th == 0.0:
            # The flight is a parabola nearly: th / h falls almost linearly from w.
            part = step * w / (w - new / step)
            new, new_w, new_f = rk4_step(p, f, t, th, w, part)
            steps += 1
        for _ in range(8):
            change = new / new_w
            part -= change
            new, new_w, new_f = rk4_step(p, f, t, th, w, part)
            steps += 1
            if abs(change) <= 1e-7 * part:
                break
        t, th, w, f = t + part, 0.0, -p.restitution * new_w, new_f
        times.append(t)
        rates.append(w)
        rest, error = limit(times, rates)
        if len(times) > MOST_COLLISIONS or not 0.0 < w < rates[-2]:
            return math.nan, math.nan, math.nan, math.nan, 4 * steps
    return times[1], times[2] - times[1], amplitude, rest, 4 * steps


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Read the numbers and compile."""
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    transition(p, rate, 1e-4, 1e-9)
    return stepped(
        lambda setting: transition(p, rate, setting.value, closing(setting.value, p.psi_rate))
    )
