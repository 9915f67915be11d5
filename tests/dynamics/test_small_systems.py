"""Small systems of equations: those of Eigen and of numpy are the same, singular ones too."""

from itertools import combinations

import numpy as np
import pytest

from nipper_pin.dynamics import inverted
from nipper_pin.dynamics.small_systems import (
    inverse_of,
    inverses_of,
    same_sign,
    solutions_of,
)


@pytest.mark.parametrize("size", [1, 2, 4, 6])
def test_one_system_is_solved_as_many_are(size):
    """Solutions meet their equations; residuals are round-off times the number of terms."""
    random = np.random.default_rng(size)
    # Parts of larger arrays, as columns of a Jacobian are.
    matrices = random.normal(size=(3, size, 2 * size))[:, :, ::2] + 3.0 * np.eye(size)
    right = random.normal(size=(3, size))
    close = {"rtol": 0.0, "atol": 1e-13}
    for part in (slice(0, 1), slice(0, 3)):
        found = solutions_of(matrices[part], right[part])
        assert found.shape == right[part].shape
        np.testing.assert_allclose(np.einsum("nij,nj->ni", matrices[part], found), right[part],
                                   **close)  # fmt: skip
        units = np.matmul(inverses_of(matrices[part]), matrices[part])
        np.testing.assert_allclose(units, np.broadcast_to(np.eye(size), units.shape), **close)
    np.testing.assert_allclose(inverse_of(matrices[1]) @ matrices[1], np.eye(size), **close)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize(
    "matrix", [[[0.0, 0.0], [0.0, 0.0]], [[1.0, 2.0], [2.0, 4.0]], [[0.0, 1.0], [0.0, 3.0]]]
)
def test_singular_ones_are_refused(matrix, count):
    """One system or several: a pivot of zero is an error, and its condition infinite."""
    matrices = np.array([matrix] * count)
    with pytest.raises(np.linalg.LinAlgError):
        inverses_of(matrices)
    # Of equations that contradict one another, and of those that do not.
    for right in (np.ones((count, 2)), np.zeros((count, 2))):
        with pytest.raises(np.linalg.LinAlgError):
            solutions_of(matrices, right)
    condition, inverse = inverted(matrices[0])
    assert condition == np.inf
    assert np.isnan(inverse).all()


def test_none_is_no_error():
    """A mechanism without closures has systems without rows."""
    assert inverses_of(np.empty((1, 0, 0))).shape == (1, 0, 0)
    assert solutions_of(np.empty((1, 0, 0)), np.empty((1, 0))).shape == (1, 0)


def test_signs_of_determinants_are_compared():
    """Rows that change places change the sign; a singular matrix has none."""
    one = np.diag([2.0, 3.0])
    swapped, singular = one[::-1].copy(), np.ones((2, 2))
    assert same_sign(one, -one)
    assert same_sign(singular, np.zeros((2, 2)))
    assert same_sign(np.empty((0, 0)), np.empty((0, 0)))
    for first, second in combinations((one, swapped, singular), 2):
        assert not same_sign(first, second)
        assert not same_sign(second, first)
