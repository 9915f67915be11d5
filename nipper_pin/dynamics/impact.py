"""Newton's restitution with complementarity, on Pinocchio's impulse dynamics.

M (v+ - v-) = G' P_g + W' P_N, G v+ = 0, and for every stop in contact
xi_N = g_N_dot+ + e_N g_N_dot- >= 0, P_N >= 0, xi_N P_N = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..arrays import FloatArray, Jacobian, Vector, product
from ..errors import ImpactError
from ..mechanism import Stop
from ..tolerances.mechanics import (
    EPS,
    FAINT_GAP_RATE,
    IMPACT_RESIDUAL,
    MAX_IMPACT_RESIDUAL,
    RESTITUTION_SLACK,
    STILL_GAP_RATE,
)
from .complementarity import (
    complementary,
    delassus,
    free_mass_matrix,
    impact_condition,
    inverse_mass_roots,
)
from .system import System

_REFINEMENTS = 3
# Up to so many contacts all sets are tried: that is faster than pivoting.
_TRIED = 2


@dataclass(frozen=True, eq=False)
class Impact:
    """Outcome of one collision at one or more stops.

    Attributes:
        v_after: Velocity after, shape (nv,).
        delta: Change of velocity, to its own relative precision however small it is, shape (nv,).
        P_g: Closure impulses, shape (m,) [N s].
        P_N: Impulse of every stop in contact, by name, along its gap [N m s or N s].
        energy_lost: Kinetic energy lost at the stops [J].
    """

    v_after: FloatArray
    delta: FloatArray
    P_g: FloatArray
    P_N: dict[str, float]
    energy_lost: float


def collide(
    system: System,
    q: Vector,
    v: FloatArray,
    jacobian: Jacobian,
    contacts: Sequence[Stop],
    restitution: Sequence[float],
) -> Impact:
    """Apply Newton's law to stops in contact, all at once.

    Args:
        v: Velocity before, G v = 0, shape (nv,).
        contacts: Stops with zero gap: the colliding ones and those closed before.
        restitution: e_N of each.

    Returns:
        The impact: of two stops the first set, the smallest first, that satisfies the law; of more
        the one that pivoting finds.

    Raises:
        ImpactError: No set does: the stops jam the mechanism against its drives.
    """
    before = [stop.rate(v) for stop in contacts]
    wanted = [-e_N * rate for e_N, rate in zip(restitution, before, strict=True)]
    if min(before) >= 0.0:
        return _grazed(system, v, contacts)
    jumps = [after - rate for after, rate in zip(wanted, before, strict=True)]
    sets = [(0,)] if len(before) == 1 else _choices(system, q, jacobian, contacts, jumps)
    for chosen in sets:
        struck = [contacts[i] for i in chosen]
        solved = _impulses(system, q, jacobian, struck, [jumps[i] for i in chosen])
        if solved is None or min(solved[2].tolist()) < 0.0:
            continue
        still = _still(system, q, jacobian, v, contacts, chosen, wanted, solved[0])
        if still is not None:
            return _outcome(v, contacts, chosen, wanted, solved, still)
    names = ", ".join(stop.name for stop in contacts)
    message = (
        f"no impulses at {names} satisfy the impact law: these stops jam the mechanism against "
        "its drives; check their sides, or let the drives be inertial"
    )
    raise ImpactError(message, stops=names, rates_before=before)


def _choices(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    contacts: Sequence[Stop],
    jumps: Sequence[float],
) -> Iterator[tuple[int, ...]]:
    """Sets of the contacts that may be struck, the smallest first."""
    if len(contacts) <= _TRIED:
        for size in range(1, len(contacts) + 1):
            yield from combinations(range(len(contacts)), size)
        return
    matrix = delassus(system, q, jacobian, contacts)
    impulses = complementary(matrix, -np.array(jumps))
    if impulses is not None:
        shares = impulses * np.sqrt(np.diag(matrix))
        # An impulse that is only round-off may be none.
        for least in (RESTITUTION_SLACK * float(shares.max()), 0.0):
            yield tuple(np.flatnonzero(shares > least).tolist())


def closing_impulse(
    system: System,
    q: Vector,
    v: FloatArray,
    jacobian: Jacobian,
    stops: Sequence[Stop],
) -> Impact:
    """Bring the gap rates of stops to zero, as a bounce series does at its limit.

    Args:
        v: Velocity after the last collision that was computed, shape (nv,).
        stops: The stops that come to rest, and those that are closed all the while: the bounces
            left out do not open them.

    Returns:
        The change as an impact whose impulse, a negative one, is not a contact impulse: the
        bounces of the series push a stop by e w / (1 - e) against gravity and springs.

    Raises:
        ImpactError: They cannot come to rest together.
    """
    jumps = [-stop.rate(v) for stop in stops]
    solved = _impulses(system, q, jacobian, stops, jumps)
    if solved is None:
        names = ", ".join(stop.name for stop in stops)
        message = f"stop {names} cannot come to rest: the mechanism is in a dead centre"
        raise ImpactError(message, stops=names, rates_before=[-jump for jump in jumps])
    return _outcome(v, stops, range(len(stops)), [0.0] * len(stops), solved, ())


def _still(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    v: FloatArray,
    contacts: Sequence[Stop],
    chosen: Sequence[int],
    wanted: Sequence[float],
    delta: FloatArray,
) -> list[int] | None:
    """Return the contacts that stay closed beside an impact at others; None if one approaches.

    A contact that the impact does not move neither separates nor approaches by round-off.
    """
    if len(chosen) == len(contacts):
        return []
    others = [i for i in range(len(contacts)) if i not in chosen]
    # Rates of hinges and slides are compared, so each counts by the unit of its coordinate.
    units = [system.body.unit_of[stop.index] for stop in contacts]
    after = [(contacts[i].rate(v) + contacts[i].rate(delta)) / units[i] for i in others]
    # At active contacts xi is zero by construction, up to round-off.
    xi = [rate - wanted[i] / units[i] for i, rate in zip(others, after, strict=True)]
    fastest = max(abs(stop.rate(v)) / unit for stop, unit in zip(contacts, units, strict=True))
    nothing = [STILL_GAP_RATE * fastest] * len(others)
    smallest = [min(abs(rate), abs(excess)) for rate, excess in zip(after, xi, strict=True)]
    if any(STILL_GAP_RATE * fastest < small <= FAINT_GAP_RATE * fastest for small in smallest):
        struck, beside = ([contacts[i].index for i in group] for group in (chosen, others))
        unknown = _round_off(system, q, jacobian, delta, struck, beside)
        unknown = [found / units[i] for i, found in zip(others, unknown, strict=True)]
        nothing = [max(least, found) for least, found in zip(nothing, unknown, strict=True)]
    slack = RESTITUTION_SLACK * fastest
    if any(excess < -max(slack, least) for excess, least in zip(xi, nothing, strict=True)):
        return None
    found = zip(others, after, nothing, strict=True)
    return [contacts[i].index for i, rate, least in found if abs(rate) <= least]


def _round_off(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    delta: FloatArray,
    struck: Sequence[int],
    beside: Sequence[int],
) -> list[float]:
    """Round-off of gap rates beside an impact: for each the same share of its energy."""
    lost = EPS * impact_condition(system, q, jacobian, struck)
    moving, mass = free_mass_matrix(system, q)
    given = math.sqrt(delta[moving] @ mass @ delta[moving])
    return [lost * given * size for size in inverse_mass_roots(system, q, beside).tolist()]


def _grazed(system: System, v: FloatArray, contacts: Sequence[Stop]) -> Impact:
    """Contact without approach: no impulse; a rate that is only round-off is none."""
    v_after = v.copy()
    units = system.body.units
    small = STILL_GAP_RATE * float(np.abs(v / units).max())
    for stop in contacts:
        if stop.rate(v_after) <= small * units[stop.index]:
            v_after[stop.index] = 0.0
    still = no_impact(system, v_after)
    return replace(still, P_N={stop.name: 0.0 for stop in contacts})


def no_impact(system: System, v: FloatArray) -> Impact:
    """Return an impact of zero impulse, for events without one."""
    return Impact(v, np.zeros(system.body.nv), np.zeros(system.body.closure_rows), {}, 0.0)


def drive_impulses(
    system: System,
    q: Vector,
    delta: FloatArray,
    P_g: FloatArray,
) -> FloatArray:
    """Impulses that keep held drives at their rate, S' P_drive = S' (M delta - G' P_g).

    No stop acts on a driven joint.

    Args:
        delta: Change of velocity, shape (nv,).
        P_g: Closure impulses, shape (m,) [N s].

    Returns:
        Shape (drives,) [N m s]; zero for free shafts.
    """
    if not system.held:
        return np.zeros(len(system.driven))
    _, jacobian = system.body.closures(q[None])
    momentum = system.body.mass_matrix(q) @ delta - P_g @ jacobian[0]
    return np.asarray(momentum[system.driven])


def _outcome(
    v: FloatArray,
    contacts: Sequence[Stop],
    chosen: Sequence[int],
    wanted: Sequence[float],
    solved: tuple[FloatArray, FloatArray, FloatArray],
    still: Sequence[int],
) -> Impact:
    """Velocity, impulses and energies of an impact at the chosen ones of the contacts."""
    delta, closure_impulses, stop_impulses = solved
    v_after = v + delta
    P_N = {stop.name: 0.0 for stop in contacts}
    lost = 0.0
    for place, impulse in zip(chosen, stop_impulses.tolist(), strict=True):
        stop = contacts[place]
        v_after[stop.index] = stop.sense * wanted[place]
        P_N[stop.name] = impulse
        lost -= 0.5 * impulse * (stop.rate(v) + wanted[place])
    for index in still:
        v_after[index] = 0.0
    return Impact(v_after, delta, closure_impulses, P_N, lost)


def _impulses(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    stops: Sequence[Stop],
    jumps: Sequence[float],
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Change of velocity and impulses for given jumps of these gap rates; None if dependent."""
    held = system.held_coordinates
    columns = [stop.index for stop in stops]
    # The flight that follows keeps the same coordinates independent.
    others = (stop.index for stop in system.mechanism.stops if stop.index not in columns)
    split = system.split(jacobian, held, (*columns, *others))
    if any(index in split.dependent for index in columns):
        return None
    m = len(jacobian)
    # Zero in the held coordinates: round-off there would become momentum of an infinite inertia.
    z = np.zeros(system.body.nv)
    for stop, jump in zip(stops, jumps, strict=True):
        z[stop.index] = -stop.sense * jump
    z = system.lift(jacobian, split, z)
    rows = np.zeros((m + len(stops), system.body.nv))
    rows[:m] = jacobian
    for row, stop in enumerate(stops, start=m):
        rows[row, stop.index] = stop.sense
    delta, impulses = system.body.impulse_response(q, rows, z, system.drive_armature)
    units = lengths = None
    if system.body.scaled:
        # What rows of closures leave is a rate of slides: it counts by the same unit.
        units = system.body.units
        lengths = np.array([system.mechanism.unit_m] * m + [units[i] for i in columns])
    size, residual = _size(z, units), _size(product(rows, z + delta), lengths)
    for _ in range(_REFINEMENTS):
        if residual <= IMPACT_RESIDUAL * size:
            break
        # Bodies of very different mass: the same solution of what is left of the equations.
        left = z + delta
        left[list(held)] = 0.0
        more, further = system.body.impulse_response(q, rows, left, system.drive_armature)
        refined = _size(rows @ (left + more), lengths)
        if not refined < residual:
            break
        delta, impulses, residual = delta + more, impulses + further, refined
    # A rank-deficient system makes the impulse dynamics return a finite wrong velocity.
    if not residual <= MAX_IMPACT_RESIDUAL * size:
        condition = impact_condition(system, q, jacobian, columns)
        message = (
            f"the impact rows are too badly conditioned (residual {residual:.2g}, condition "
            f"{condition:.2g}): the mechanism is near a dead centre, or its masses are too "
            "different"
        )
        raise ImpactError(message, residual=residual, rates=jumps, condition=condition)
    return delta, impulses[:m], impulses[m:]


def _size(vector: FloatArray, units: FloatArray | None = None) -> float:
    """Euclidean norm in units of each number; of a few, faster than the largest of them."""
    if units is not None:
        vector = vector / units
    return math.sqrt(np.vdot(vector, vector))
