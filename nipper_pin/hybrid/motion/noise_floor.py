"""Noise of accelerations by round-off of forces, the limit of any resolution.

Near an equilibrium forces make up for one another, and what they leave is round-off. It changes
from state to state as noise does, so no polynomial fits it and no shorter panel holds less of it.
Positions are taken as they are: what closures near a dead centre make of their round-off is no such
noise, but accuracy that is lost.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Vector
from ...dynamics import ConstraintSet, System
from ...tolerances.hybrid import COORDINATE_ROUND_OFF


def roughness(system: System, phase: ConstraintSet, t: float, q: Vector, v: Vector) -> FloatArray:
    """Largest differences of accelerations at t [s], forces the same but for round-off, (nv,)."""
    forcing = system.forcing(system.shaft.driven(np.array([t])), phase)[0]
    terms = np.abs(forcing) + _terms(system, q, v)
    unsure = COORDINATE_ROUND_OFF * terms + _of_lengths(system, q, v)
    # Signs that alternate, and signs that do not: links in a row are moved by the one or the other.
    signs = (-1.0) ** np.arange(len(q))
    pushed = forcing + np.stack([np.zeros_like(q), unsure, signs * unsure])
    a = system.respond(pushed, np.tile(q, (3, 1)), np.tile(v, (3, 1)), phase)
    of_forces = np.abs(a[1:] - a[0]).max(axis=0)
    return np.asarray(np.maximum(of_forces, of_closures(system, v, a[0])))


def of_closures(system: System, v: FloatArray, a: FloatArray) -> FloatArray:
    """Round-off that the closures leave in accelerations, shape (nv,); v and a of shape (..., nv).

    They add up accelerations a and centripetal ones v^2 of all links. A link that they hold still,
    or nearly so, has the round-off of the others.
    """
    if not system.body.closure_rows:
        return np.zeros(system.body.nv)
    largest = (system.turns(a) + system.turns(v) ** 2).max()
    return np.asarray(COORDINATE_ROUND_OFF * largest / system.turning)


def rates_of_closures(system: System, v: FloatArray) -> FloatArray:
    """Round-off that the closures leave in rates, shape (nv,); v of shape (..., nv)."""
    if not system.body.closure_rows:
        return np.zeros(system.body.nv)
    return np.asarray(COORDINATE_ROUND_OFF * system.turns(v).max() / system.turning)


def _of_lengths(system: System, q: FloatArray, v: FloatArray) -> FloatArray:
    """Round-off of the forces of struts, whose lengths are differences of places, shape (nv,)."""
    if not system.mechanism.struts:
        return np.zeros_like(q)
    signs = (-1.0) ** np.arange(len(q))
    moved = q + COORDINATE_ROUND_OFF * signs * (np.abs(q) + system.mechanism.extents)
    forces = system.applied_forces(np.stack([q, moved]), np.stack([v, v]))
    return np.asarray(np.abs(forces[1] - forces[0]))


def _terms(system: System, q: FloatArray, v: FloatArray) -> FloatArray:
    """Size of the terms that generalised forces are sums of, shape (nv,)."""
    body, mechanism = system.body, system.mechanism
    model, reach = mechanism.model, body.reach_m
    sizes = np.abs(system.applied_forces(q[None], v[None])[0])
    places = [model.getJointId(joint.name) for joint in mechanism.joints]
    links = [model.inertias[place] for place in places]
    masses = np.array([link.mass for link in links])
    turning = np.array([link.inertia[1, 1] for link in links])
    spin, centroid = body.link_velocities(q, v)
    # Moments of weight, and of what turns evenly, are sums over links that may balance.
    energy = masses * np.einsum("li,li->l", centroid, centroid) + turning * spin**2
    pull = masses * abs(mechanism.gravity_m_s2) + energy / reach
    for joint, place in zip(mechanism.joints, places, strict=True):
        carried = [places.index(link) for link in model.subtrees[place]]
        lever = 1.0 if joint.kind == "prismatic" else reach
        sizes[joint.index] += lever * pull[carried].sum()
    return np.asarray(sizes)
