"""Exudyn's dynamics and its generalized-alpha steps, with an event loop and the impact law around.

Exudyn's own contact is a penalty; here it integrates flights only, a flight a call, and its
post-step function stops it below the stop. Between the last two steps th is a cubic, exact to more
orders than the method. The rates after an impact are closed by hand (``planar_bodies``), which
takes away the drift of the loops as well. Short flights get at least twelve steps.
"""

from __future__ import annotations

from typing import Any

import exudyn
import numpy as np
from scipy.interpolate import CubicHermiteSpline

from nipper_pin.mechanism import Mechanism
from nipper_pin.study.paper.scheme.planar_model import first_rebound_rate, planar_model
from nipper_pin.study.paper.scheme.planar_motion import jaw_equation
from nipper_pin.tolerances.bench import CLOSING

from .exudyn_model import build
from .planar_bodies import state
from .protocol import Bounces, Four, Run, Setting

NAME = "Exudyn generalized-alpha steps, event loop and impacts by hand"
PACKAGE = "exudyn"
SETTINGS = (
    Setting("100 us", 1e-4),
    Setting("20 us", 2e-5),
    Setting("5 us", 5e-6),
    Setting("1 us", 1e-6, quick=False),
)
_LONGEST = 2.0
_FEWEST_STEPS = 12
_BOTTOM, _TOP = 5, 11


def _settings() -> Any:
    """Settings of the solver: no files, tight Newton iteration with a kept Jacobian."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.newton.relativeTolerance = 1e-8
    # No numerical dissipation: nothing is stiff, and it would reduce the accuracy.
    settings.timeIntegration.generalizedAlpha.spectralRadius = 1.0
    return settings


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Build the system.

    Args:
        mechanism: The E62, or another set of numbers for it.
        speed_rpm: Cylinder speed [r/min].
    """
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    acceleration = jaw_equation(p)
    container, mbs = build(mechanism, p)
    data, settings = mbs.systemData, _settings()
    path: list[tuple[float, float, float]] = []

    def above(_mbs: object, t: float) -> bool:
        if t <= path[0][0]:
            # Exudyn calls it for the initial state too.
            return True
        q, v = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
        path.append((t, float(q[_TOP] - q[_BOTTOM]), float(v[_TOP] - v[_BOTTOM])))
        return path[-1][1] > 0.0

    mbs.SetPostStepUserFunction(above)

    def fly(t: float, w: float, step: float) -> None:
        """Integrate one flight into ``path``."""
        path[:] = [(t, 0.0, w)]
        flight = 2.0 * w / -acceleration(t, 0.0, w)
        step = min(step, flight / _FEWEST_STEPS)
        count = int(_LONGEST * flight / step)
        q, v = state(p, t, 0.0, w)
        initial = exudyn.ConfigurationType.Initial
        data.SetODE2Coordinates(q.ravel(), initial)
        data.SetODE2Coordinates_t(v.ravel(), initial)
        settings.timeIntegration.startTime = t
        settings.timeIntegration.endTime = t + count * step
        settings.timeIntegration.numberOfSteps = count
        mbs.SolveDynamic(
            settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha,
            storeSolver=False, showHints=False,
        )  # fmt: skip

    def run(setting: Setting) -> Four:
        t, w, steps, over = 0.0, rate, 0, False
        bounces = Bounces(p.restitution, rate, -acceleration(0.0, 0.0, rate), CLOSING)
        while not over:
            fly(t, w, setting.value)
            steps += len(path) - 1
            times, th, slopes = np.array(path).T
            if len(bounces.times) == 1:
                top = int(np.argmax(slopes <= 0.0))
                near = slice(top - 1, top + 1)
                cubic = CubicHermiteSpline(times[near], th[near], slopes[near])
                turns = cubic.derivative().roots(extrapolate=False)
                bounces.amplitude = float(cubic(turns).max())
            end = CubicHermiteSpline(times[-2:], th[-2:], slopes[-2:])
            t = float(end.roots(extrapolate=False).max())
            w = -p.restitution * float(end(t, 1))
            over = bounces.add(t, w, -acceleration(t, 0.0, w))
        return bounces.four(steps)

    # The first call initialises the solver.
    run(SETTINGS[0])
    # The main system lives in its container.
    run.container = container  # type: ignore[attr-defined]
    return run
