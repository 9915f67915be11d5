"""Places and velocities of all seven bodies in closed form, to initialise other packages."""

from __future__ import annotations

import math

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.study.paper.scheme.planar import Planar, compiled, cross, dot, frame, guide

BODIES = ("pendulum_shaft", "nipper_pivot", "rocker_pin", "jaw", "rod_pin", "steeve",
          "tension_shaft")  # fmt: skip


@compiled
def state(p: Planar, t: float, th: float, w: float) -> tuple[FloatArray, FloatArray]:
    """Displacements from touch and velocities of all bodies.

    Args:
        p: The numbers of the planar equation.
        t: Time from touch [s].
        th: Jaw angle [rad].
        w: Jaw rate [rad/s].

    Returns:
        Two arrays of shape (7, 3): x, z [m] and angle [rad] of the joint that leads to the body,
        and their rates.
    """
    f, g = frame(p, t), frame(p, 0.0)
    u1, w1, _ = guide(p, t)
    E, R = f.J - p.pivot * f.u2, f.J + (p.coupler - p.pivot) * f.u2
    E_v, R_v = 1j * w1 * p.arm * u1, f.Jv + 1j * f.w2 * (R - f.J)
    R0, rocker = g.J + p.coupler - p.pivot - p.rocker_axis, R - p.rocker_axis
    H = f.J + p.rod * f.u2 * complex(math.cos(th), math.sin(th))
    H_v = f.Jv + 1j * (f.w2 + w) * (H - f.J)
    steeve, steeve0 = f.X - H, g.X - g.J - p.rod
    turn_v = cross(steeve, f.Xv - H_v) / dot(steeve, steeve)
    turn = math.atan2(cross(steeve0, steeve), dot(steeve0, steeve))
    first = math.atan2(u1.imag, u1.real)
    second = math.atan2(f.u2.imag, f.u2.real)
    third = math.atan2(cross(R0, rocker), dot(R0, rocker))
    moved = (0j, E - g.J + p.pivot, rocker - R0, f.J - g.J, H - g.J - p.rod, f.X - g.X, 0j)
    moved_v = (0j, E_v, R_v, f.Jv, H_v, f.Xv, 0j)
    angles = (first, second, third, second + th, turn, turn, p.gear * first)
    third_v = cross(rocker, R_v) / dot(rocker, rocker)
    angles_v = (w1, f.w2, third_v, f.w2 + w, turn_v, turn_v, p.gear * w1)
    q, v = np.empty((7, 3)), np.empty((7, 3))
    for i in range(7):
        q[i] = moved[i].real, moved[i].imag, angles[i]
        v[i] = moved_v[i].real, moved_v[i].imag, angles_v[i]
    return q, v
