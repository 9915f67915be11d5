"""The E62 nipper in the plane, solved in closed form: geometry, equation of motion, contact forces.

Nothing here comes from a multibody library. A point is a complex number x + i z in metres, a
rotation of a link from its touch configuration is a complex number of modulus one, angles are
counter-clockwise in the side view. Every quantity is a power series in time (``taylor.Series``), so
time derivatives are exact, and flights can be integrated to any precision.

Geometry. Cylinder axis O = 0, pendulum shaft B, tension shaft S, cylinder angle psi(t) = psi_0 -
Omega t (0 at the horizontal, falling). With the touch configuration marked by a zero:

* guide:        G = r e^{i psi} - B,              u1 = G / |G| / (G_0 / |G_0|),
* gear:         u7 = u1^2.2,
* arm:          E = B + (E_0 - B) u1              (pendulum to bottom nipper),
* rocker pin:   R = E (alpha + i beta), the intersection of two circles: |R| = l3, |R - E| = l2,
                alpha = (l3^2 - l2^2 + |E|^2) / (2 |E|^2),  beta = +- sqrt(l3^2 / |E|^2 - alpha^2),
* bottom:       u2 = (R - E) / (R_0 - E_0),       J = E + (J_0 - E_0) u2  (jaw pivot),
* eccentric:    X = S + (X_0 - S) u7,
* top nipper:   u4 = u2 e^{i th},                 H = J + (H_0 - J_0) u4  (rod pin),
* steeve:       D = X - H = L u,                  s = L_0 - L,  L_0 = |X_0 - H_0|.

Phase 1 (s = 0) asks for the jaw angle: H is the intersection of the circle about J with radius
h = |H_0 - J_0| and the circle about X with radius L_0; then th = arg(u4 / u2). Phase 2 is th = 0.

Motion. With psi(t) prescribed th is the only coordinate, and only links 4, 5, 6 move with it. With
c the centres of mass and w the angular velocities, kinetic energy T = 1/2 sum (m |c'|^2 + I w^2)
and potential V = 1/2 k (s_p + s)^2 + sum m g z. Because d/dt (dc/dth) = dc'/dth, Lagrange's
equation d/dt dT/dth' - dT/dth + dV/dth = lambda is the same as

    A th'' + r = Q + lambda_jaw + lambda_steeve ds/dth,
    A = sum (m |c_th|^2 + I w_th^2),   r = sum (m c_th . c'' + I w_th w')  at th'' = 0,
    Q = -k (s_p + s) ds/dth - g sum m Im c_th,

where a subscript th is a derivative at fixed time (equally, at fixed psi):

    H_th = i (H - J),  c4_th = i (c4 - J),  D_th = -H_th,
    ds/dth = u . H_th,   gamma_th = -(u x H_th) / L        (gamma: angle of the steeve),
    c6 = H + l6 u,  c5 = X - l5 u,   u_th = i u gamma_th.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from taylor import Number, Series, cross, dot

PARAMETERS: dict[str, str] = {
    "pendulum_shaft_x_mm": "-190.0",
    "pendulum_shaft_z_mm": "-20.0",
    "pendulum_to_nipper_x_mm": "-195.2",
    "pendulum_to_nipper_z_mm": "45.8",
    "nipper_to_rocker_x_mm": "-13.0",
    "nipper_to_rocker_z_mm": "89.5",
    "top_nipper_pivot_x_mm": "-72.6",
    "top_nipper_pivot_z_mm": "101.9",
    "top_nipper_to_rod_x_mm": "-23.6",
    "top_nipper_to_rod_z_mm": "99.6",
    "tension_shaft_x_mm": "-86.0",
    "tension_shaft_z_mm": "261.5",
    "jaw_contact_x_mm": "9.2",
    "jaw_contact_z_mm": "65.5",
    "eccentric_pin_x_mm": "-90.98782025129913",
    "eccentric_pin_z_mm": "261.8487823687206",
    "crank_radius_mm": "64.0",
    "cylinder_angle_at_touch_deg": "166.0",
    "gear_ratio": "2.2",
    "stiffness_N_per_m": "9000.0",
    "preload_length_mm": "11.0",
    "stop_restitution": "0.2",
    "jaw_restitution": "0.2",
    "gravity_m_s2": "9.81",
    "mass4_kg": "1.2",
    "mass5_kg": "0.2",
    "mass6_kg": "0.2",
    "com4_x_mm": "-26.1",
    "com4_z_mm": "102.7",
    "com5_from_eccentric_pin_mm": "30.0",
    "com6_from_rod_pin_mm": "40.0",
    "inertia4_kg_m2": "1.142e-3",
    "inertia5_kg_m2": "6.0e-5",
    "inertia6_kg_m2": "1.0666666666666667e-4",
    "speed_rpm": "450.0",
}
"""Numbers of the machine, as decimals. The cylinder turns clockwise, 9 degrees an index."""

FOREMOST_INDEX = 24
INDICES_PER_TURN = 40


@dataclass(frozen=True)
class Frame:
    """What the two drives prescribe, as series in time about one instant.

    Attributes:
        arm: rotation u1 of the pendulum arm from touch (modulus one).
        bottom: rotation u2 of the bottom nipper from touch (modulus one).
        bottom_rate: angular velocity of the bottom nipper, rad/s.
        pin: rocker pin R, m.
        elbow: pin E between the arm and the bottom nipper, m.
        pivot: jaw pivot J, m.
        eccentric: eccentric pin X, m.
    """

    arm: Series
    bottom: Series
    bottom_rate: Series
    pin: Series
    elbow: Series
    pivot: Series
    eccentric: Series


@dataclass(frozen=True)
class Motion:
    """The mechanism along a jaw motion, as series in time.

    Attributes:
        th: jaw angle, rad.
        stroke: s, m.
        stroke_rate: s', m/s.
        stroke_th: ds/dth, m/rad.
        inertia: A = d2T/dth'2, kg m2.
        bias: r, N m: inertia torque about th at th'' = 0.
        force: Q, N m: spring and gravity.
        rod: rod pin H, m.
        axis: direction u of the steeve.
    """

    th: Series
    stroke: Series
    stroke_rate: Series
    stroke_th: Series
    inertia: Series
    bias: Series
    force: Series
    rod: Series
    axis: Series


class Machine:
    """The nipper with its parameters in one mpmath context.

    Args:
        ctx: mpmath context; its working precision at construction time fixes the constants.
        changes: parameters (names of ``PARAMETERS``) that differ, as decimals.
    """

    def __init__(self, ctx: Any, changes: dict[str, str] | None = None) -> None:
        changes = changes or {}
        unknown = sorted(set(changes) - set(PARAMETERS))
        if unknown:
            message = f"unknown parameters {unknown}; known are {sorted(PARAMETERS)}"
            raise KeyError(message)
        self.ctx = ctx
        self.decimals = PARAMETERS | changes
        p = {name: ctx.mpf(value) for name, value in self.decimals.items()}
        milli = ctx.mpf(1) / 1000

        def point(name: str) -> Number:
            return ctx.mpc(p[name + "_x_mm"] * milli, p[name + "_z_mm"] * milli)

        self.radius = p["crank_radius_mm"] * milli
        self.shaft = point("pendulum_shaft")
        self.tension = point("tension_shaft")
        elbow0, pin0 = point("pendulum_to_nipper"), point("nipper_to_rocker")
        pivot0, rod0 = point("top_nipper_pivot"), point("top_nipper_to_rod")
        eccentric0 = point("eccentric_pin")
        self.arm = elbow0 - self.shaft
        self.coupler = pin0 - elbow0
        self.pivot_in_bottom = pivot0 - elbow0
        self.rod_in_top = rod0 - pivot0
        self.com4_in_top = point("com4") - pivot0
        self.eccentricity = eccentric0 - self.tension
        self.rocker_length = abs(pin0)
        self.steeve_length = abs(eccentric0 - rod0)
        self.lever = abs(point("jaw_contact") - pivot0)
        self.com5 = p["com5_from_eccentric_pin_mm"] * milli
        self.com6 = p["com6_from_rod_pin_mm"] * milli
        self.mass4, self.mass5, self.mass6 = p["mass4_kg"], p["mass5_kg"], p["mass6_kg"]
        self.inertia4, self.inertia56 = p["inertia4_kg_m2"], p["inertia5_kg_m2"]
        self.inertia56 = self.inertia56 + p["inertia6_kg_m2"]
        self.gear = p["gear_ratio"]
        self.stiffness = p["stiffness_N_per_m"]
        self.preload = p["preload_length_mm"] * milli
        self.gravity = p["gravity_m_s2"]
        self.jaw_restitution = p["jaw_restitution"]
        self.stop_restitution = p["stop_restitution"]
        self.speed = p["speed_rpm"] * 2 * ctx.pi / 60
        self.psi_touch = p["cylinder_angle_at_touch_deg"] * ctx.pi / 180
        guide0 = self.radius * ctx.expj(self.psi_touch) - self.shaft
        self.guide0 = guide0 / abs(guide0)
        # Which of the two circle intersections is the machine's.
        self.rocker_side = 1 if (pin0 / elbow0).imag > 0 else -1
        self.rod_side = 1 if ((rod0 - pivot0) / (eccentric0 - pivot0)).imag > 0 else -1

    def psi_foremost(self) -> Number:
        """Cylinder angle at index 24, rad: the guide touches the crank circle from below.

        The angle of the guide has its minimum arg(-B) - asin(r / |B|), and there the crank radius
        stands perpendicular to the guide: psi = that minimum - pi/2 (taken one turn up, so that
        the clockwise cylinder falls from it to the touch angle).
        """
        minimum = self.ctx.arg(-self.shaft) - self.ctx.asin(self.radius / abs(self.shaft))
        return minimum - self.ctx.pi / 2 + 2 * self.ctx.pi

    def index(self, psi: Number) -> Number:
        """Comber index of a cylinder angle: 24 at the foremost position, 40 to a turn."""
        turn = 2 * self.ctx.pi
        return FOREMOST_INDEX + INDICES_PER_TURN * (self.psi_foremost() - psi) / turn

    def frame(self, psi: Number) -> Frame:
        """Series of everything the drives prescribe, about the cylinder angle psi (rad)."""
        ctx = self.ctx
        crank0, rate = self.radius * ctx.expj(psi), ctx.mpc(0, -1) * self.speed
        crank = Series(ctx, (crank0,))
        crank._rule = lambda k: crank.coefficients[k - 1] * rate / k
        guide = crank - self.shaft
        arm = guide / dot(guide, guide).sqrt() * (1 / self.guide0)
        gear = arm.power(self.gear, ctx.expj(self.gear * ctx.arg(arm[0])))
        elbow = arm * self.arm + self.shaft
        distance2 = dot(elbow, elbow)
        one = Series(ctx, (ctx.one,))
        rocker2, coupler2 = self.rocker_length**2, abs(self.coupler) ** 2
        alpha = (distance2 + (rocker2 - coupler2)) / (distance2 * 2)
        beta = (one * rocker2 / distance2 - alpha * alpha).sqrt() * self.rocker_side
        pin = elbow * (alpha + beta * ctx.mpc(0, 1))
        bottom = (pin - elbow) * (1 / self.coupler)
        return Frame(
            arm=arm,
            bottom=bottom,
            bottom_rate=cross(bottom, bottom.derivative()),
            pin=pin,
            elbow=elbow,
            pivot=elbow + bottom * self.pivot_in_bottom,
            eccentric=gear * self.eccentricity + self.tension,
        )

    def jaw_on_stop_in_phase_1(self, frame: Frame) -> Series:
        """Phase 1: the jaw angle th(t) that keeps s = 0, in closed form."""
        ctx = self.ctx
        base = frame.eccentric - frame.pivot
        distance2 = dot(base, base)
        one = Series(ctx, (ctx.one,))
        h2, l2 = abs(self.rod_in_top) ** 2, self.steeve_length**2
        alpha = (distance2 + (h2 - l2)) / (distance2 * 2)
        beta = (one * h2 / distance2 - alpha * alpha).sqrt() * self.rod_side
        top = base * (alpha + beta * ctx.mpc(0, 1)) * (1 / self.rod_in_top)
        turn = top * frame.bottom.conj()
        rate = cross(turn, turn.derivative())
        return Series(ctx, (ctx.arg(turn[0]),), lambda k: rate[k - 1] / k)

    def along(self, frame: Frame, th: Series) -> Motion:
        """Kinematics and the terms of the equation of motion along a jaw motion th(t).

        No term uses th'': the coefficient k of every result needs those of th up to k + 1 only.
        """
        ctx, i = self.ctx, self.ctx.mpc(0, 1)
        th_rate = th.derivative()
        turn = th.turn(ctx.expj(th[0]))
        top = frame.bottom * turn
        rate4 = frame.bottom_rate + th_rate
        swing4 = frame.bottom_rate.derivative()
        spin = swing4 * i - rate4 * rate4
        pivot_rate = frame.pivot.derivative()
        pivot_acc = pivot_rate.derivative()
        eccentric_rate = frame.eccentric.derivative()
        eccentric_acc = eccentric_rate.derivative()

        arm_h, arm_c = top * self.rod_in_top, top * self.com4_in_top
        rod = frame.pivot + arm_h
        rod_rate = pivot_rate + arm_h * rate4 * i
        rod_acc = pivot_acc + arm_h * spin
        com4_acc = pivot_acc + arm_c * spin

        steeve = frame.eccentric - rod
        steeve_rate = eccentric_rate - rod_rate
        steeve_acc = eccentric_acc - rod_acc
        length = dot(steeve, steeve).sqrt()
        axis = steeve / length
        length_rate = dot(axis, steeve_rate)
        gamma_rate = cross(axis, steeve_rate) / length
        gamma_acc = (cross(axis, steeve_acc) - length_rate * gamma_rate * 2) / length
        # Second derivative of the unit vector u.
        axis_acc = axis * (gamma_acc * i - gamma_rate * gamma_rate)
        com6_acc = rod_acc + axis_acc * self.com6
        com5_acc = eccentric_acc - axis_acc * self.com5

        rod_th, com4_th = arm_h * i, arm_c * i
        stroke_th = dot(axis, rod_th)
        gamma_th = -(cross(axis, rod_th) / length)
        axis_th = axis * gamma_th * i
        com6_th = rod_th + axis_th * self.com6
        com5_th = axis_th * (-self.com5)
        stroke = self.steeve_length - length

        inertia = (
            dot(com4_th, com4_th) * self.mass4
            + dot(com5_th, com5_th) * self.mass5
            + dot(com6_th, com6_th) * self.mass6
            + gamma_th * gamma_th * self.inertia56
            + self.inertia4
        )
        bias = (
            dot(com4_th, com4_acc) * self.mass4
            + dot(com5_th, com5_acc) * self.mass5
            + dot(com6_th, com6_acc) * self.mass6
            + gamma_th * gamma_acc * self.inertia56
            + swing4 * self.inertia4
        )
        weight = com4_th * self.mass4 + com5_th * self.mass5 + com6_th * self.mass6
        force = (stroke + self.preload) * stroke_th * (-self.stiffness)
        force = force - weight.imag * self.gravity
        return Motion(
            th=th,
            stroke=stroke,
            stroke_rate=-length_rate,
            stroke_th=stroke_th,
            inertia=inertia,
            bias=bias,
            force=force,
            rod=rod,
            axis=axis,
        )

    def flight(self, frame: Frame, th0: Number, rate0: Number) -> Motion:
        """Both stops open: th'' = (Q - r) / A from th0 (rad) and rate0 (rad/s)."""
        th = Series(self.ctx, (th0, rate0))
        motion = self.along(frame, th)
        acceleration = (motion.force - motion.bias) / motion.inertia
        th._rule = lambda k: acceleration[k - 2] / (k * (k - 1))
        return motion

    def phase1(self, frame: Frame) -> tuple[Motion, Series]:
        """Steeve on its stop: the motion and the stop force lambda_steeve in N (>= 0 holds)."""
        motion = self.along(frame, self.jaw_on_stop_in_phase_1(frame))
        acceleration = motion.th.derivative().derivative()
        torque = motion.inertia * acceleration + motion.bias - motion.force
        return motion, torque / motion.stroke_th

    def phase2(self, frame: Frame) -> tuple[Motion, Series]:
        """Jaw closed: the motion and the jaw torque lambda_jaw in N m (>= 0 holds)."""
        motion = self.along(frame, Series(self.ctx, (self.ctx.zero,)))
        return motion, motion.bias - motion.force
