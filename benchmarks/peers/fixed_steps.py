"""The published study's scheme: a fixed step of 0.01 us, impacts where a step ends below the stop.

Which explicit rule the study uses is not stated; two are offered. The jaw rests, as there, at the
first rebound slower than a threshold, 1e-3 rad/s or one and a half steps of acceleration if that is
more. To be lenient, the rest of the geometric series is added, which the study does not do.
"""

from __future__ import annotations

import math

from nipper_pin.mechanism import Mechanism

from .planar import Planar, acceleration, compiled, frame
from .planar_model import first_rebound_rate, planar_model
from .protocol import Run, Setting, stepped

NAME = "fixed small steps as published (numba, hand-derived equation)"
PACKAGE = "numba"
SETTINGS = tuple(
    Setting(f"{us} us, {name}", float(f"{us}e-6"), quick=us != "0.01", method=name.split()[0])
    for us in ("1", "0.1", "0.01") for name in ("forward Euler", "semi-implicit")
)  # fmt: skip
_THRESHOLD = 1e-3
_LONGEST = 0.1


@compiled
def transition(
    p: Planar, rate: float, step: float, forward: bool
) -> tuple[float, float, float, float, int]:
    """Run one transition; arguments and results as in ``rk4.transition``."""
    th, w, th_max, steps = 0.0, rate, 0.0, 0
    first, second, amplitude, collisions = 0.0, 0.0, 0.0, 1
    while steps * step < _LONGEST:
        a = acceleration(p, frame(p, steps * step), th, w)
        old = w
        w += step * a
        th += step * (old if forward else w)
        steps += 1
        th_max = max(th_max, th)
        if th > 0.0 or w >= 0.0:
            continue
        th, w = 0.0, -p.restitution * w
        collisions += 1
        t = steps * step
        if collisions == 2:
            first, amplitude = t, th_max
        elif collisions == 3:
            second = t - first
        if collisions > 2 and w < max(_THRESHOLD, 1.5 * abs(a) * step):
            rest = t + 2.0 * w / (abs(a) * (1.0 - p.restitution))
            return first, second, amplitude, rest, steps
    return math.nan, math.nan, math.nan, math.nan, steps


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Read the numbers and compile."""
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    transition(p, rate, 1e-5, True)
    return stepped(lambda setting: transition(p, rate, setting.value, setting.method == "forward"))
