"""SUNDIALS' CVODE with its own root finding, through scikit-sundae (Adams formulas).

Time counts from the start of each flight, because the root finder resolves it to a fraction of its
size. Steps go one by one up to a root; the tolerances fit the size of the flight.
"""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism

from .planar import jaw_equation
from .planar_model import first_rebound_rate, planar_model
from .protocol import Bounces, Four, Run, Setting

NAME = "scikit-sundae CVODE, root finding (hand-derived equation)"
PACKAGE = "scikit-sundae"
SETTINGS = (
    Setting("rtol 1e-4", 1e-4),
    Setting("rtol 1e-6", 1e-6),
    Setting("rtol 1e-8", 1e-8),
    Setting("rtol 1e-10", 1e-10),
    Setting("rtol 1e-12", 1e-12),
    Setting("rtol 1e-14", 1e-14),
)
_LONGEST = 0.1


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Read the numbers and compile the right-hand side."""
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    acceleration = jaw_equation(p)

    def touch(_t: float, y: FloatArray, events: FloatArray) -> None:
        events[0] = y[0]

    def touch_and_apex(_t: float, y: FloatArray, events: FloatArray) -> None:
        events[:] = y

    touch.direction = [-1]  # type: ignore[attr-defined]
    touch_and_apex.direction = [-1, -1]  # type: ignore[attr-defined]

    def run(setting: Setting) -> Four:
        t, w, evaluations = 0.0, rate, 0
        bounces = Bounces(p.restitution, rate, -acceleration(0.0, 0.0, rate), setting.value)
        over = False

        def equation(since: float, y: FloatArray, y_dot: FloatArray) -> None:
            nonlocal evaluations
            evaluations += 1
            th_dot = y.item(1)
            y_dot[0] = th_dot
            y_dot[1] = acceleration(t + since, y.item(0), th_dot)

        while not over:
            first = len(bounces.times) == 1
            fall = -acceleration(t, 0.0, w)
            evaluations += 1
            solver = CVODE(
                equation,
                method="Adams",
                rtol=setting.value,
                atol=setting.value * np.array([0.5 * w * w / fall, w]),
                max_num_steps=100_000,
                eventsfn=touch_and_apex if first else touch,
                num_events=2 if first else 1,
            )
            solver.init_step(0.0, np.array([0.0, w]))
            found = solver.step(_LONGEST)
            if first and found.i_events[0, 0] == 0:
                bounces.amplitude = float(found.y[0])
                found = solver.step(_LONGEST)
            t += float(found.t)
            w = -p.restitution * float(found.y[1])
            over = bounces.add(t, w, -acceleration(t, 0.0, w))
        return bounces.four(evaluations)

    return run
