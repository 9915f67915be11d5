"""What round-off makes of accelerations: nothing finer can be resolved, nor need it be.

Near an equilibrium forces make up for one another, and what they leave is round-off. It changes
from state to state as noise does, so no polynomial fits it and no shorter panel holds less of it.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition, close_velocities
from ..dynamics.system import ConstraintSet, System

_EPS = float(np.finfo(float).eps)
NEARBY = 4.0
"""Round-off of a coordinate, and of a force, in units of its last digit."""


def roughness(
    system: System,
    rows: ConstraintSet,
    split: Partition,
    t: FloatArray,
    q: FloatArray,
    v: FloatArray,
) -> FloatArray:
    """Differences of accelerations between states and forces that are the same but for round-off.

    Args:
        system: The system.
        rows: The phase.
        split: Dependent and independent coordinates.
        t: Times [s], shape (N,).
        q: Configurations, shape (N, nv).
        v: Velocities, shape (N, nv).

    Returns:
        Not negative, shape (N, nv).
    """
    forcing = system.forcing(system.shaft.driven(t), rows)
    here = system.respond(forcing, q, v, rows)
    unsure = NEARBY * _EPS * (np.abs(forcing) + _terms(system, q, v))
    signs = (-1.0) ** np.arange(q.shape[1])
    moved = system.respond(forcing + signs * unsure, *nearby(system, q, v, split), rows)
    pushed = system.respond(forcing + unsure, q, v, rows)
    return np.asarray(np.maximum(np.abs(moved - here), np.abs(pushed - here)))


def _terms(system: System, q: FloatArray, v: FloatArray) -> FloatArray:
    """Size of the terms that generalised forces are sums of, shape (N, nv)."""
    body, mechanism = system.body, system.mechanism
    model, reach = mechanism.model, body.reach_m
    sizes = np.abs(system.applied_forces(q, v))
    places = [model.getJointId(joint.name) for joint in mechanism.joints]
    links = [model.inertias[place] for place in places]
    masses = np.array([link.mass for link in links])
    turning = np.array([link.inertia[1, 1] for link in links])
    for size, *state in zip(sizes, q, v, strict=True):
        spin, centroid = body.link_velocities(*state)
        # Moments of weight, and of what turns evenly, are sums over links that may balance.
        energy = masses * np.einsum("li,li->l", centroid, centroid) + turning * spin**2
        pull = masses * abs(mechanism.gravity_m_s2) + energy / reach
        for joint, place in zip(mechanism.joints, places, strict=True):
            carried = [places.index(link) for link in model.subtrees[place]]
            lever = 1.0 if joint.kind == "prismatic" else reach
            size[joint.index] += lever * pull[carried].sum()
    return np.asarray(sizes)


def nearby(
    system: System, q: FloatArray, v: FloatArray, split: Partition
) -> tuple[FloatArray, FloatArray]:
    """The same states but for round-off: what moves between the two cannot be resolved.

    Dependent coordinates stand where the closures let them stand, and have the rates of that place:
    what the closures are open by near a dead centre makes itself felt there.

    Args:
        system: The system.
        q: Configurations, shape (N, nv).
        v: Velocities, shape (N, nv).
        split: Dependent and independent coordinates.

    Returns:
        q and v, shape (N, nv).
    """
    body, columns = system.body, split.columns
    signs = (-1.0) ** np.arange(body.nv)
    # The length of a strut is a difference of places.
    size = np.abs(q) + (body.reach_m if system.mechanism.struts else 0.0)
    q = q + NEARBY * _EPS * signs * size
    if columns.size:
        g, jacobian = body.closures(q)
        q[:, columns] -= np.linalg.solve(jacobian[:, :, columns], g[:, :, None])[:, :, 0]
        v = close_velocities(v, body.closures(q)[1], split)
    return q, v
