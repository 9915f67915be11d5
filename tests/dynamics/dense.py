"""Linear systems of constrained motion, solved densely, and loops closed by them."""

from __future__ import annotations

import numpy as np

from benchmarks.stress.mechanics.model_text import Real
from benchmarks.stress.mechanics.planar_tree import PlanarTree


def constrained(M: Real, force: Real, rows: Real, rates: Real) -> tuple[Real, Real]:
    """Solve M x = force + rows' y, rows x = rates, to the last digits by iterative refinement."""
    count = len(rows)
    matrix = np.block([[M, -rows.T], [rows, np.zeros((count, count))]])
    right = np.concatenate([force, rates])
    # Equilibrated, because masses and lever arms differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.abs(matrix).max(axis=1))
    inverse = np.linalg.inv(scale[:, None] * matrix * scale)
    x = np.zeros(len(right), dtype=np.longdouble)
    for _ in range(4):
        residual = right - matrix.astype(np.longdouble) @ x
        x = x + scale * (inverse @ (scale * residual.astype(float)))
    solution = x.astype(float)
    return solution[: len(M)], solution[len(M) :]


def close(tree: PlanarTree, q: Real, free: list[int]) -> Real:
    """Move the free coordinates by the least amount that closes the loops (Gauss-Newton)."""
    q, zero = q.copy(), np.zeros(tree.nv)
    for _ in range(12):
        g = tree.closure(q, zero, zero)[0]
        step = np.linalg.lstsq(tree.closure_jacobian(q)[:, free], g, rcond=None)[0]
        q[free] -= step
        if np.abs(step).max() < 1e-15:
            break
    return q
