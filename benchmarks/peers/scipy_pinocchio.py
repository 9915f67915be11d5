"""SciPy's DOP853 on Pinocchio's constrained dynamics: nothing is derived by hand here either.

Right-hand side, closing of the loops after a flight and impact law are those of the direct engine;
integrator, step control and event location are SciPy's, in the same loop as in ``scipy_ivp``. What
is compared is therefore how the direct engine follows a flight, with all else equal.
"""

from __future__ import annotations

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import INFINITE_INERTIA, ShaftMotion, System, close_positions, collide
from nipper_pin.hybrid import initial_state
from nipper_pin.mechanism import Mechanism, rad_s_from_rpm

from .planar import shaft_accelerations
from .planar_model import planar_model
from .protocol import Four, Run, Setting
from .scipy_flight import SETTINGS, Jaw, Start, bounced

NAME = "SciPy DOP853, located events (Pinocchio's accelerations)"
PACKAGE = "scipy"
__all__ = ["NAME", "PACKAGE", "SETTINGS", "prepare"]


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Build the system, bring it to the first collision and compile the drive laws."""
    law = shaft_accelerations(planar_model(mechanism, speed_rpm))
    angle = mechanism.cylinder.angle_at_touch_rad
    shaft = ShaftMotion(mechanism, rad_s_from_rpm(speed_rpm), angle)
    system = System(mechanism, shaft)
    body, nv = system.body, system.body.nv
    jaw = mechanism.stop(mechanism.transition_stop)
    start = initial_state(system, 0.0)
    contacts = [stop for stop in mechanism.stops if stop.name in {jaw.name, *start.closed}]
    restitution = [stop.restitution for stop in contacts]
    first_impact = collide(system, start.q, start.v, start.jacobian, contacts, restitution)
    phase = system.constraint_set(frozenset())
    split = system.split(start.jacobian, phase.given, (jaw.index,))
    places = jaw.index, nv + jaw.index
    first, second = shaft.indices
    # Springs are linear: what they do at rest at touch, and a stiffness.
    preload = system.applied_forces(np.zeros((1, nv)), np.zeros((1, nv)))[0]

    def accelerations(t: float, y: FloatArray) -> FloatArray:
        q, v = y[:nv], y[nv:]
        tau = preload - phase.stiffness * q
        a, b = law(t)
        tau[first], tau[second] = INFINITE_INERTIA * a, INFINITE_INERTIA * b
        return body.accelerations(q[None], v[None], tau[None], phase.armature).reshape(nv)

    def equation(t: float, y: FloatArray) -> FloatArray:
        return np.concatenate([y[nv:], accelerations(t, y)])

    def jaw_acceleration(t: float, y: FloatArray) -> float:
        return float(accelerations(t, y)[jaw.index])

    def after(t: float, y: FloatArray) -> Start:
        a, w = accelerations(t, y), jaw.rate(y[nv:])
        fall = -jaw.rate(a)
        length = 2.0 * w / fall
        speeds = np.abs(y[nv:]) + length * np.abs(a)
        return Start(t, y, w, fall, np.concatenate([length * speeds, speeds]))

    def rebound(t: float, y: FloatArray) -> Start:
        y[jaw.index] = 0.0
        q, jacobians = close_positions(body, y[None, :nv], split)
        v = system.closed_velocity(y[nv:], jacobians[0], split)
        impact = collide(system, q[0], v, jacobians[0], [jaw], [jaw.restitution])
        return after(t, np.concatenate([q[0], impact.v_after]))

    scene = Jaw(jaw.restitution, places, equation, jaw_acceleration, rebound)

    def run(setting: Setting) -> Four:
        before = body.evaluations
        first = after(0.0, np.concatenate([start.q, first_impact.v_after]))
        bounces, _ = bounced(scene, first, setting.value)
        return bounces.four(body.evaluations - before)

    return run
