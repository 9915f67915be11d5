"""The jaw as one degree of freedom, derived by hand for this eight-bar: what the drives prescribe.

Points are complex numbers x + i z [m], turns from the touch configuration complex numbers of
modulus one. Both shafts are prescribed by the cylinder angle psi(t), so the jaw angle th is the
only coordinate; with bottom nipper u2, jaw pivot J, eccentric pin X, rod pin
H = J + rod u2 e^{i th} and steeve X - H = L u (stroke s = L_0 - L), Lagrange's equation reads

    A th'' + r = Q,   A = sum m |c_th|^2 + I w_th^2,   r = sum m c_th . c'' + I w_th w' at th'' = 0,
    Q = -k (p + s) ds/dth - g sum m Im c_th

over links 4, 5 and 6, the only ones that th moves (c centres of mass, w angular rates, subscript
th: derivative at fixed time). ``frame`` is what depends on time alone, so that a method may use it
again where it evaluates twice at one time. All this is the work of a user of an ODE solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compile in double precision; not cached, for a cache misses changes of imported functions."""
    return cast("F", numba.njit(error_model="numpy")(function))


class Planar(NamedTuple):
    """Numbers of the equation; points [m], angles [rad], the rest in SI units (planar_model)."""

    psi_touch: float
    psi_rate: float
    crank_axis: complex
    crank_radius: float
    guide_axis: complex
    guide_touch: complex
    gear: float
    rocker_axis: complex
    shaft: complex
    arm: complex
    coupler: complex
    rocker2: float
    coupler2: float
    rocker_side: float
    pivot: complex
    rod: complex
    com4: complex
    tension: complex
    eccentricity: complex
    length: float
    com5: complex
    com6: complex
    mass4: float
    mass5: float
    mass6: float
    inertia4: float
    inertia56: float
    stiffness: float
    preload: float
    gravity: float
    restitution: float


class Frame(NamedTuple):
    """Prescribed motion at one time; the suffixes v and a denote derivatives by time."""

    u2: complex
    w2: float
    a2: float
    J: complex
    Jv: complex
    Ja: complex
    X: complex
    Xv: complex
    Xa: complex


@compiled
def dot(a: complex, b: complex) -> float:
    """Scalar product."""
    return a.real * b.real + a.imag * b.imag


@compiled
def cross(a: complex, b: complex) -> float:
    """Component of the vector product along the axis of the angles."""
    return a.real * b.imag - a.imag * b.real


@compiled
def guide(p: Planar, t: float) -> tuple[complex, float, float]:
    """Pendulum shaft at a time from touch: turn, angular rate [rad/s] and acceleration [rad/s^2].

    The pin of the crank, seen from the guide's axis, has the direction of the guide.
    """
    psi = p.psi_touch + p.psi_rate * t
    crank = p.crank_radius * complex(math.cos(psi), math.sin(psi))
    bar = p.crank_axis + crank - p.guide_axis
    bar_v = 1j * p.psi_rate * crank
    square = dot(bar, bar)
    w1 = cross(bar, bar_v) / square
    # The crank pin's acceleration is -psi_rate^2 crank.
    a1 = -(p.psi_rate**2 * cross(bar, crank) + 2.0 * dot(bar, bar_v) * w1) / square
    return bar / math.sqrt(square) / p.guide_touch, w1, a1


@compiled
def frame(p: Planar, t: float) -> Frame:
    """Evaluate everything that depends on time from the touch configuration [s] alone."""
    u1, w1, a1 = guide(p, t)
    turn = p.gear * math.atan2(u1.imag, u1.real)
    w7, a7 = p.gear * w1, p.gear * a1
    arm = p.arm * u1
    E = p.shaft - p.rocker_axis + arm
    E_v, E_a = 1j * w1 * arm, complex(-w1 * w1, a1) * arm
    # The rocker pin is on two circles: rocker2 about the rocker axis, coupler2 about E.
    E2 = dot(E, E)
    alpha = 0.5 * (p.rocker2 - p.coupler2 + E2) / E2
    R = E * complex(alpha, p.rocker_side * math.sqrt(p.rocker2 / E2 - alpha * alpha))
    bar = R - E
    along = cross(bar, R)
    w2 = -dot(E_v, R) / along
    R_v = E_v + 1j * w2 * bar
    a2 = -(dot(R_v, R_v) + dot(E_a - w2 * w2 * bar, R)) / along
    u2 = bar / p.coupler
    J = p.pivot * u2
    X = p.eccentricity * complex(math.cos(turn), math.sin(turn))
    return Frame(
        u2,
        w2,
        a2,
        p.rocker_axis + E + J,
        E_v + 1j * w2 * J,
        E_a + complex(-w2 * w2, a2) * J,
        p.tension + X,
        1j * w7 * X,
        complex(-w7 * w7, a7) * X,
    )


@compiled
def acceleration(p: Planar, f: Frame, th: float, w: float) -> float:
    """Jaw acceleration in flight [rad/s^2], of jaw angle [rad] and rate [rad/s] in a frame."""
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


def jaw_equation(p: Planar) -> Callable[[float, float, float], float]:
    """Jaw acceleration [rad/s^2] of the time from touch [s], jaw angle [rad] and rate [rad/s]."""

    @compiled
    def equation(t: float, th: float, w: float) -> float:
        return acceleration(p, frame(p, t), th, w)

    equation(0.0, 0.0, 1.0)
    return equation


def shaft_accelerations(p: Planar) -> Callable[[float], tuple[float, float]]:
    """Accelerations of pendulum and tension shaft [rad/s^2] of the time from touch [s]."""

    @compiled
    def law(t: float) -> tuple[float, float]:
        a = guide(p, t)[2]
        return a, p.gear * a

    law(0.0)
    return law
