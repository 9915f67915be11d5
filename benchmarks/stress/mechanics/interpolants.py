"""Values and slopes between Chebyshev-Lobatto nodes, by the barycentric formula.

Source: J.-P. Berrut, L. N. Trefethen, Barycentric Lagrange Interpolation, SIAM Review 46 (2004).
"""

from __future__ import annotations

import numpy as np

from nipper_pin.arrays import FloatArray


def interpolated(values: FloatArray, sigma: FloatArray) -> FloatArray:
    """Values of the interpolant.

    Args:
        values: Values at the nodes, shape (N, columns).
        sigma: Places in [0, 1], shape (K,).

    Returns:
        Shape (K, columns).
    """
    apart = np.subtract.outer(np.asarray(sigma), _nodes(len(values)))
    # At a node the weight of its value is all there is.
    met = apart == 0.0
    weights = _weights(len(values)) / np.where(met, 1.0, apart)
    weights = np.where(met.any(axis=1)[:, None], met, weights)
    return np.asarray(weights @ values / weights.sum(axis=1)[:, None])


def slope(values: FloatArray) -> FloatArray:
    """Derivative of the interpolant by the place on the unit interval, at the nodes, (N, nv)."""
    sigma, weights = _nodes(len(values)), _weights(len(values))
    apart = np.subtract.outer(sigma, sigma)
    np.fill_diagonal(apart, 1.0)
    matrix = weights / weights[:, None] / apart
    # Of a constant nothing may be left: each row adds up to zero.
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return np.asarray(matrix @ values)


def halfway(count: int) -> FloatArray:
    """Places between the nodes, halfway in angle, shape (N - 1,)."""
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * (np.arange(count - 1) + 0.5) / (count - 1))))


def farthest(count: int) -> float:
    """By how much an interpolant may exceed the largest of its values: Lebesgue's constant."""
    return 1.0 + 2.0 / np.pi * float(np.log(count))


def _nodes(count: int) -> FloatArray:
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * np.arange(count) / (count - 1))))


def _weights(count: int) -> FloatArray:
    weights = (-1.0) ** np.arange(count)
    weights[[0, -1]] *= 0.5
    return np.asarray(weights)
