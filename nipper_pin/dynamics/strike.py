"""Impacts at several stops: each part of the machine by itself, by the law of the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..arrays import FloatArray
from ..errors import ImpactError
from ..mechanism import Simultaneous, Stop
from .impact import Impact, collide, no_impact
from .sequence import MOST_STRIKES, in_sequence
from .system import System


def strike(
    system: System,
    q: FloatArray,
    v: FloatArray,
    jacobian: FloatArray,
    contacts: Sequence[Stop],
    law: Simultaneous | None = None,
    most: int = MOST_STRIKES,
) -> Impact:
    """Return the impact of the stops in contact.

    Args:
        q: Configuration, shape (nv,).
        v: Velocity before, G v = 0, shape (nv,).
        jacobian: Closure Jacobian G at q, shape (m, nv).
        contacts: Stops with zero gap: the colliding ones and those that touch.
        law: Law of contacts that share a motion; by default that of the mechanism.
        most: Number of strikes from contact to contact at which to give up.

    Raises:
        ImpactError: No impulses satisfy the law.
    """
    law = law or system.mechanism.simultaneous
    if system.whole and law == "newton":
        restitution = [stop.coefficient(stop.rate(v)) for stop in contacts]
        return collide(system, q, v, jacobian, contacts, restitution)
    none, part = no_impact(system, v.copy()), system.parts
    v_after, delta, P_g, lost = none.v_after, none.delta, none.P_g, 0.0
    P_N: dict[str, float] = {}
    for group in system.apart(contacts):
        own = _of_part(system, q, v, jacobian, group, law, most)
        # Round-off in a part that the impact does not reach is none of it.
        mine = part == part[group[0].index]
        v_after[mine], delta[mine] = own.v_after[mine], own.delta[mine]
        P_g, lost = P_g + own.P_g, lost + own.energy_lost
        P_N |= own.P_N
    return Impact(v_after, delta, P_g, {stop.name: P_N[stop.name] for stop in contacts}, lost)


def same_by_every_law(
    v: FloatArray, v_after: FloatArray, contacts: Sequence[Stop], P_N: Mapping[str, float]
) -> bool:
    """Whether one contact alone approached and took the impulse, and none approaches then.

    Args:
        v: Velocity before, shape (nv,).
        v_after: Velocity after, shape (nv,).
        P_N: Their impulses, by name.
    """
    approaching = sum(stop.rate(v) < 0.0 for stop in contacts)
    struck = sum(P_N[stop.name] > 0.0 for stop in contacts)
    return approaching < 2 and struck < 2 and min(stop.rate(v_after) for stop in contacts) >= 0.0


def _of_part(
    system: System,
    q: FloatArray,
    v: FloatArray,
    jacobian: FloatArray,
    contacts: Sequence[Stop],
    law: Simultaneous,
    most: int,
) -> Impact:
    """The impact of contacts that share a motion."""
    restitution = [stop.coefficient(stop.rate(v)) for stop in contacts]
    if law == "newton":
        return collide(system, q, v, jacobian, contacts, restitution)
    try:
        at_once = collide(system, q, v, jacobian, contacts, restitution)
    except ImpactError:
        return in_sequence(system, q, v, jacobian, contacts, most)
    if same_by_every_law(v, at_once.v_after, contacts, at_once.P_N):
        return at_once
    return in_sequence(system, q, v, jacobian, contacts, most)
