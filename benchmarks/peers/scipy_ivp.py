"""SciPy's DOP853 on the equation derived by hand."""

from __future__ import annotations

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism

from .planar import jaw_equation
from .planar_model import first_rebound_rate, planar_model
from .protocol import Four, Run, Setting
from .scipy_flight import SETTINGS, Jaw, Start, bounced

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

    def start(t: float, w: float) -> Start:
        fall = -acceleration(t, 0.0, w)
        return Start(t, np.array([0.0, w]), w, fall, np.array([0.5 * w * w / fall, w]))

    def rebound(t: float, y: FloatArray) -> Start:
        return start(t, -p.restitution * y.item(1))

    scene = Jaw(p.restitution, (0, 1), equation, jaw, rebound)

    def run(setting: Setting) -> Four:
        bounces, evaluations = bounced(scene, start(0.0, rate), setting.value)
        return bounces.four(evaluations)

    return run
