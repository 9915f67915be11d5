"""The hand-derived equation of the jaw in flight, compiled, and bound to one set of numbers."""

from __future__ import annotations

import math
from collections.abc import Callable

from .planar import Frame, Planar, compiled, cross, dot, frame, guide


@compiled
def acceleration(p: Planar, f: Frame, th: float, w: float) -> float:
    """Jaw acceleration in flight [rad/s^2].

    Args:
        p: The numbers of the equation.
        f: What the drives prescribe at this time.
        th: Jaw angle [rad].
        w: Jaw rate [rad/s].
    """
    top = f.u2 * complex(math.cos(th), math.sin(th))
    w4 = f.w2 + w
    spin = complex(-w4 * w4, f.a2)
    arm_h, arm_c = top * p.rod, top * p.com4
    steeve = f.X - f.J - arm_h
    steeve_v = f.Xv - f.Jv - 1j * w4 * arm_h
    H_a = f.Ja + arm_h * spin
    steeve_a = f.Xa - H_a
    length = math.sqrt(dot(steeve, steeve))
    u = steeve / length
    length_v = dot(u, steeve_v)
    gamma_v = cross(u, steeve_v) / length
    gamma_a = (cross(u, steeve_a) - 2.0 * length_v * gamma_v) / length
    u_a = u * complex(-gamma_v * gamma_v, gamma_a)
    H_th, com4_th = 1j * arm_h, 1j * arm_c
    s_th = dot(u, H_th)
    gamma_th = -cross(u, H_th) / length
    u_th = 1j * gamma_th * u
    com6_th = H_th + u_th * p.com6
    com5_th = u_th * p.com5
    A = (
        p.mass4 * dot(com4_th, com4_th)
        + p.mass5 * dot(com5_th, com5_th)
        + p.mass6 * dot(com6_th, com6_th)
        + p.inertia56 * gamma_th * gamma_th
        + p.inertia4
    )
    r = (
        p.mass4 * dot(com4_th, f.Ja + arm_c * spin)
        + p.mass5 * dot(com5_th, f.Xa + u_a * p.com5)
        + p.mass6 * dot(com6_th, H_a + u_a * p.com6)
        + p.inertia56 * gamma_th * gamma_a
        + p.inertia4 * f.a2
    )
    weight = p.mass4 * com4_th + p.mass5 * com5_th + p.mass6 * com6_th
    spring = p.stiffness * (p.preload + p.length - length)
    return (-spring * s_th - p.gravity * weight.imag - r) / A


@compiled
def accelerate(p: Planar, t: float, th: float, w: float) -> float:
    """Jaw acceleration in flight at a time from touch [rad/s^2]."""
    return acceleration(p, frame(p, t), th, w)


def jaw_equation(p: Planar) -> Callable[[float, float, float], float]:
    """Bind the numbers to the compiled equation, so that a call from Python passes three floats.

    Returns:
        Jaw acceleration [rad/s^2] of the time from touch [s], jaw angle [rad] and rate [rad/s].
    """

    @compiled
    def equation(t: float, th: float, w: float) -> float:
        return accelerate(p, t, th, w)

    equation(0.0, 0.0, 1.0)
    return equation


def shaft_accelerations(p: Planar) -> Callable[[float], tuple[float, float]]:
    """Bind the numbers to the drive laws.

    Returns:
        Accelerations of pendulum and tension shaft [rad/s^2] of the time from touch [s].
    """

    @compiled
    def law(t: float) -> tuple[float, float]:
        a = guide(p, t)[2]
        return a, p.gear * a

    law(0.0)
    return law
