"""The numbers of the hand-derived equation, read from a loaded mechanism."""

from __future__ import annotations

import cmath

import numpy as np

from nipper_pin.errors import InputError
from nipper_pin.mechanism import Mechanism, rad_s_from_rpm
from nipper_pin.mechanism.drives import Geared, OscillatingGuide

from ..stress.mechanics.planar_tree import PlanarTree
from .planar import Planar, cross, dot, frame

_JOINTS = ("pendulum_shaft", "nipper_pivot", "rocker_pin", "jaw", "rod_pin", "steeve",
           "tension_shaft")  # fmt: skip
_FRAMES = ("cylinder_axis", "eccentric_pin")


def e62_laws(mechanism: Mechanism) -> tuple[OscillatingGuide, Geared] | None:
    """Drive laws of both shafts, if the mechanism is an E62 in all but its numbers."""
    names = tuple(joint.name for joint in mechanism.joints)
    laws = {drive.name: drive.law for drive in mechanism.drives}
    pendulum, gears = laws.get("pendulum"), laws.get("tension")
    if (
        set(names) != set(_JOINTS)
        or not isinstance(pendulum, OscillatingGuide)
        or not isinstance(gears, Geared)
        or pendulum.guide_offset_m != 0.0
        or any(joint.sense < 0.0 for joint in mechanism.joints)
        or [spring.index for spring in mechanism.springs] != [names.index("steeve")]
    ):
        return None
    return pendulum, gears


def planar_model(mechanism: Mechanism, speed_rpm: float) -> Planar:
    """Read the numbers of the equation.

    Raises:
        InputError: The mechanism has not the joints and drives of the E62.
    """
    laws = e62_laws(mechanism)
    if laws is None:
        message = (
            f"the hand-derived equation is that of the E62; {mechanism.name!r} has other joints, "
            "drives or springs"
        )
        joints = [joint.name for joint in mechanism.joints]
        raise InputError(message, joints=joints, drives=[item.name for item in mechanism.drives])
    (pendulum, gears), cylinder = laws, mechanism.cylinder
    tree = PlanarTree.of(mechanism)
    touch = tree.motion(*np.zeros((3, tree.nv)))
    places = dict(zip((link.joint for link in tree.links), touch.origin.tolist(), strict=True))
    shaft, E, R, J, H, _, S = (places[name] for name in _JOINTS)
    rocker_axis, X = touch.points([tree.frames[name] for name in _FRAMES])[0].tolist()
    bodies = dict(zip(places, zip(tree.links, touch.com.tolist(), strict=True), strict=True))
    (b4, c4), (b6, c6), (b5, c5) = (bodies[name] for name in ("jaw", "rod_pin", "steeve"))
    crank_axis, guide_axis = complex(*pendulum.crank_axis), complex(*pendulum.guide_axis)
    psi = cylinder.angle_at_touch_rad
    pin = crank_axis + pendulum.crank_radius_m * cmath.exp(1j * psi) - guide_axis
    u = (X - H) / abs(X - H)
    spring = mechanism.springs[0]
    return Planar(
        psi_touch=psi,
        psi_rate=cylinder.sense * rad_s_from_rpm(speed_rpm),
        crank_axis=crank_axis,
        crank_radius=pendulum.crank_radius_m,
        guide_axis=guide_axis,
        guide_touch=pin / abs(pin),
        gear=gears.ratio,
        rocker_axis=rocker_axis,
        shaft=shaft,
        arm=E - shaft,
        coupler=R - E,
        rocker2=abs(R - rocker_axis) ** 2,
        coupler2=abs(R - E) ** 2,
        rocker_side=1.0 if ((R - rocker_axis) / (E - rocker_axis)).imag > 0.0 else -1.0,
        pivot=J - E,
        rod=H - J,
        com4=c4 - J,
        tension=S,
        eccentricity=X - S,
        length=abs(X - H),
        com5=(c5 - X) / u,
        com6=(c6 - H) / u,
        mass4=b4.mass,
        mass5=b5.mass,
        mass6=b6.mass,
        inertia4=b4.inertia,
        inertia56=b5.inertia + b6.inertia,
        stiffness=spring.stiffness,
        preload=spring.preload,
        gravity=mechanism.gravity_m_s2,
        restitution=mechanism.stop(mechanism.transition_stop).restitution,
    )


def first_rebound_rate(p: Planar) -> float:
    """Jaw rate after the first collision [rad/s].

    Before it the steeve stands on its stop: L' = u . (X' - H') = 0 gives the approach rate.
    """
    f = frame(p, 0.0)
    H = f.u2 * p.rod
    u = (f.X - f.J - H) / p.length
    # H' = J' + i (w2 + th') H, and u . i H = cross(H, u).
    approach = dot(u, f.Xv - f.Jv) / cross(H, u) - f.w2
    return -p.restitution * approach
