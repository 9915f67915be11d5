"""The impact law: Newton's restitution with complementarity, on Pinocchio's impulse dynamics.

M (v+ - v-) = G' P_g + W' P_N, G v+ = 0, and for every stop in contact
xi_N = g_N_dot+ + e_N g_N_dot- >= 0, P_N >= 0, xi_N P_N = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..arrays import FloatArray
from ..errors import ImpactError
from ..mechanism import Stop
from .system import System

_RANK_TOLERANCE = 1e-9
_NO_RATE = 1e-13


@dataclass(frozen=True)
class Impact:
    """Outcome of one collision, whatever number of stops takes part in it.

    Attributes:
        v_after: Velocity after, shape (nv,).
        P_g: Closure impulses, shape (m,) [N s].
        P_N: Impulse of every stop in contact, by name, along its coordinate [N m s or N s].
        P_drive: Impulses of the held drives, shape (drives,) [N m s]; zero for free shafts.
        energy_lost: Kinetic energy lost at the stops [J].
        energy_from_drives: Work of the held drives' impulses [J].
    """

    v_after: FloatArray
    P_g: FloatArray
    P_N: dict[str, float]
    P_drive: FloatArray
    energy_lost: float
    energy_from_drives: float


def collide(
    system: System,
    q: FloatArray,
    v: FloatArray,
    jacobian: FloatArray,
    contacts: Sequence[Stop],
    restitution: Sequence[float],
) -> Impact:
    """Apply the impact law to the stops in contact.

    Args:
        system: The system.
        q: Configuration, shape (nv,).
        v: Velocity before, G v = 0, shape (nv,).
        jacobian: Closure Jacobian G at q, shape (m, nv).
        contacts: Stops with zero gap: the colliding ones and those closed before.
        restitution: e_N of each.

    Returns:
        The impact: the first set of stops, the smallest sets first, that satisfies the law.

    Raises:
        ImpactError: No set does: the stops jam the mechanism against its drives.
    """
    indices = [stop.index for stop in contacts]
    before = v[indices]
    wanted = -np.asarray(restitution, dtype=float) * before
    scale = float(np.max(np.abs(before), initial=0.0))
    for size in range(1, len(contacts) + 1):
        for members in combinations(range(len(contacts)), size):
            chosen = list(members)
            solved = _impulses(system, q, jacobian, [indices[i] for i in chosen],
                               (wanted - before)[chosen])  # fmt: skip
            if solved is None:
                continue
            delta, _, stop_impulses = solved
            xi = before + delta[indices] - wanted
            # Zero by construction; what is left there is the round-off of large impulses.
            xi[chosen] = 0.0
            if stop_impulses.min() < 0.0 or xi.min() < -1e-12 * scale:
                continue
            return _outcome(system, q, v, jacobian, contacts, chosen, wanted, solved)
    names = ", ".join(stop.name for stop in contacts)
    message = (
        f"no impulses at {names} satisfy the impact law: these stops jam the mechanism against "
        "its drives; check their sides, or let the drives be inertial"
    )
    raise ImpactError(message, stops=names, rates_before=before.tolist())


def arrest(
    system: System, q: FloatArray, v: FloatArray, jacobian: FloatArray, stop: Stop
) -> Impact:
    """Take away the last rate of a stop: what a series of bounces does at its limit.

    Args:
        system: The system.
        q: Configuration, shape (nv,).
        v: Velocity after the last collision that was computed, shape (nv,).
        jacobian: Closure Jacobian G at q, shape (m, nv).
        stop: The stop that comes to rest.

    Returns:
        The change as an impact whose impulse, a negative one, is not a contact impulse: the
        bounces that it stands for push the stop by e w / (1 - e) against gravity and springs.
    """
    jump = -v[[stop.index]]
    solved = _impulses(system, q, jacobian, [stop.index], jump)
    if solved is None:
        message = f"stop {stop.name!r} cannot come to rest: the mechanism is in a dead centre"
        raise ImpactError(message, stops=stop.name, rates_before=jump.tolist())
    return _outcome(system, q, v, jacobian, [stop], [0], np.zeros(1), solved)


def no_impact(system: System, v: FloatArray) -> Impact:
    """Return the impact that changes nothing, for events without one."""
    rows, drives = system.body.closure_rows, len(system.driven)
    return Impact(v, np.zeros(rows), {}, np.zeros(drives), 0.0, 0.0)


def _outcome(
    system: System,
    q: FloatArray,
    v: FloatArray,
    jacobian: FloatArray,
    contacts: Sequence[Stop],
    chosen: list[int],
    wanted: FloatArray,
    solved: tuple[FloatArray, FloatArray, FloatArray],
) -> Impact:
    """Velocity, impulses and energies of an impact at the chosen ones of the contacts."""
    delta, closure_impulses, stop_impulses = solved
    indices = [contacts[i].index for i in chosen]
    v_after = v + delta
    v_after[indices] = wanted[chosen]
    rates = v[[stop.index for stop in contacts]]
    for i, stop in enumerate(contacts):
        # A contact that the impact does not touch must not separate by its round-off.
        if i not in chosen and abs(v_after[stop.index]) <= _NO_RATE * np.abs(rates).max():
            v_after[stop.index] = 0.0
    P_N = {stop.name: 0.0 for stop in contacts}
    P_N.update({contacts[i].name: float(p) for i, p in zip(chosen, stop_impulses, strict=True)})
    P_drive = np.zeros(len(system.driven))
    if system.held:
        momentum = system.body.mass_matrix(q) @ delta
        momentum -= closure_impulses @ jacobian
        momentum[indices] -= stop_impulses
        P_drive = momentum[system.driven]
    return Impact(
        v_after,
        closure_impulses,
        P_N,
        P_drive,
        float(-0.5 * stop_impulses @ (v[indices] + v_after[indices])),
        float(P_drive @ v[system.driven]),
    )


def _impulses(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    stops: list[int],
    jumps: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Change of velocity and impulses for given jumps of these coordinates; None if dependent."""
    nv, m = system.body.nv, len(jacobian)
    held = [int(index) for index in system.driven] if system.held else []
    count = m + len(stops)
    everything = np.zeros((count + len(held), nv))
    everything[:m] = jacobian
    for row, index in enumerate([*stops, *held], start=m):
        everything[row, index] = 1.0
    rates = np.zeros(len(everything))
    rates[m:count] = -jumps
    z = _particular(everything, rates)
    if z is None:
        return None
    # Round-off in the held rates would become momentum of an infinite inertia.
    z[held] = 0.0
    rows = everything[:count]
    delta, impulses = system.body.impulse_response(q, rows, z)
    residual = float(np.abs(rows @ (z + delta)).max(initial=0.0))
    # A rank-deficient system makes the impulse dynamics return a finite wrong velocity.
    if not residual <= 1e-9 * float(np.abs(z).max(initial=0.0)):
        message = (
            f"the impact rows are too badly conditioned (residual {residual:.2g}): the mechanism "
            "is near a dead centre"
        )
        raise ImpactError(message, residual=residual, rates=rates.tolist())
    return delta, impulses[:m], impulses[m:]


def _particular(rows: FloatArray, rates: FloatArray) -> FloatArray | None:
    """A velocity with these rates along the rows, shape (nv,); None if the rows are dependent."""
    count, nv = rows.shape
    if count > nv:
        return None
    if count == nv:
        try:
            inverse = np.linalg.inv(rows)
        except np.linalg.LinAlgError:
            return None
        if np.abs(inverse).max() * np.abs(rows).max() > 1.0 / _RANK_TOLERANCE:
            return None
        return np.asarray(inverse @ rates)
    z, _, rank, _ = np.linalg.lstsq(rows, rates, rcond=_RANK_TOLERANCE)
    return np.asarray(z) if rank == count else None
