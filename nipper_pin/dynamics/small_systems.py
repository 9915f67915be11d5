"""Small systems of linear equations: one by Eigen, several at once by numpy.

For a matrix of a few rows numpy's way to LAPACK takes three times as long as Eigen's factorisation,
which comes with Pinocchio; of many matrices numpy's way is gone once.
"""

from __future__ import annotations

import math

import numpy as np
from eigenpy import PartialPivLU

from ..arrays import FloatArray


def inverse_of(matrix: FloatArray) -> FloatArray:
    """Inverse of one square matrix with rows; not finite throughout if a pivot is zero.

    Args:
        matrix: Shape (m, m), m at least 1.
    """
    inverse: FloatArray = PartialPivLU(matrix).inverse()
    return inverse


def inverses_of(matrices: FloatArray) -> FloatArray:
    """Inverses of N square matrices, shape (N, m, m).

    Raises:
        numpy.linalg.LinAlgError: One of them is singular.
    """
    if len(matrices) != 1 or not matrices.size:
        return np.asarray(np.linalg.inv(matrices), dtype=np.float64)
    inverse = inverse_of(matrices[0])
    _check(inverse)
    return inverse[None]


def solutions_of(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions of N systems of equations, shape (N, m).

    Args:
        matrices: Shape (N, m, m).
        right: Finite right sides, shape (N, m).

    Raises:
        numpy.linalg.LinAlgError: One of the matrices is singular.
    """
    if len(matrices) != 1 or not matrices.size:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0], dtype=np.float64)
    solution: FloatArray = PartialPivLU(matrices[0]).solve(right[0]).reshape(right.shape)
    _check(solution)
    return solution


def same_sign(one: FloatArray, other: FloatArray) -> bool:
    """True if the determinants of two square matrices have one sign, or are both zero."""
    if not one.size:
        return True
    first, second = PartialPivLU(one).determinant(), PartialPivLU(other).determinant()
    return bool((first > 0.0) == (second > 0.0) and (first < 0.0) == (second < 0.0))


def _check(found: FloatArray) -> None:
    """Refuse what a division by a pivot of zero has left: Eigen does not report it."""
    if not math.isfinite(np.vdot(found, found)):
        message = "a matrix of a small system of equations is singular"
        raise np.linalg.LinAlgError(message)
