"""SciPy's DOP853 on the equation derived by hand."""

from __future__ import annotations

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism

from .planar import jaw_equation
from .planar_model import first_rebound_rate, planar_model
from .protocol import Bounces, Four, Run, Setting
from .scipy_flight import SETTINGS, Flight, Start

NAME = "SciPy DOP853, located events (hand-derived equation)"
PACKAGE = "scipy"
__all__ = ["NAME", "PACKAGE", "SETTINGS", "prepare"]


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Read the numbers and compile the right-hand side."""
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    acceleration = jaw_equation(p)

    def equation(t: float, y: FloatArray) -> tuple[float, float]:
        w = y.item(1)
        return w, acceleration(t, y.item(0), w)

    def jaw(t: float, y: FloatArray) -> float:
        return acceleration(t, y.item(0), y.item(1))

    def run(setting: Setting) -> Four:
        t, w, evaluations = 0.0, rate, 0
        fall = -acceleration(0.0, 0.0, rate)
        bounces = Bounces(p.restitution, rate, fall, 0.1 * setting.value)
        over = False
        while not over:
            first = len(bounces.times) == 1
            scale = np.array([0.5 * w * w / fall, w])
            start = Start(t, np.array([0.0, w]), w, fall, scale)
            flight = Flight(equation, start, (0, 1), setting.value, first)
            t, y, calls = flight.land()
            if first:
                bounces.amplitude = flight.amplitude(jaw)
            # One more call gave the size of the flight.
            evaluations += calls + 1
            w = -p.restitution * y.item(1)
            fall = -acceleration(t, 0.0, w)
            over = bounces.add(t, w, fall)
        return bounces.four(evaluations)

    return run
