"""Tensor Chebyshev series on cells: fit, tails, truncation and derivatives.

Source: L. N. Trefethen, Approximation Theory and Approximation Practice, 2013.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from ...arrays import FloatArray


def gauss_nodes(count: int) -> FloatArray:
    """Chebyshev-Gauss nodes in (-1, 1), increasing, shape (count,)."""
    return np.asarray(-np.cos(np.pi * (np.arange(count) + 0.5) / count))


def fit(values: FloatArray) -> FloatArray:
    """Coefficients of the interpolant.

    Args:
        values: Values at the tensor product of Gauss nodes, shape (..., Nu, Nx).

    Returns:
        Coefficients of T_i(u) T_j(x), shape (..., Nu, Nx).
    """
    by_u = _from_values(values.shape[-2])
    by_x = _from_values(values.shape[-1])
    return np.asarray(by_u @ values @ by_x.T)


def _from_values(count: int) -> FloatArray:
    # Discrete orthogonality of the Chebyshev polynomials on the Gauss nodes.
    matrix = 2.0 / count * chebyshev.chebvander(gauss_nodes(count), count - 1).T
    matrix[0] *= 0.5
    return np.asarray(matrix)


def tails(coefficients: FloatArray, weights: FloatArray) -> FloatArray:
    """Size of what a longer series would add, at least.

    Args:
        coefficients: Shape (functions, cells, Nu, Nx).
        weights: Weight of an error of each function, shape (functions,).

    Returns:
        The largest weighted sum of the last two orders, by u and by x, shape (2,).
    """
    size = np.abs(coefficients) * weights[:, None, None, None]
    by_u = size[:, :, -2:, :].sum(axis=(2, 3)).max()
    by_x = size[:, :, :, -2:].sum(axis=(2, 3)).max()
    return np.array([by_u, by_x])


def needed(coefficients: FloatArray, weights: FloatArray, tolerance: float) -> tuple[int, int]:
    """Orders (Nu, Nx) that drop no more than a weighted ``tolerance`` of any function."""
    size = np.abs(coefficients) * weights[:, None, None, None]
    by_u = size.sum(axis=3).max(axis=(0, 1))
    by_x = size.sum(axis=2).max(axis=(0, 1))
    return _kept(by_u, tolerance), _kept(by_x, tolerance)


def _kept(size: FloatArray, tolerance: float) -> int:
    dropped = np.cumsum(size[::-1])[::-1]
    return max(int(np.count_nonzero(dropped > tolerance)), 2)


def largest(coefficients: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Largest absolute values on a fine grid with its edges: of functions and both derivatives.

    Args:
        coefficients: Shape (functions, cells, Nu, Nx).

    Returns:
        Of the functions, of their derivatives by u and by x on [-1, 1], each (functions,).
    """
    (basis_u, slope_u), (basis_x, slope_x) = map(_fine, coefficients.shape[2:])

    def most(left: FloatArray, right: FloatArray) -> FloatArray:
        values = left @ coefficients @ right.T
        return np.asarray(np.abs(values).max(axis=(1, 2, 3)))

    return most(basis_u, basis_x), most(slope_u, basis_x), most(basis_u, slope_x)


def _fine(count: int) -> tuple[FloatArray, FloatArray]:
    """The first polynomials on a fine grid, and their derivatives, shape (places, count) each."""
    places = np.cos(np.pi * np.arange(2 * count + 1) / (2 * count))
    derivative = chebyshev.chebder(np.eye(count), axis=0)
    slopes = chebyshev.chebvander(places, count - 2) @ derivative
    return np.asarray(chebyshev.chebvander(places, count - 1)), np.asarray(slopes)
