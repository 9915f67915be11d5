"""MuJoCo's own contact: the jaw's stop is a joint limit, fixed steps, no event location.

MuJoCo has no coefficient of restitution. A limit with damping (1 + e) / h and no stiffness turns a
closing rate v into -e v within one semi-implicit Euler step h, which is what is used here.
Times of collisions are read off between the two steps around the crossing. The jaw rests at the
first rebound slower than 1e-3 rad/s or one and a half steps of acceleration, whichever is more (a
resting limit chatters at that rate); to be lenient the rest of the geometric series is added.
"""

from __future__ import annotations

import mujoco

from nipper_pin.errors import SimulationError
from nipper_pin.mechanism import Mechanism

from .mujoco_model import SHAFT_INERTIA, compile_model, mjcf, touch_rates
from .planar import jaw_equation, shaft_accelerations
from .planar_model import planar_model
from .protocol import Four, Run, Setting

NAME = "MuJoCo, own joint limit as contact"
PACKAGE = "mujoco"
SETTINGS = (
    Setting("10 us", 1e-5),
    Setting("1 us", 1e-6),
    Setting("0.1 us", 1e-7, quick=False),
)
_THRESHOLD = 1e-3
_LONGEST = 0.1
# A limit is an inequality: its row may change sides once or twice.
_ITERATIONS = 6
# MuJoCo divides the damping of a limit by the impedance.
_IMPEDANCE = 0.9999


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Build the model and the state just before the first collision."""
    p = planar_model(mechanism, speed_rpm)
    law, acceleration = shaft_accelerations(p), jaw_equation(p)
    model = compile_model(mjcf(mechanism, "Euler", "0 -1"))
    model.opt.iterations = _ITERATIONS
    data = mujoco.MjData(model)
    jaw = mechanism.stop("jaw").index
    first, second = (drive.index for drive in mechanism.drives)
    before = touch_rates(model, data, mechanism, p.psi_rate)

    def run(setting: Setting) -> Four:
        step = setting.value
        model.opt.timestep = step
        model.jnt_solref[jaw] = 0.0, -_IMPEDANCE * (1.0 + p.restitution) / step
        mujoco.mj_resetData(model, data)
        data.qvel[:] = before
        forces, q, v = data.qfrc_applied, data.qpos, data.qvel
        # The crossings of zero; the first one is the start.
        times, amplitude, th, steps, falling = [0.0], 0.0, 0.0, 0, True
        while steps * step < _LONGEST:
            a, b = law(steps * step)
            forces[first] = SHAFT_INERTIA * a
            forces[second] = SHAFT_INERTIA * b
            old = th
            mujoco.mj_step(model, data)
            steps += 1
            th, w = q.item(jaw), v.item(jaw)
            if len(times) == 1 and th > amplitude:
                amplitude = th
            if th <= 0.0 < old:
                times.append(step * (steps - 1 + old / (old - th)))
            if w <= 0.0:
                falling = True
            elif falling and th <= 0.0:
                falling = False
                fall = -acceleration(times[-1], 0.0, w)
                if len(times) > 2 and w < max(_THRESHOLD, 1.5 * fall * step):
                    rest = times[-1] + 2.0 * w / (fall * (1.0 - p.restitution))
                    return Four(times[1], times[2] - times[1], amplitude, rest, steps)
        message = f"the bounces do not come to an end with a step of {step:g} s"
        raise SimulationError(message, step_s=step)

    return run
