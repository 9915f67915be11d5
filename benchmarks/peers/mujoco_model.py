"""The mechanism in MuJoCo: the same tree, its loops closed by ``connect``, its shafts driven.

Two settings matter. A driven joint gets an armature that nothing can shake and the force armature
times the acceleration of its law. And MuJoCo's constraints are soft by the ratio (1 - d) / d times
an estimate of the bodies' inverse inertia, with d limited to 0.9999: an error of 1e-4 in the
accelerations. The estimate is a field of the compiled model; scaled down, it makes them hard.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism

from ..tolerances import HARD_CONSTRAINT

SHAFT_INERTIA = 1e10
# 3 iterations of Newton's method solve a problem without inequalities to round-off.
_OPTIONS = {"iterations": "3", "tolerance": "0", "jacobian": "dense", "solver": "Newton"}
_IMPEDANCE = "0.9999 0.9999 0.001 0.5 2"


def mjcf(mechanism: Mechanism) -> str:
    """Write a planar mechanism as an MJCF document, without its stops."""
    model = mechanism.model
    root = Element("mujoco")
    SubElement(root, "compiler", angle="radian")
    gravity = f"0 0 {-mechanism.gravity_m_s2!r}"
    option = SubElement(root, "option", _OPTIONS, integrator="RK4", gravity=gravity)
    SubElement(option, "flag", contact="disable", refsafe="disable")
    bodies = {0: SubElement(root, "worldbody")}
    driven = {drive.index for drive in mechanism.drives}
    for identity in range(1, model.njoints):
        name, index = model.names[identity], model.joints[identity].idx_v
        place = _row(model.jointPlacements[identity].translation)
        body = SubElement(bodies[model.parents[identity]], "body", name=name, pos=place)
        bodies[identity] = body
        inertia = model.inertias[identity]
        entries = inertia.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        SubElement(body, "inertial", pos=_row(inertia.lever), mass=repr(float(inertia.mass)),
                   fullinertia=_row(entries))  # fmt: skip
        axis = model.joints[identity].createData().S.ravel()
        slides = mechanism.joints[index].kind == "prismatic"
        joint = SubElement(body, "joint", name=name, type="slide" if slides else "hinge",
                           axis=_row(axis[:3] if slides else axis[3:]))  # fmt: skip
        if index in driven:
            joint.set("armature", repr(SHAFT_INERTIA))
        springs = [spring for spring in mechanism.springs if spring.index == index]
        if stiffness := sum(spring.stiffness for spring in springs):
            force = sum(spring.stiffness * spring.preload for spring in springs)
            joint.set("stiffness", repr(stiffness))
            joint.set("springref", repr(-force / stiffness))
    equality = SubElement(root, "equality")
    for closure in mechanism.closures:
        a, b = (model.frames[model.getFrameId(n)] for n in (closure.frame_a, closure.frame_b))
        one, two = (model.names[f.parentJoint] if f.parentJoint else "world" for f in (a, b))
        SubElement(equality, "connect", body1=one, body2=two, solimp=_IMPEDANCE, solref="0.02 1",
                   anchor=_row(a.placement.translation))  # fmt: skip
    return tostring(root, encoding="unicode")


def _row(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def compile_model(document: str) -> mujoco.MjModel:
    """Compile a document and make its constraints hard."""
    model = mujoco.MjModel.from_xml_string(document)
    model.body_invweight0[:] *= HARD_CONSTRAINT
    model.dof_invweight0[:] *= HARD_CONSTRAINT
    return model


def rates(model: mujoco.MjModel, data: mujoco.MjData, given: dict[int, float]) -> FloatArray:
    """Rates of all joints that keep the loops closed, shape (nv,).

    Constraint rows of the data are those of the present configuration; as many rates are given, by
    place, as there are degrees of freedom.
    """
    # connect has three rows; the middle one is out of the plane, y.
    rows = 3 * model.neq
    J = data.efc_J.reshape(-1, model.nv)[:rows][np.arange(rows) % 3 != 1]
    v = np.zeros(model.nv)
    v[list(given)] = list(given.values())
    free = [index for index in range(model.nv) if index not in given]
    v[free] = np.linalg.solve(J[:, free], -(J @ v))
    return v


def touch_rates(
    model: mujoco.MjModel, data: mujoco.MjData, mechanism: Mechanism, psi_rate: float
) -> FloatArray:
    """Joint rates just before the first collision, steeve on its stop, shape (nv,)."""
    psi = np.array(mechanism.cylinder.angle_at_touch_rad)
    given = {drive.index: float(drive.law.evaluate(psi)[1]) * psi_rate
             for drive in mechanism.drives}  # fmt: skip
    mujoco.mj_forward(model, data)
    return rates(model, data, {**given, mechanism.stop("steeve").index: 0.0})
