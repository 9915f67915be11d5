"""Polynomials of a panel: integrals between nodes, first downward zeros, highest points."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Chebyshev, Polynomial

from nipper_pin import Case, EventKind
from nipper_pin.chebyshev import Series, decayed, evaluate, nodes, tail
from nipper_pin.dynamics import Partition
from nipper_pin.hybrid import Segment
from nipper_pin.hybrid.event_location.roots import first_descent, polish
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.result.rebounds import Rebounds
from nipper_pin.mechanism import Stop

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


@pytest.mark.parametrize("integrations", [0, 1, 2])
def test_evaluation_between_nodes_meets_the_polynomial(integrations: int) -> None:
    """Dense evaluation of a cubic and its integrals, of two columns, and on the fine grid."""
    grid, cubic = nodes(6), np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.7])
    values, integral = cubic(grid.sigma), cubic.integ(integrations) if integrations else cubic
    sigma = np.linspace(0.0, 1.0, 31)
    found = evaluate(np.column_stack([values, 2.0 * values]), sigma, integrations)
    wanted = integral(sigma)[:, None] * [1.0, 2.0]
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=2.0 * TOLERANCE)
    fine = {0: grid.sample_value, 2: grid.sample_twice[0]}
    if integrations in fine:
        found = fine[integrations] @ values
        np.testing.assert_allclose(found, integral(grid.samples), rtol=0.0, atol=TOLERANCE)


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


LOWER = Stop(name="floor", index=0, restitution=0.5, contact=None)

UPPER = Stop(name="floor", index=0, restitution=0.5, contact=None, sense=-1.0, at=0.25)

Gap = Any


def waves(count: float, rise: float) -> Gap:
    """Crests one after another between two zeros, each by ``rise`` higher than the one before."""
    return Chebyshev.interpolate(
        lambda t: t * (1.0 - t) * (1.5 + rise * t + math.copysign(1.0, count)
                                   * np.cos(2.0 * math.pi * abs(count) * t)),
        18, domain=[0.0, 1.0],
    )  # fmt: skip


def line(begin: tuple[float, float], end: tuple[float, float]) -> Gap:
    """A gap that changes evenly between two times."""
    (t, gap), (later, other) = begin, end
    slope = (other - gap) / (later - t)
    return Polynomial([gap - slope * t, slope])


PARABOLA = Polynomial([0.0, 4.0, -4.0])

TOP = (0.4, 0.3)

# Pieces of the gap, the times between which each holds, and the highest gap.
GAPS: dict[str, tuple[list[Gap], list[float]]] = {
    "one crest": ([PARABOLA], [0.0, 1.0]),
    "cut before the crest": ([PARABOLA] * 2, [0.0, 0.3, 1.0]),
    "cut at the crest": ([PARABOLA] * 2, [0.0, 0.5, 1.0]),
    "cut behind the crest": ([PARABOLA] * 3, [0.0, 0.6, 0.8, 1.0]),
    "a kink": ([line((0.0, 0.0), TOP), line(TOP, (1.0, 0.0))], [0.0, 0.4, 1.0]),
    "a crest that is cut off": ([PARABOLA, line((0.4, 0.96), (1.0, 0.0))], [0.0, 0.4, 1.0]),
    "a level": ([line((0.0, 0.0), (0.2, 0.3)), Polynomial([0.3]), line((0.7, 0.3), (1.0, 0.0))],
                [0.0, 0.2, 0.7, 1.0]),
    "the first of two crests": ([waves(2.0, -1.0)], [0.0, 1.0]),
    "the last of two crests": ([waves(2.0, 2.0)], [0.0, 1.0]),
    "the last of three crests": ([waves(-3.0, 3.0)], [0.0, 1.0]),
    "the middle one of three crests": ([waves(-3.0, 0.2)], [0.0, 1.0]),
    "crests on two pieces": ([waves(2.0, 2.0)] * 2, [0.0, 0.5, 1.0]),
    "a rise behind the crest": ([waves(2.0, 2.0), line((0.45, 2.0), (1.0, 0.0))],
                                [0.0, 0.45, 1.0]),
}  # fmt: skip


def panel(gap: Gap, begin: float, end: float, stop: Stop, *, integrated: bool) -> Panel:
    t = begin + (end - begin) * nodes(24).sigma
    q = stop.at + stop.sense * gap(t)
    v, a = stop.sense * gap.deriv()(t), stop.sense * gap.deriv(2)(t)
    shape = (len(t), 1)
    return Panel(begin, end - begin, *(np.broadcast_to(x, t.shape).reshape(shape)
                 for x in (q, v, a)), Partition.of([], 1), integrated=integrated)  # fmt: skip


@cache
def highest(name: str) -> float:
    """That of a fine grid: it lies at most 5e-6 s beside a crest, whose curvature is below 500."""
    gaps, times = GAPS[name]
    return max(float(gap(np.linspace(t, end, 100_001)).max())
               for gap, (t, end) in zip(gaps, pairwise(times), strict=True))  # fmt: skip


@pytest.mark.parametrize(("panels", "beyond"), [(1, 0.0), (1, 0.4), (3, 0.4)])
@pytest.mark.parametrize("integrated", [True, False])
@pytest.mark.parametrize("stop", [LOWER, UPPER], ids=["lower", "upper"])
@pytest.mark.parametrize("name", GAPS)
def test_the_highest_point_of_a_rebound(
    name: str, stop: Stop, integrated: bool, panels: int, beyond: float
) -> None:
    """Also where the last panel of each piece reaches beyond it."""
    gaps, times = GAPS[name]
    segments = []
    for gap, (begin, end) in zip(gaps, pairwise(times), strict=True):
        edges = np.linspace(begin, end, panels + 1)
        edges[-1] += beyond * (end - begin)
        parts = (panel(gap, *edge, stop, integrated=integrated) for edge in pairwise(edges))
        closed: frozenset[str] = frozenset()
        segments.append(Segment(begin, end, closed, tuple(parts), kinematic=not integrated))

    def event(number: int, t: float) -> Any:
        return SimpleNamespace(
            number=number, t=t, kind=EventKind.COLLISION, stops=("floor",), P_N={"floor": 1.0},
            v_after=np.array([stop.sense]), q=np.zeros(1), source=number,
        )  # fmt: skip

    events: Any = [event(1, 0.0), event(2, 1.0)]
    case = Case(speed_rpm=60.0)
    system: Any = SimpleNamespace(mechanism=SimpleNamespace(stop=lambda _: stop))
    found = Rebounds(system, segments, events, case).amplitude(events[0], "floor")
    assert found == pytest.approx(highest(name), rel=1e-8)
