"""The numbers of the hand-derived equation, read from a loaded mechanism."""

from __future__ import annotations

import cmath

from nipper_pin.arrays import FloatArray
from nipper_pin.errors import InputError
from nipper_pin.mechanism import Mechanism, rad_s_from_rpm
from nipper_pin.mechanism.build.placements import joint_placements
from nipper_pin.mechanism.drives import Geared, OscillatingGuide

from .planar import Planar, cross, dot, frame

_JOINTS = ("pendulum_shaft", "nipper_pivot", "rocker_pin", "jaw", "rod_pin", "steeve",
           "tension_shaft")  # fmt: skip
_FRAMES = ("cylinder_axis", "eccentric_pin")


def _point(vector: FloatArray) -> complex:
    """Side view of a point: x + i z."""
    return complex(vector[0], vector[2])


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


def _points(mechanism: Mechanism) -> dict[str, complex]:
    """Points at the touch by joint or frame [m]."""
    model, placements = mechanism.model, joint_placements(mechanism.model)
    found = {name: _point(placements[model.getJointId(name)].translation) for name in _JOINTS}
    for name in _FRAMES:
        frame = model.frames[model.getFrameId(name)]
        found[name] = _point((placements[frame.parentJoint] * frame.placement).translation)
    return found


def _body(mechanism: Mechanism, joint: str) -> tuple[float, complex, float]:
    """Mass [kg], centre of mass [m], inertia about it [kg m^2]."""
    identity = mechanism.model.getJointId(joint)
    inertia = mechanism.model.inertias[identity]
    centre = joint_placements(mechanism.model)[identity].act(inertia.lever)
    return float(inertia.mass), _point(centre), float(inertia.inertia[1, 1])


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
    shaft, E, R, J, H, _, S, rocker_axis, X = _points(mechanism).values()
    (m4, c4, I4), (m6, c6, I6), (m5, c5, I5) = (
        _body(mechanism, name) for name in ("jaw", "rod_pin", "steeve")
    )
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
        mass4=m4,
        mass5=m5,
        mass6=m6,
        inertia4=I4,
        inertia56=I5 + I6,
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
