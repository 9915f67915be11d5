"""MuJoCo's dynamics and its RK4 steps, with an event loop and the impact law written around them.

Nothing is derived by hand: loops, rates and inertias are MuJoCo's. The loop does what ``rk4`` does:
a step that ends below the stop is taken again, shortened by Newton's method to end on it.
"""

from __future__ import annotations

import mujoco

from nipper_pin.mechanism import Mechanism

from .mujoco_model import SHAFT_INERTIA, compile_model, mjcf, rates, touch_rates
from .planar import shaft_accelerations
from .planar_model import planar_model
from .protocol import Bounces, Four, Run, Setting
from .rk4 import SETTINGS as STEPS
from .rk4 import closing

NAME = "MuJoCo RK4 steps, event loop and impacts by hand"
PACKAGE = "mujoco"
# The last step of RK4, 1 us, takes too long from Python.
SETTINGS = STEPS[:-1]
_NEWTON = 8


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Build the model and the state just before the first collision."""
    p = planar_model(mechanism, speed_rpm)
    law = shaft_accelerations(p)
    model = compile_model(mjcf(mechanism))
    data = mujoco.MjData(model)
    jaw = mechanism.stop("jaw").index
    first, second = (drive.index for drive in mechanism.drives)
    before = touch_rates(model, data, mechanism, p.psi_rate)

    def drive(_model: mujoco.MjModel, state: mujoco.MjData) -> None:
        a, b = law(state.time)
        state.qfrc_applied[first] = SHAFT_INERTIA * a
        state.qfrc_applied[second] = SHAFT_INERTIA * b

    def rebound() -> float:
        """Apply the impact law to the state and return the rebound rate."""
        mujoco.mj_fwdPosition(model, data)
        approach = float(data.qvel[jaw])
        jump = -(1.0 + p.restitution) * approach
        data.qvel[:] += rates(model, data, {first: 0.0, second: 0.0, jaw: jump})
        return -p.restitution * approach

    def run(setting: Setting) -> Four:
        mujoco.set_mjcb_control(drive)
        try:
            return transition(setting)
        finally:
            mujoco.set_mjcb_control(None)

    def transition(setting: Setting) -> Four:
        steps = 0

        def step(length: float) -> tuple[float, float]:
            """Step from the saved state; jaw angle and rate after it."""
            nonlocal steps
            steps += 1
            data.qpos[:], data.qvel[:], data.time = q, v, t
            model.opt.timestep = length
            mujoco.mj_step(model, data)
            return float(data.qpos[jaw]), float(data.qvel[jaw])

        def deceleration() -> float:
            """Deceleration of the jaw at the start of a flight [rad/s^2]."""
            mujoco.mj_forward(model, data)
            return -float(data.qacc[jaw])

        mujoco.mj_resetData(model, data)
        data.qvel[:] = before
        w = rebound()
        uncertain = closing(setting.value, p.psi_rate)
        bounces = Bounces(p.restitution, w, deceleration(), uncertain)
        t, th, q, v = 0.0, 0.0, data.qpos.copy(), data.qvel.copy()
        over = False
        while not over:
            part = setting.value
            new, new_w = step(part)
            if len(bounces.times) == 1 and w > 0.0 >= new_w:
                top, slope = step(part * w / (w - new_w))
                # What is left of the rate is lost on a parabola; its curvature is that of the step.
                bounces.amplitude = top + 0.5 * slope * slope * part / (w - new_w)
                new, new_w = step(part)
            if new <= 0.0:
                if th == 0.0:
                    part *= w / (w - new / part)
                    new, new_w = step(part)
                for _ in range(_NEWTON):
                    change = new / new_w
                    part -= change
                    new, new_w = step(part)
                    if abs(change) <= 1e-7 * part:
                        break
                data.qpos[jaw] = new = 0.0
                new_w = rebound()
                over = bounces.add(data.time, new_w, deceleration())
            t, th, w, q, v = data.time, new, new_w, data.qpos.copy(), data.qvel.copy()
        return bounces.four(4 * steps)

    return run
