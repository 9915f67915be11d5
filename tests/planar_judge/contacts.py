"""Stops in contact: impulses of a collision, and the stops that stay closed at rest.

With D = W' M^-1 W in the motions that constraints and drives leave, both are complementarity
problems of a few unknowns, solved by trying sets.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from .dynamics import Dynamics
from .machine import Stop
from .verdict import Reason, Refusal

Array = np.ndarray
# Gaps whose D is nearer than this to losing rank depend on one another, or cannot move.
_DEPENDENT = 1e-11
# Shares of the largest one below which a rate or a force of the wrong sign is round-off.
_RATE, _FORCE = 1e-11, 1e-9


def responses(dynamics: Dynamics, q: Array, stops: Sequence[Stop]) -> tuple[Array, Array]:
    """Changes of velocity by unit impulses at gaps, shape (n, k), and D, shape (k, k)."""
    k = len(stops)
    q = q[None]
    rows = dynamics.evaluate(q, np.zeros_like(q))
    base, _ = dynamics.restrained(rows, q, ())
    W = np.array([s.sense * rows.jacobian[0, dynamics.stop_rows[s.name]] for s in stops])
    J = np.repeat(base, k, axis=0)
    changes, _ = dynamics.solve(J, W, np.zeros((k, base.shape[1])))
    D = W @ changes.T
    return changes.T, 0.5 * (D + D.T)


def _free(D: Array, dynamics: Dynamics, q: Array, stops: Sequence[Stop]) -> Array:
    """D scaled by what the gaps yield with no other constraint than their own joint."""
    rows = dynamics.evaluate(q[None], np.zeros_like(q[None])).jacobian[0]
    own = np.array([rows[dynamics.stop_rows[s.name]] * dynamics.scale for s in stops])
    size = np.sqrt(np.einsum("ki,ki->k", own, own))
    return D / size / size[:, None]


def _solvable(D: Array, chosen: Sequence[int]) -> bool:
    """Whether these gaps yield, independently."""
    part = D[np.ix_(chosen, chosen)]
    diagonal = np.diag(part)
    if (diagonal <= _DEPENDENT).any():
        return False
    size = np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(part / size / size[:, None])[0] > _DEPENDENT**0.5 * 1e-3)


def collision(
    dynamics: Dynamics, q: Array, stops: Sequence[Stop], before: Array
) -> tuple[Array, Array, Array]:
    """Newton's law with complementarity at the stops that close and those that are closed.

    From the rates of their gaps the change of velocity (n,), the impulses along the gaps (k,) and
    the rates after them (k,).
    """
    changes, D = responses(dynamics, q, stops)
    scaled = _free(D, dynamics, q, stops)
    wanted = np.array([-stop.restitution * rate for stop, rate in zip(stops, before, strict=True)])
    slack = _RATE * float(np.abs(before).max())
    if (before >= 0.0).all():
        return np.zeros(len(q)), np.zeros(len(stops)), before.copy()
    for count in range(1, len(stops) + 1):
        for chosen in combinations(range(len(stops)), count):
            part = list(chosen)
            if not _solvable(scaled, part):
                continue
            P = np.zeros(len(stops))
            P[part] = np.linalg.solve(D[np.ix_(part, part)], (wanted - before)[part])
            after = before + D @ P
            after[part] = wanted[part]
            if (P >= 0.0).all() and (after - wanted >= -slack).all():
                after[np.abs(after) <= slack * (P == 0.0)] = 0.0
                return changes @ P, P, after
    raise Refusal(Reason.JAM, "no impulses satisfy the law at " + ", ".join(s.name for s in stops))


def staying(
    dynamics: Dynamics, t: float, q: Array, v: Array, stops: Sequence[Stop]
) -> frozenset[str]:
    """Which stops at rest stay closed: accelerations of gaps and forces are complementary."""
    if not stops:
        return frozenset()
    free = dynamics.accelerate(np.array([t]), q[None], v[None], ())
    gaps = np.array([
        s.sense * float(free.rows.jacobian[0, row] @ free.a[0] + free.rows.bias[0, row])
        for s in stops
        for row in [dynamics.stop_rows[s.name]]
    ])  # fmt: skip
    _, D = responses(dynamics, q, stops)
    scaled = _free(D, dynamics, q, stops)
    tried = []
    for count in range(len(stops), -1, -1):
        for chosen in combinations(range(len(stops)), count):
            part = list(chosen)
            if part and not _solvable(scaled, part):
                continue
            la = np.zeros(len(stops))
            if part:
                la[part] = np.linalg.solve(D[np.ix_(part, part)], -gaps[part])
            after = gaps + D @ la
            after[part] = 0.0
            tried.append((part, la, after))
    force = _FORCE * max((float(np.abs(la).max()) for _, la, _ in tried), default=0.0)
    leaving = _FORCE * max(float(np.abs(after).max()) for _, _, after in tried)
    for strict in (0.0, 1.0):
        for part, la, after in tried:
            if (la >= -strict * force).all() and (after >= -strict * leaving).all():
                return frozenset(stops[i].name for i in part)
    raise Refusal(Reason.DEPENDENT, "no set of " + ", ".join(s.name for s in stops) + " stays")
