"""The mechanism in Exudyn: seven planar bodies, joints and prescribed shafts."""

from __future__ import annotations

import math
from typing import Any

import exudyn
import numpy as np
from exudyn import itemInterface as items  # noqa: N813

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import Mechanism
from nipper_pin.mechanism.build.placements import joint_placements
from nipper_pin.study.paper.scheme.planar import Planar, compiled, guide

from .planar_bodies import BODIES

_JOINTS = ((-1, 0), (0, 1), (1, 2), (1, 3), (3, 4), (-1, 6), (2, -1), (5, 6))
"""Pairs of bodies (-1: ground) pinned to each other."""


def build(mechanism: Mechanism, p: Planar) -> tuple[Any, Any]:
    """Build the system.

    Args:
        mechanism: The E62, or another set of numbers for it.
        p: Its planar numbers, for the drives.

    Returns:
        The system container (to be kept alive) and the assembled main system.
    """
    model, placements = mechanism.model, joint_placements(mechanism.model)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    numbers, nodes, origins = [], [], []
    for name in BODIES:
        identity = model.getJointId(name)
        inertia, origin = model.inertias[identity], placements[identity].translation[[0, 2]]
        m, c = float(inertia.mass), inertia.lever[[0, 2]]
        node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*origin, 0.0]))
        body = items.ObjectRigidBody2D(
            physicsMass=m, physicsInertia=float(inertia.inertia[1, 1] + m * c @ c),
            physicsCenterOfMass=list(c), nodeNumber=node,
        )  # fmt: skip
        numbers.append(mbs.AddObject(body))
        nodes.append(node)
        origins.append(origin)
        load = [0.0, -mechanism.gravity_m_s2 * m, 0.0]
        place = mbs.AddMarker(items.MarkerBodyPosition(
            bodyNumber=numbers[-1], localPosition=[*c, 0.0]))  # fmt: skip
        mbs.AddLoad(items.LoadForceVector(markerNumber=place, loadVector=load))

    def marker(body: int, point: FloatArray) -> int:
        """Marker of a body (-1: ground) at a point of the touch configuration."""
        local = [*(point - origins[body]), 0.0] if body >= 0 else [*point, 0.0]
        number = numbers[body] if body >= 0 else ground
        return int(mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=number, localPosition=local)))

    axis = np.array([p.rocker_axis.real, p.rocker_axis.imag])
    for one, two in _JOINTS:
        # A pin stands where the tree has the joint to its later body; the two cut pins apart.
        point = axis if (one, two) == (2, -1) else origins[5 if one == 5 else two]
        pair = [marker(one, point), marker(two, point)]
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=pair))
    rod, pin = origins[4], origins[5]
    along = (pin - rod) / p.length
    lower, upper = (
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=numbers[body], localPosition=[0.0] * 3))
        for body in (4, 5)
    )
    mbs.AddObject(items.ObjectJointPrismatic2D(
        markerNumbers=[lower, upper], axisMarker0=[*along, 0.0],
        normalMarker1=[-along[1], along[0], 0.0]))  # fmt: skip
    mbs.AddObject(items.ObjectConnectorSpringDamper(
        markerNumbers=[marker(4, rod), marker(5, pin)], stiffness=p.stiffness,
        referenceLength=p.length + p.preload))  # fmt: skip
    fixed = mbs.AddNode(items.NodePointGround())
    still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))
    for body, ratio in ((0, 1.0), (6, p.gear)):
        turned = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[body], coordinate=2))
        angle, rate = _law(p, ratio)
        mbs.AddObject(items.ObjectConnectorCoordinate(
            markerNumbers=[still, turned], offsetUserFunction=angle,
            offsetUserFunction_t=rate))  # fmt: skip
    mbs.Assemble()
    return container, mbs


def _law(p: Planar, ratio: float) -> tuple[Any, Any]:
    """Angle and rate of a shaft, in the signature that Exudyn calls."""

    @compiled
    def shaft(t: float) -> tuple[float, float]:
        u1, w1, _ = guide(p, t)
        return ratio * math.atan2(u1.imag, u1.real), ratio * w1

    def angle(_mbs: object, t: float, _item: int, _offset: float) -> float:
        return shaft(t)[0]

    def rate(_mbs: object, t: float, _item: int, _offset: float) -> float:
        return shaft(t)[1]

    return angle, rate
