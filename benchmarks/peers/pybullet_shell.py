"""PyBullet's steps, with an event loop and the impact law written around them.

Shafts are velocity motors, loops point-to-point constraints, the spring a joint force. An impact is
placed at the linear crossing inside a step, where all joints are set anew, loops closed by hand.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import pybullet

from nipper_pin.mechanism import Mechanism
from nipper_pin.study.paper.scheme.planar import Planar, dot, frame, guide
from nipper_pin.study.paper.scheme.planar_model import first_rebound_rate, planar_model
from nipper_pin.study.paper.scheme.planar_motion import jaw_equation

from .planar_bodies import state
from .protocol import Bounces, Four, Run, Setting
from .pybullet_model import STRONG, bare_urdf, pin_frames

NAME = "PyBullet steps, event loop and impacts by hand"
PACKAGE = "pybullet"
SETTINGS = (
    Setting("10 us", 1e-5),
    Setting("1 us", 1e-6, quick=False),
)
_ITERATIONS = 100


def _joint_states(p: Planar, t: float, th: float, w: float) -> dict[str, tuple[float, float]]:
    """Coordinate and rate of every joint, by its name; arguments as in ``planar_bodies.state``."""
    q, v = state(p, t, th, w)
    turn, spin = q[:, 2], v[:, 2]
    f = frame(p, t)
    steeve = f.X - f.J - p.rod * f.u2 * complex(math.cos(th), math.sin(th))
    across = complex(*(v[5, :2] - v[4, :2]))
    return {
        "pendulum_shaft": (turn[0], spin[0]),
        "nipper_pivot": (turn[1] - turn[0], spin[1] - spin[0]),
        "rocker_pin": (turn[2] - turn[1], spin[2] - spin[1]),
        "jaw": (th, w),
        "rod_pin": (turn[4] - turn[3], spin[4] - spin[3]),
        "steeve": (p.length - abs(steeve), -dot(steeve, across) / abs(steeve)),
        "tension_shaft": (turn[6], spin[6]),
    }


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Build the world; it stays open, as a user's would.

    Args:
        mechanism: The E62, or another set of numbers for it.
        speed_rpm: Cylinder speed [r/min].
    """
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    acceleration = jaw_equation(p)
    world = pybullet.connect(pybullet.DIRECT)
    here = {"physicsClientId": world}
    pybullet.setGravity(0.0, 0.0, -mechanism.gravity_m_s2, **here)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mechanism.urdf"
        path.write_text(bare_urdf(mechanism.urdf), encoding="utf-8")
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, **here)
    count = pybullet.getNumJoints(body, **here)
    places = {pybullet.getJointInfo(body, i, **here)[1].decode(): i for i in range(count)}
    for link in range(-1, count):
        pybullet.changeDynamics(body, link, linearDamping=0.0, angularDamping=0.0,
                                jointDamping=0.0, maxJointVelocity=1e9, **here)  # fmt: skip
    for link in range(count):
        pybullet.setJointMotorControl2(body, link, pybullet.VELOCITY_CONTROL, force=0.0, **here)
    model = mechanism.model
    for closure in mechanism.closures:
        a, b = (model.frames[model.getFrameId(n)] for n in (closure.frame_a, closure.frame_b))
        pin_frames(body, places, model, a, b, here)
    jaw, steeve = places["jaw"], places["steeve"]
    shafts = ((places["pendulum_shaft"], 1.0), (places["tension_shaft"], p.gear))

    def place(t: float, w: float) -> None:
        for name, (q, v) in _joint_states(p, t, 0.0, w).items():
            pybullet.resetJointState(body, places[name], q, v, **here)

    def run(setting: Setting) -> Four:
        h = setting.value
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=h, numSolverIterations=_ITERATIONS, numSubSteps=0, erp=0.2, **here
        )
        bounces = Bounces(p.restitution, rate, -acceleration(0.0, 0.0, rate), h)
        t, th, w, steps, over = 0.0, 0.0, rate, 0, False
        place(t, w)
        while not over:
            u1 = guide(p, t + h)[0]
            turn = math.atan2(u1.imag, u1.real)
            for shaft, ratio in shafts:
                # The rate that meets the law's position at the end of the step.
                behind = ratio * turn - pybullet.getJointState(body, shaft, **here)[0]
                pybullet.setJointMotorControl2(
                    body, shaft, pybullet.VELOCITY_CONTROL,
                    force=STRONG, targetVelocity=behind / h, **here)  # fmt: skip
            s = pybullet.getJointState(body, steeve, **here)[0]
            pybullet.setJointMotorControl2(
                body, steeve, pybullet.TORQUE_CONTROL, force=-p.stiffness * (p.preload + s), **here
            )
            pybullet.stepSimulation(**here)
            steps += 1
            old, old_w = th, w
            th, w = pybullet.getJointState(body, jaw, **here)[:2]
            bounces.amplitude = max(bounces.amplitude, th)
            t += h
            if th <= 0.0:
                late = th / (th - old)
                t -= h * late
                th, w = 0.0, -p.restitution * (w + late * (old_w - w))
                place(t, w)
                fall = -acceleration(t, 0.0, w)
                over = bounces.add(t, w, fall) or w < 2.0 * h * fall
        return bounces.four(steps)

    return run
