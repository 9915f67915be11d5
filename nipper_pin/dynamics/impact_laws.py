"""Impacts at several stops: each part of the machine by itself, by the law of the model.

Before an impact G v = 0; contacts are stops with zero gap: the colliding ones and those that touch.
In sequence, impulses pass from contact to contact: the limit of small gaps between touching stops.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Jacobian, Vector
from ..errors import ImpactError
from ..mechanism import Simultaneous, Stop
from ..tolerances.hybrid import JAM_SLOWING
from ..tolerances.mechanics import EQUAL_APPROACH, STILL_GAP_RATE
from .complementarity import complementary, delassus, free_mass_matrix
from .impact import Impact, collide, no_impact
from .system import System

MOST_STRIKES = 1_000_000
"""Of one impact; a row of forty balls on a wall that stick together needs 600,000, in 4 s."""
# As many strikes that get no slower are a jam.
_JAM = 20_000


def sequential_impacts(
    system: System,
    q: Vector,
    v: FloatArray,
    jacobian: Jacobian,
    contacts: Sequence[Stop],
    most: int,
) -> Impact:
    """Strike one contact after the other, each as if it were alone, until none approaches.

    It is the turn of the contact whose approach has the largest energy; of equally fast ones all
    are struck together, so that no order of names counts and mirrored machines stay mirrored.

    Args:
        most: Strikes at which to give up.

    Returns:
        The sum of all strikes. A series that does not end has its limit: rates that have fallen to
        round-off of the first ones are zero.

    Raises:
        ImpactError: The strikes do not become slower, or too little for ``most`` of them.
    """
    before = np.array([stop.rate(v) for stop in contacts])
    matrix = delassus(system, q, jacobian, contacts)
    impulses, after = _struck(matrix, before, contacts, most)
    delta, closure_impulses = _response(system, q, jacobian, contacts, impulses)
    v_after = v + delta
    for stop, rate in zip(contacts, after.tolist(), strict=True):
        v_after[stop.index] = stop.sense * rate
    P_N = {stop.name: P for stop, P in zip(contacts, impulses.tolist(), strict=True)}
    lost = -0.5 * float(impulses @ (before + after))
    return Impact(v_after, delta, closure_impulses, P_N, lost)


def _struck(
    matrix: FloatArray, before: FloatArray, contacts: Sequence[Stop], most: int
) -> tuple[FloatArray, FloatArray]:
    """Impulses and gap rates after all strikes."""
    own = np.diag(matrix)
    with np.errstate(divide="ignore"):
        per_root = 1.0 / np.sqrt(own)
    rates, impulses = before.copy(), np.zeros(len(contacts))
    approach = -rates * per_root
    nothing = STILL_GAP_RATE * float(np.abs(approach).max())
    columns, responses = list(matrix.T.copy()), own.tolist()
    slowest = np.inf
    for number in range(most):
        first = int(approach.argmax())
        fastest = approach[first]
        if fastest <= nothing:
            rates[np.abs(approach) <= nothing] = 0.0
            return impulses, rates
        if number % _JAM == 0:
            if not fastest <= (1.0 - JAM_SLOWING) * slowest:
                break
            slowest = fastest
        if not responses[first] > 0.0:
            break
        if np.count_nonzero(approach >= (1.0 - EQUAL_APPROACH) * fastest) == 1:
            rate = float(rates[first])
            impulse = -(1.0 + contacts[first].coefficient(rate)) * rate / responses[first]
            impulses[first] += impulse
            rates += columns[first] * impulse
        else:
            given = _together(matrix, rates, contacts, approach >= (1.0 - EQUAL_APPROACH) * fastest)
            if given is None:
                break
            impulses += given
            rates += matrix @ given
        np.multiply(rates, -per_root, out=approach)
    names = ", ".join(stop.name for stop in contacts)
    message = (
        f"the impulses at {names} still pass to and fro after {number} strikes, which hardly "
        "become weaker: these stops jam the mechanism, or a body that is light beside its "
        "neighbours slows them down by next to nothing at each strike; give it room, let them lose "
        'more (restitution), make the masses more alike, or choose simultaneous = "newton"'
    )
    raise ImpactError(message, stops=names, rates_before=before.tolist(), strikes=number)


def _together(
    matrix: FloatArray, rates: FloatArray, contacts: Sequence[Stop], chosen: NDArray[np.bool_]
) -> FloatArray | None:
    """Impulses of contacts that are struck at the same time, by Newton's law."""
    places = np.flatnonzero(chosen).tolist()
    wanted = [(1.0 + contacts[i].coefficient(float(rates[i]))) * rates[i] for i in places]
    given = complementary(matrix[np.ix_(places, places)], np.array(wanted))
    if given is None:
        return None
    impulses = np.zeros(len(contacts))
    impulses[places] = given
    return impulses


def _response(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    contacts: Sequence[Stop],
    impulses: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Change of velocity and closure impulses that impulses at the contacts make."""
    pushed = np.zeros(system.body.nv)
    np.add.at(
        pushed,
        [stop.index for stop in contacts],
        impulses * [stop.sense for stop in contacts],
    )
    moving, mass = free_mass_matrix(system, q)
    delta = np.zeros(system.body.nv)
    delta[moving] = np.linalg.solve(mass, pushed[moving])
    if not len(jacobian):
        return delta, np.zeros(0)
    closed, closure_impulses = system.body.impulse_response(
        q, jacobian, delta, system.drive_armature
    )
    return delta + closed, closure_impulses


def solve_impact(
    system: System,
    q: Vector,
    v: FloatArray,
    jacobian: Jacobian,
    contacts: Sequence[Stop],
    law: Simultaneous | None = None,
    most: int = MOST_STRIKES,
) -> Impact:
    """Return the impact of the stops in contact.

    Args:
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
    """Whether one contact alone approached and took the impulse, and none approaches then."""
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
        return sequential_impacts(system, q, v, jacobian, contacts, most)
    if same_by_every_law(v, at_once.v_after, contacts, at_once.P_N):
        return at_once
    return sequential_impacts(system, q, v, jacobian, contacts, most)
