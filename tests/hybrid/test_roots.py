"""First downward zeros: half-open triggers, close zeros, touches and ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nipper_pin.hybrid.event_location.roots import first_descent, polish

GRID = np.linspace(0.0, 1.0, 12)
EPS = float(np.finfo(float).eps)


def _first(function: Callable[[float], float]) -> tuple[float, float] | None:
    return first_descent(GRID, np.array([function(x) for x in GRID]), function)


def test_a_gap_that_starts_at_zero_fires_only_when_it_is_back() -> None:
    """x (0.7 - x) is zero at both 0 and 0.7; only 0.7 is a passage from positive."""
    bracket = _first(lambda x: x * (0.7 - x))
    assert bracket is not None
    assert bracket[0] > 0.0
    root = polish(lambda x: (x * (0.7 - x), 0.7 - 2.0 * x), *bracket)
    assert root == pytest.approx(0.7, abs=4.0 * EPS)


def test_negative_values_before_the_first_positive_one_are_passed_over() -> None:
    """(x - 0.2)(0.8 - x) rises through 0.2 and falls through 0.8: only the fall counts."""
    bracket = _first(lambda x: (x - 0.2) * (0.8 - x))
    assert bracket is not None
    assert bracket[0] < 0.8 <= bracket[1]


@pytest.mark.parametrize("half_width", [3e-2, 1e-3, 1e-6])
def test_two_close_zeros_between_two_samples_are_found(half_width: float) -> None:
    """A dip below zero that no sample sees is found, and its first zero is the answer.

    Samples are 1/11 apart and all positive, so a search by sign changes alone finds nothing.
    """
    centre = 0.41

    def function(x: float) -> float:
        return (x - centre) ** 2 - half_width**2

    assert all(function(x) > 0.0 for x in GRID)
    bracket = _first(function)
    assert bracket is not None
    root = polish(lambda x: (function(x), 2.0 * (x - centre)), *bracket)
    # The function's round-off is one eps of the two squares; its slope is 2 half_width.
    assert root == pytest.approx(centre - half_width, abs=4.0 * EPS / half_width)


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


def test_a_dip_that_stays_positive_is_no_zero() -> None:
    """The same dip, lifted by 1e-6, fires nothing."""
    assert _first(lambda x: (x - 0.41) ** 2 + 1e-6) is None


def test_a_tangential_touch_fires_at_the_place_of_touch_or_not_at_all() -> None:
    """(x - c)^2 touches zero: if anything fires it does so at c, to the root of round-off.

    With c on a sample the value is exactly zero there, which is not positive, and must fire.
    """
    on_sample = float(GRID[5])
    bracket = _first(lambda x: (x - on_sample) ** 2)
    assert bracket is not None
    root = polish(lambda x: ((x - on_sample) ** 2, 2.0 * (x - on_sample)), *bracket)
    assert root == on_sample
    between = 0.47
    bracket = _first(lambda x: (x - between) ** 2)
    if bracket is not None:
        assert bracket[1] == pytest.approx(between, abs=2.0 * np.sqrt(EPS))


def test_a_zero_at_the_end_of_the_grid_fires_there() -> None:
    """1 - x reaches zero at the last sample: not positive there, so the step ends with it."""
    bracket = _first(lambda x: 1.0 - x)
    assert bracket is not None
    assert bracket[1] == 1.0
    assert polish(lambda x: (1.0 - x, -1.0), *bracket) == 1.0


def test_a_zero_just_after_the_start_is_bracketed_by_the_start() -> None:
    """1e-9 - x is positive at the start only; the bracket begins there."""
    bracket = _first(lambda x: 1e-9 - x)
    assert bracket is not None
    assert bracket[0] == 0.0
    assert polish(lambda x: (1e-9 - x, -1.0), *bracket) == pytest.approx(1e-9, rel=4.0 * EPS)


@pytest.mark.parametrize(
    "function", [lambda x: 1.0 + x, lambda x: -1.0 - x, lambda x: x, lambda x: 0.0 * x]
)
def test_without_a_fall_through_zero_there_is_none(function: Callable[[float], float]) -> None:
    """Always positive, always negative, leaving zero upward, or resting at zero: no trigger."""
    assert _first(function) is None


def test_the_first_of_several_falls_is_taken() -> None:
    """cos(3 pi x) falls through zero at 1/6 and 5/6."""
    bracket = _first(lambda x: float(np.cos(3.0 * np.pi * x)))
    assert bracket is not None
    assert bracket[0] < 1.0 / 6.0 <= bracket[1]


@pytest.mark.parametrize("factor", [1.0, 0.7, 3.0])
def test_polish_reaches_round_off_where_newton_steps_leave_the_bracket(factor: float) -> None:
    """arctan(200 (0.3 - x)) throws Newton's method out of [0, 1]; bisection brings it back.

    A slope that is wrong by a factor (above one half, so that steps still shrink) costs steps,
    not accuracy.
    """

    def function(x: float) -> tuple[float, float]:
        slope = -200.0 / (1.0 + (200.0 * (0.3 - x)) ** 2)
        return float(np.arctan(200.0 * (0.3 - x))), factor * slope

    # 0.3 - x is exact near 0.3, so the root is a double next to 0.3.
    assert polish(function, 0.0, 1.0) == pytest.approx(0.3, abs=16.0 * EPS)


def test_polish_closes_in_on_a_jump() -> None:
    """A function that jumps has no zero; the place of the jump comes out to round-off."""
    root = polish(lambda x: (1.0 if x < 0.6 else -1.0, 0.0), 0.0, 1.0)
    assert root == pytest.approx(0.6, abs=8.0 * EPS)


def test_polish_is_not_sent_to_and_fro_by_a_slope_that_is_half_the_true_one() -> None:
    """Such Newton steps end as far beyond the root as they began before it, again and again."""
    root = polish(lambda x: (2.0 * (0.3 - x), -1.0), 0.0, 1.0, 0.35)
    assert root == pytest.approx(0.3, abs=4.0 * EPS)


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
