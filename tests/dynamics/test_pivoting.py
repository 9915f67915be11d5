"""Small systems of equations, and complementarity by pivoting, against numpy and every choice."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from nipper_pin.dynamics import inverted
from nipper_pin.dynamics.pivoting import complementary
from nipper_pin.dynamics.small_systems import inverse_of, inverses_of, same_sign, solutions_of


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


def every_choice(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The one P of the 2^n sets that satisfies the conditions; A is positive definite."""
    for size in range(len(b) + 1):
        for chosen in combinations(range(len(b)), size):
            P = np.zeros(len(b))
            P[list(chosen)] = np.linalg.solve(A[np.ix_(chosen, chosen)], -b[list(chosen)])
            xi = A @ P + b
            xi[list(chosen)] = 0.0
            if min(P.min(), xi.min()) >= 0.0:
                return P
    raise AssertionError


@pytest.mark.parametrize("seed", range(40))
def test_the_choice_is_that_of_all_choices(seed: int) -> None:
    """Units of the coordinates differ by up to 1e4; the same set gives the same bits."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 8
    root = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-2.0, 2.0, n)
    b = rng.normal(size=n) * 10.0 ** rng.uniform(-2.0, 2.0, n)
    A = root.T @ root
    assert np.array_equal(complementary(A, b), every_choice(A, b))


@pytest.mark.parametrize("seed", range(40))
def test_of_dependent_stops_a_few_carry_all(seed: int) -> None:
    """A has a lower rank than rows; P is that of min |B P + c|^2 / 2, P >= 0, with A = B' B.

    b = B' c makes A P + b >= 0 possible always. The conditions hold to the round-off of sums of
    eight terms, 1e-13 of the largest, and no more stops carry than there are directions.
    """
    rng = np.random.default_rng(seed)
    n = 2 + seed % 7
    rank = int(rng.integers(1, n))
    B, c = rng.normal(size=(rank, n)), rng.normal(size=rank)
    P = complementary(B.T @ B, B.T @ c)
    assert P is not None
    xi = B.T @ (B @ P + c)
    scale = 1e-12 * max(np.abs(B.T @ B) @ P + np.abs(B.T @ c))
    assert P.min() >= 0.0
    assert xi.min() >= -scale
    assert np.abs(xi * P).max() <= scale * max(P.max(), 1.0)
    assert np.count_nonzero(P) <= rank


@pytest.mark.parametrize(
    ("A", "b"),
    [
        ([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0]),  # a link that two held walls squeeze
        ([[0.0]], [-1.0]),  # one that nothing moves
        ([[0.0, 0.0], [0.0, 2.0]], [-1.0, -1.0]),
    ],
)
def test_what_is_jammed_has_no_impulses(A: list[list[float]], b: list[float]) -> None:
    assert complementary(np.array(A), np.array(b)) is None


@pytest.mark.parametrize("n", [13, 40, 80])
def test_many_stops_take_no_search(n: int) -> None:
    """Balls in a row, each with the relative slide to the last one: A is (-1, 2, -1).

    The first pair approaches with 1 and no one else, so that all contacts have to take an impulse
    of (n - i) / (n + 1). 2^80 sets could not be tried.
    """
    A = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    b = np.zeros(n)
    b[0] = -1.0
    wanted = (n - np.arange(n)) / (n + 1.0)
    # Its condition is 4 (n + 1)^2 / pi^2, below 3000.
    assert complementary(A, b) == pytest.approx(wanted, rel=3000 * 2.3e-16)
