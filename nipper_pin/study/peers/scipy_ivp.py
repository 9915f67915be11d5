"""SciPy's DOP853, stepped by hand with events located on its dense output.

Not ``solve_ivp(events=...)``: that reports a root on the end of a step twice and stops at once when
it is restarted on the ground. Each flight is a new solver whose first step is the ballistic flight
time, so that a late flight is a single step, and whose tolerances fit the size of the flight.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853, DenseOutput

from ...arrays import FloatArray
from ...mechanism import Mechanism
from .planar_model import first_rebound_rate, planar_model
from .planar_motion import jaw_equation
from .protocol import Bounces, Four, Run, Setting

NAME = "SciPy DOP853, located events (hand-derived equation)"
PACKAGE = "scipy"
SETTINGS = (
    Setting("rtol 1e-3", 1e-3),
    Setting("rtol 1e-5", 1e-5),
    Setting("rtol 1e-7", 1e-7),
    Setting("rtol 1e-9", 1e-9),
    Setting("rtol 1e-11", 1e-11),
    Setting("rtol 1e-13", 1e-13),
)
_LONGEST = 0.1
_NEWTON = 12


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Read the numbers and compile the right-hand side.

    Args:
        mechanism: The E62, or another set of numbers for it.
        speed_rpm: Cylinder speed [r/min].
    """
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    acceleration = jaw_equation(p)

    def equation(t: float, y: FloatArray) -> tuple[float, float]:
        w = y.item(1)
        return w, acceleration(t, y.item(0), w)

    def run(setting: Setting) -> Four:
        t, w, evaluations = 0.0, rate, 0
        bounces = Bounces(p.restitution, rate, -acceleration(0.0, 0.0, rate), 0.1 * setting.value)
        over = False
        while not over:
            start, first = t, len(bounces.times) == 1
            fall = -acceleration(start, 0.0, w)
            scale = np.array([0.5 * w * w / fall, w])
            solver = DOP853(
                equation,
                start,
                np.array([0.0, w]),
                start + _LONGEST,
                rtol=setting.value,
                atol=setting.value * scale,
                # Just beyond the parabola's end, so that a short flight ends inside the step.
                first_step=2.02 * w / fall,
            )
            while solver.y[0] > 0.0 or solver.t == start:
                rising = solver.y[1] > 0.0
                solver.step()
                if first and rising and solver.y[1] <= 0.0:
                    bounces.amplitude = _apex(solver.dense_output(), solver.t, acceleration)
            t, approach = _touch(solver.dense_output(), solver.t)
            # One more call gave the size of the flight.
            evaluations += solver.nfev + 1
            w = -p.restitution * approach
            over = bounces.add(t, w, -acceleration(t, 0.0, w))
        return bounces.four(evaluations)

    return run


def _touch(motion: DenseOutput, t: float) -> tuple[float, float]:
    """Time [s] and rate [rad/s] of the fall through zero in a step that ends below it.

    The motion is concave, so Newton's method from the end of the step approaches from one side and
    cannot run into the start of the flight, which is a root too.
    """
    for _ in range(_NEWTON):
        th, w = motion(t).tolist()
        change = th / w
        t -= change
        if abs(change) <= 1e-9 * (t - motion.t_old):
            break
    return t, motion(t).item(1)


def _apex(motion: DenseOutput, t: float, acceleration: Callable[..., float]) -> float:
    """Greatest jaw angle in a step in which the rate changes its sign [rad]."""
    for _ in range(_NEWTON):
        th, w = motion(t).tolist()
        a = acceleration(t, th, w)
        t -= w / a
        if abs(w) <= 1e-9 * abs(a) * (t - motion.t_old):
            break
    return float(th - 0.5 * w * w / a)
