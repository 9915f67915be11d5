"""The state in which a run starts, followed from the drawing along the drives."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from .dynamics import SINGULAR, Dynamics
from .verdict import Reason, Refusal

Array = np.ndarray
_STEPS = 90


def drawing(dynamics: Dynamics) -> Array:
    """Absolute coordinates at touch."""
    q = np.zeros(dynamics.size)
    q[: dynamics.bodies] = [
        value for x, z in dynamics.geometry.centres[1:] for value in (x, z, 0.0)
    ]
    return q


def placed(dynamics: Dynamics, coordinates: Mapping[str, float]) -> Array:
    """Absolute coordinates that belong to coordinates of the tree's joints."""
    machine = dynamics.machine
    angle = {0: 0.0}
    place = {0: np.zeros(2)}
    q = drawing(dynamics)
    for joint in machine.links.joints.values():
        x = coordinates.get(joint.name, 0.0)
        turn = angle[joint.parent]
        c, s = math.cos(turn), math.sin(turn)
        matrix = np.array([[c, -s], [s, c]])
        centre = dynamics.geometry.centres
        slid = joint.place - centre[joint.parent] + (0.0 if joint.hinge else x) * joint.direction
        pin = place[joint.parent] + matrix @ slid
        own = turn + (x if joint.hinge else 0.0)
        c, s = math.cos(own), math.sin(own)
        angle[joint.child] = own
        place[joint.child] = pin - np.array([[c, -s], [s, c]]) @ (joint.place - centre[joint.child])
        q[3 * (joint.child - 1) : 3 * joint.child] = (*place[joint.child], own)
    return q


def start(
    dynamics: Dynamics,
    coordinates: Mapping[str, float] | None = None,
    rates: Mapping[str, float] | None = None,
) -> tuple[Array, Array]:
    """Coordinates and rates at time zero, in the initial phase.

    Args:
        dynamics: The machine.
        coordinates: Where free coordinates start; without them the machine is followed from its
            drawing, and what is free stays as near to it as the constraints allow.
        rates: Their rates; without them as small as the constraints allow.
    """
    machine = dynamics.machine
    shut = [stop for stop in machine.stops if stop.name in machine.initial]
    shafts = dynamics.laws(np.array([0.0]))[:, 0]
    v = np.zeros(dynamics.size)
    if coordinates is not None:
        q = placed(dynamics, coordinates)
        v = _rates(dynamics, q, rates or {})
    else:
        q = _followed(dynamics, shut)
    if dynamics.shafts:
        q[dynamics.bodies :], v[dynamics.bodies :] = shafts[0], shafts[1]
        held = Dynamics(machine, dynamics.rate, dynamics.start, held=True)
        n = dynamics.bodies
        q[:n], v[:n] = held.project(0.0, q[:n], v[:n], shut)
    else:
        q, v = dynamics.project(0.0, q, v, shut)
    if dynamics.independence(q[None], shut) < SINGULAR:
        raise Refusal(Reason.SINGULAR, "the machine stands in a dead centre at the start")
    return q, v


def _rates(dynamics: Dynamics, q: Array, rates: Mapping[str, float]) -> Array:
    """Absolute rates that belong to rates of the tree's joints."""
    geometry, n = dynamics.geometry, dynamics.bodies
    rows = geometry.evaluate(q[None, :n], np.zeros((1, n))).jacobian[0]
    wanted = np.zeros(len(rows))
    kept = list(range(geometry.constraints))
    for number, name in enumerate(dynamics.machine.coordinates):
        if name in dynamics.machine.links.joints:
            kept.append(geometry.constraints + number)
            wanted[kept[-1]] = rates.get(name, 0.0)
    v = np.zeros(dynamics.size)
    v[:n] = np.linalg.lstsq(rows[kept], wanted[kept], rcond=None)[0]
    return v


def _followed(dynamics: Dynamics, shut: list) -> Array:
    """Follow the machine from its drawing to the angle of the start, and stops to their places."""
    machine = dynamics.machine
    held = Dynamics(machine, dynamics.rate, dynamics.start, held=True)
    travel = (dynamics.start - machine.touch) / dynamics.rate
    q = drawing(held)
    before = q
    nothing = np.zeros_like(q)
    for number in range(1, _STEPS + 1):
        share = number / _STEPS
        partly = [stop._replace(at=share * stop.at) for stop in shut]
        guess = 2.0 * q - before if number > 1 else q
        before = q
        q, _ = held.project(travel * (share - 1.0), guess, nothing, partly)
    return np.concatenate([q, np.zeros(dynamics.shafts)])
