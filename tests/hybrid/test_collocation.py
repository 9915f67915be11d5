"""Collocation operators: exact for the polynomials that the nodes can hold."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin.hybrid.motion.chebyshev import Series, decayed, evaluate, nodes, tail

ORDERS = [3, 4, 5, 8, 12, 16]
# Values and matrices are of order one; products of N terms leave N round-offs.
TOLERANCE = 1e-13


@pytest.mark.parametrize("order", ORDERS)
def test_integration_is_exact_for_polynomials(order: int) -> None:
    """Integrals of sigma^k, k < N, come out as sigma^(k+1)/(k+1) and sigma^(k+2)/((k+1)(k+2)).

    Every monomial up to the highest degree is taken, so no symmetry can hide a wrong coefficient.
    """
    grid = nodes(order)
    for k in range(order):
        values = grid.sigma**k
        np.testing.assert_allclose(
            grid.once @ values, grid.sigma ** (k + 1) / (k + 1), rtol=0.0, atol=TOLERANCE
        )
        np.testing.assert_allclose(
            grid.twice @ values,
            grid.sigma ** (k + 2) / ((k + 1) * (k + 2)),
            rtol=0.0,
            atol=TOLERANCE,
        )


@pytest.mark.parametrize("order", ORDERS)
def test_integration_is_not_exact_one_degree_higher(order: int) -> None:
    """sigma^N is aliased: the operators hold N nodes, not more.

    The interpolant of sigma^N misses it by the node polynomial, 2^(1 - 2 N) or more at its
    largest; a test of exactness that could not fail would pass here too.
    """
    grid = nodes(order)
    error = grid.once @ grid.sigma**order - grid.sigma ** (order + 1) / (order + 1)
    assert np.abs(error).max() > 4.0**-order / order**2


@pytest.mark.parametrize("order", ORDERS)
def test_nodes_hold_both_ends_in_order(order: int) -> None:
    """The nodes run from 0 to 1, increasing, symmetric about the middle."""
    sigma = nodes(order).sigma
    assert sigma[0] == 0.0
    assert sigma[-1] == 1.0
    assert (np.diff(sigma) > 0.0).all()
    np.testing.assert_allclose(sigma + sigma[::-1], 1.0, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("integrations", [0, 1, 2])
def test_evaluation_between_nodes_meets_the_polynomial(integrations: int) -> None:
    """Dense evaluation of a cubic and its integrals agrees with them between the nodes.

    Columns are treated apart: the second column is twice the first.
    """
    sigma = np.linspace(0.0, 1.0, 31)
    cubic = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.7])
    values = cubic(nodes(6).sigma)
    found = evaluate(np.column_stack([values, 2.0 * values]), sigma, integrations)
    wanted = cubic.integ(integrations)(sigma) if integrations else cubic(sigma)
    np.testing.assert_allclose(found[:, 0], wanted, rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(found[:, 1], 2.0 * wanted, rtol=0.0, atol=2.0 * TOLERANCE)


def test_fine_grid_operators_agree_with_evaluation() -> None:
    """The precomputed fine grid gives the same values as the evaluation at its points."""
    grid = nodes(12)
    values = np.exp(grid.sigma) - 2.0 * grid.sigma
    np.testing.assert_allclose(
        grid.sample_value @ values, evaluate(values, grid.samples, 0), rtol=0.0, atol=TOLERANCE
    )
    np.testing.assert_allclose(
        grid.sample_twice[0] @ values, evaluate(values, grid.samples, 2), rtol=0.0, atol=TOLERANCE
    )


def test_double_integral_keeps_relative_precision_near_the_start() -> None:
    """Where the acceleration is constant, the double integral is sigma^2/2 to relative round-off.

    A gap that starts at zero lives on this: at sigma = 1e-3 the integral is 5e-7, so an absolute
    error of one round-off of the largest value would already be 4e-10 of it.
    """
    grid = nodes(12)
    values = np.ones(12)
    inner = grid.sigma[1:]
    np.testing.assert_allclose((grid.twice @ values)[1:], 0.5 * inner**2, rtol=1e-12)


@pytest.mark.parametrize("power", [0, 1, 2])
def test_deflated_series_are_the_double_integral_by_a_power(power: int) -> None:
    """Coefficients of D(sigma) / sigma^power give D, its values and its slope, for a quartic D.

    a = 12 sigma^2 - 6 sigma + 2 has D = sigma^4 - sigma^3 + sigma^2, so the quotients are known
    polynomials with known slopes, at sigma = 0, too, where a division would fail. The division
    amplifies round-off of D at the first node most, and an error of a polynomial of degree n on
    [0, 1] changes its slope by up to 2 n^2 times as much (A. A. Markov's inequality); a wrong
    coefficient changes both by 1e-2 or more.
    """
    grid = nodes(9)
    coefficients = grid.deflated[power] @ (12.0 * grid.sigma**2 - 6.0 * grid.sigma + 2.0)
    wanted = np.polynomial.Polynomial([0.0, 0.0, 1.0, -1.0, 1.0][power:])
    series = Series(coefficients)
    round_off = 4.0 * np.finfo(float).eps / grid.sigma[1] ** power
    for sigma in (0.0, 0.013, 0.5, 0.97, 1.0):
        value, slope = series.value_and_slope(sigma)
        assert value == pytest.approx(wanted(sigma), abs=round_off)
        steepest = 2.0 * len(coefficients) ** 2
        assert slope == pytest.approx(wanted.deriv()(sigma), abs=steepest * round_off)
        assert series.value(sigma) == value


@pytest.mark.parametrize("order", ORDERS)
def test_tail_is_the_size_of_the_last_two_coefficients(order: int) -> None:
    """3 T_(N-1) - 2 T_(N-2) has the tail 5, and what has fewer terms has none.

    The value follows from the definition of the polynomials, cos(k arccos x).
    """
    angle = np.arccos(2.0 * nodes(order).sigma - 1.0)
    rough = 3.0 * np.cos((order - 1) * angle) - 2.0 * np.cos((order - 2) * angle)
    smooth = np.cos((order - 3) * angle)
    found = tail(np.column_stack([rough, smooth]))
    np.testing.assert_allclose(found, [5.0, 0.0], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("order", [order for order in ORDERS if order >= 4])
def test_what_follows_decaying_coefficients_is_judged_by_their_decay(order: int) -> None:
    """Of 1e-2, 1e-4, 0 the last but one counts by a hundredth; of 1e-4, 1e-2, 0 as it is.

    A last coefficient that vanishes by chance must not hide the others: both values would be zero.
    """
    angle = np.arccos(2.0 * nodes(order).sigma - 1.0)
    before, second, last = (np.cos((order - k) * angle) for k in (3, 2, 1))
    falling = 1e-2 * before + 1e-4 * second
    rising = 1e-4 * before + 1e-2 * second
    found = decayed(np.column_stack([falling, rising, last, np.zeros(order)]))
    np.testing.assert_allclose(found, [1e-6, 1e-2, 1.0, 0.0], rtol=1e-9, atol=1e-14)
