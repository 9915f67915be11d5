"""Linear systems of constrained motion, solved densely."""

from __future__ import annotations

import numpy as np

from benchmarks.stress.mechanics.model_text import Real


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
