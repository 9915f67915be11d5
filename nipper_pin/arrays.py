"""The one array type of the package."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def product(left: FloatArray, right: FloatArray) -> FloatArray:
    """Product of matrices and vectors; for small ones in half the time of the operator ``@``.

    Args:
        left: Shape (m, n) or (n,).
        right: Shape (n, k) or (n,).
    """
    found: FloatArray = left.dot(right)
    return found
