"""Polynomials of a panel: integrals between nodes, and first downward zeros."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from nipper_pin.chebyshev import Series, decayed, nodes, tail
from nipper_pin.hybrid.event_location.roots import first_descent, polish

ORDERS = [3, 4, 5, 8, 12, 16]

# Values and matrices are of order one; products of N terms leave N round-offs.
TOLERANCE = 1e-13


@pytest.mark.parametrize("order", ORDERS)
def test_integration_is_exact_for_polynomials_that_the_nodes_hold(order: int) -> None:
    """Integrals of sigma^k, k < N, come out as sigma^(k+1)/(k+1) and sigma^(k+2)/((k+1)(k+2)).

    Nodes run from 0 to 1. The interpolant of sigma^N misses it by the node polynomial, 2^(1 - 2 N)
    or more at its largest: the operators hold N nodes, not more.
    """
    grid = nodes(order)
    sigma = grid.sigma
    assert (sigma[0], sigma[-1]) == (0.0, 1.0)
    assert (np.diff(sigma) > 0.0).all()
    np.testing.assert_allclose(sigma + sigma[::-1], 1.0, rtol=0.0, atol=1e-15)
    for k in range(order):
        for found, wanted in (
            (grid.once @ sigma**k, sigma ** (k + 1) / (k + 1)),
            (grid.twice @ sigma**k, sigma ** (k + 2) / ((k + 1) * (k + 2))),
        ):
            np.testing.assert_allclose(found, wanted, rtol=0.0, atol=TOLERANCE)
    error = grid.once @ sigma**order - sigma ** (order + 1) / (order + 1)
    assert np.abs(error).max() > 4.0**-order / order**2


@pytest.mark.parametrize("order", ORDERS)
def test_what_follows_the_last_coefficients(order: int) -> None:
    """3 T_(N-1) - 2 T_(N-2) has the tail 5, and what has fewer terms has none.

    By their decay, of 1e-2, 1e-4, 0 the last but one counts by a hundredth; of 1e-4, 1e-2, 0 as it
    is: a last coefficient that vanishes by chance must not hide the others. T_k is cos(k arccos x).
    """
    angle = np.arccos(2.0 * nodes(order).sigma - 1.0)
    before, second, last = (np.cos((order - k) * angle) for k in (3, 2, 1))
    found = tail(np.column_stack([3.0 * last - 2.0 * second, before]))
    np.testing.assert_allclose(found, [5.0, 0.0], rtol=0.0, atol=1e-12)
    if order > 3:
        falling, rising = 1e-2 * before + 1e-4 * second, 1e-4 * before + 1e-2 * second
        found = decayed(np.column_stack([falling, rising, last, np.zeros(order)]))
        np.testing.assert_allclose(found, [1e-6, 1e-2, 1.0, 0.0], rtol=1e-9, atol=1e-14)


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


GRID = np.linspace(0.0, 1.0, 12)

EPS = float(np.finfo(float).eps)


def _first(function: Callable[[float], float]) -> tuple[float, float] | None:
    return first_descent(GRID, np.array([function(x) for x in GRID]), function)


Function = Callable[[float], float]


def dip(half_width: float) -> tuple[Function, Function, float, float]:
    """Below zero between samples that are all positive; an eps of its two squares, by its slope."""
    centre = 0.41
    function, slope = (lambda x: (x - centre) ** 2 - half_width**2), (lambda x: 2.0 * (x - centre))
    assert all(function(x) > 0.0 for x in GRID)
    return function, slope, centre - half_width, 4.0 * EPS / half_width


# Functions and their slopes, where they first fall through zero, and to how much that is known.
FALLS: dict[str, tuple[Function, Function, float, float]] = {
    "back at zero, where it began": (
        lambda x: x * (0.7 - x), lambda x: 0.7 - 2.0 * x, 0.7, 4.0 * EPS),
    "negative before it is positive": (
        lambda x: (x - 0.2) * (0.8 - x), lambda x: 1.0 - 2.0 * x, 0.8, 4.0 * EPS),
    "a wide dip": dip(3e-2), "a narrow dip": dip(1e-3), "hardly a dip": dip(1e-6),
    "at the end": (lambda x: 1.0 - x, lambda _: -1.0, 1.0, 0.0),
    "just after the start": (lambda x: 1e-9 - x, lambda _: -1.0, 1e-9, 4e-9 * EPS),
    "the first of several": (
        lambda x: math.cos(3.0 * math.pi * x),
        lambda x: -3.0 * math.pi * math.sin(3.0 * math.pi * x), 1.0 / 6.0, 4.0 * EPS),
}  # fmt: skip


@pytest.mark.parametrize("name", FALLS)
def test_a_fall_through_zero_is_found(name: str) -> None:
    """A sample that is zero is no place that it falls from, and one to which it may fall."""
    function, slope, root, error = FALLS[name]
    bracket = _first(function)
    assert bracket is not None
    assert bracket[0] < root <= bracket[1]
    assert function(bracket[0]) > 0.0 >= function(bracket[1])
    found = polish(lambda x: (function(x), slope(x)), *bracket)
    assert found == pytest.approx(root, rel=0.0, abs=error)


@pytest.mark.parametrize(
    "function",
    [lambda x: 1.0 + x, lambda x: -1.0 - x, lambda x: x, lambda x: 0.0 * x,
     lambda x: (x - 0.41) ** 2 + 1e-6],
)  # fmt: skip
def test_without_a_fall_through_zero_there_is_none(function: Function) -> None:
    """Always positive, always negative, leaving zero upward, resting at zero; a dip above zero."""
    assert _first(function) is None


# Values and slopes; wrong slopes, above half the true ones, cost steps and not accuracy.
POLISHED: dict[str, tuple[Callable[[float], tuple[float, float]], float, float]] = {
    # Newton's method is thrown out of [0, 1]; 0.3 - x is exact near 0.3.
    **{f"slope by {factor}": (
        lambda x, factor=factor: (math.atan(200.0 * (0.3 - x)),
                                  -200.0 * factor / (1.0 + (200.0 * (0.3 - x)) ** 2)),
        0.3, 16.0 * EPS) for factor in (1.0, 0.7, 3.0)},
    "a jump": (lambda x: (1.0 if x < 0.6 else -1.0, 0.0), 0.6, 8.0 * EPS),
    # Steps end as far beyond the root as they began before it, again and again.
    "half the slope": (lambda x: (2.0 * (0.3 - x), -1.0), 0.3, 4.0 * EPS),
}  # fmt: skip


@pytest.mark.parametrize("name", POLISHED)
@pytest.mark.parametrize("start", [(), (0.35,)], ids=["", "begun beside it"])
def test_roots_are_polished_to_round_off(name: str, start: tuple[float, ...]) -> None:
    function, root, error = POLISHED[name]
    assert polish(function, 0.0, 1.0, *start) == pytest.approx(root, rel=0.0, abs=error)


@pytest.mark.parametrize("mirrored", [False, True])
def test_two_close_zeros_beside_an_end_are_found(mirrored: bool) -> None:
    """The function falls below zero and comes back before the second sample, or after the last.

    No sample is lower than its neighbours then, which is how dips inside are found. A jaw with a
    clearance of 3 nm went through its stop by 2 nm like this.
    """
    grid = 0.5 * (1.0 - np.cos(np.pi * np.arange(53) / 52.0))
    zeros = np.array([0.2, 0.6]) * grid[1]

    def function(x: float) -> float:
        place = 1.0 - x if mirrored else x
        return (place - zeros[0]) * (place - zeros[1])

    values = np.array([function(x) for x in grid])
    assert (values > 0.0).all()
    found = first_descent(grid, values, function)
    assert found is not None
    root = polish(lambda x: (function(x), (function(x + 1e-9) - function(x)) / 1e-9), *found)
    wanted = 1.0 - zeros[1] if mirrored else zeros[0]
    assert root == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("depth", [1e-5, 3e-11, 1e-14])
@pytest.mark.parametrize("skew", [-1.0, 1.0])
def test_a_dip_is_followed_to_its_bottom(depth: float, skew: float) -> None:
    """A parabola through three samples finds the place of a skew dip to a part of its width.

    That is a thousand times too far from the bottom to see that 3e-11 of it lies below zero.
    """
    centre = 0.43

    def function(x: float) -> float:
        return (x - centre) ** 2 * (1.0 + skew * (x - centre)) ** 2 - depth

    values = np.array([function(x) for x in GRID])
    assert (values > 0.0).all()
    bracket = _first(function)
    assert bracket is not None
    assert function(bracket[0]) > 0.0 >= function(bracket[1])
    assert abs(bracket[1] - centre) <= 2.0 * np.sqrt(depth)
