"""The end of a bounce series: extrapolation of t(w) to w = 0."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nipper_pin.hybrid.contact.bounce_series import BounceSeries

T_REST = 1.25
EPS = float(np.finfo(float).eps)


def _series(e: float, bounces: int, first: float = 1.0) -> BounceSeries:
    """Collisions on the smooth curve t(w) = T_REST - 0.3 log(1 + w), rates nearly geometric.

    A stop with restitution e has dt/dw = -2 / (alpha (1 - e)) at rest: alpha is chosen to be so.
    """
    series = BounceSeries("stop", T_REST - 0.3 * float(np.log1p(first)))
    w = first
    for _ in range(bounces):
        alpha = 2.0 / (0.3 * (1.0 - e)) * float(np.cos(w))
        series = series.bounced(T_REST - 0.3 * float(np.log1p(w)), w, alpha)
        # No exact geometric series: the ratio itself depends smoothly on the rate.
        w *= e * (1.0 - 0.1 * (1.0 - e) * w)
    return series


@pytest.mark.parametrize("e", [0.05, 0.2, 0.5, 0.9])
def test_limit_converges_to_the_known_end(e: float) -> None:
    """The limit meets T_REST to 1e-13 once enough bounces are known, and says so.

    Taylor's remainder of m points is 0.3/m times the product of their rates; the round-off of the
    times is amplified by the sum of the Lagrange weights at w = 0, about 30 for e = 0.5 and 1e4
    for e = 0.9, which is why the best of the orders is returned and not the highest. The times
    themselves end far from T_REST (by 0.3 w), so the last time alone cannot pass.
    """
    bounces = {0.05: 6, 0.2: 9, 0.5: 16, 0.9: 90}[e]
    series = _series(e, bounces)
    limit, error = series.limit(e)
    assert abs(limit - T_REST) <= 1e-13
    assert error <= 4e-13
    assert abs(series.times[-1] - T_REST) > 1e-9


@pytest.mark.parametrize("e", [0.05, 0.2, 0.5, 0.9])
def test_error_estimate_is_not_too_small(e: float) -> None:
    """At every length of the series the true error is of the order of the estimate or less.

    The estimate is the step between two orders, which the remainder of the lower one dominates;
    a factor of 10 covers its neighbours, and a few round-offs of the times the floor.
    """
    for bounces in range(3, 14):
        limit, error = _series(e, bounces, first=0.3).limit(e)
        assert abs(limit - T_REST) <= 10.0 * error + 8.0 * EPS * T_REST, bounces


@pytest.mark.parametrize("e", [0.05, 0.2, 0.5])
@pytest.mark.parametrize("bounces", [3, 4, 5])
def test_the_known_slope_brings_the_limit_nearer(e: float, bounces: int) -> None:
    """The same collisions without their decelerations leave ten times the error.

    Without is Lagrange's extrapolation of the times alone, done here. A slope of the wrong sign or
    size would leave a larger error than none. The fastest rate lies before the series, so that no
    collision is too far away to count.
    """
    points = replace(_series(e, bounces, first=0.3), fastest=1.0)
    w = np.array(points.rates)
    weights = [np.prod(np.delete(w, i) / (np.delete(w, i) - w[i])) for i in range(bounces)]
    without = abs(float(np.dot(weights, points.times)) - T_REST)
    limit, _ = points.limit(e)
    assert abs(limit - T_REST) < max(0.1 * without, 4.0 * EPS)


def test_a_straight_line_is_met_by_three_points() -> None:
    """With t = t_rest - c w, the law of a bouncing ball, the limit is exact.

    Its deceleration g has 2 / (g (1 - e)) = c.
    """
    e, c = 0.5, 0.25
    series = BounceSeries("stop", 0.0)
    for w in (1.0, e, e * e):
        series = series.bounced(2.0 - c * w, w, 2.0 / (c * (1.0 - e)))
    limit, error = series.limit(e)
    assert limit == pytest.approx(2.0, abs=4.0 * EPS * 2.0)
    assert error <= 64.0 * EPS


def test_nothing_comes_to_rest_that_is_not_pressed_or_loses_nothing() -> None:
    """A deceleration that passes zero before the limit, or restitution one, has no end."""
    series = BounceSeries("stop", 0.0)
    for w in (1.0, 0.5, 0.25):
        series = series.bounced(-w, w, w - 0.1)
    assert series.limit(0.5) == (np.inf, np.inf)
    assert _series(0.5, 6).limit(1.0) == (np.inf, np.inf)


@pytest.mark.parametrize(
    "rates", [[], [1.0], [1.0, 0.5], [1.0, 1.0, 0.5], [0.5, 1.0, 0.2], [1.0, 0.5, 0.6]]
)
def test_no_limit_while_the_rates_do_not_fall(rates: list[float]) -> None:
    """Too few collisions or rates that do not fall leave the end and its error infinite."""
    series = BounceSeries("stop", 0.0)
    for number, rate in enumerate(rates):
        series = series.bounced(0.1 * number, rate, 1.0)
    assert series.limit(0.5) == (np.inf, np.inf)


def test_series_remembers_its_start_and_its_fastest_rate() -> None:
    """Old points are forgotten; start and fastest rate are not, and the series is not changed."""
    series = BounceSeries("stop", 0.25)
    longer = series
    for number in range(20):
        longer = longer.bounced(0.25 + number, 2.0**-number, 1.0)
    assert series.times == ()
    assert longer.start == 0.25
    assert longer.fastest == 1.0
    assert longer.times[-1] == 19.25
    assert len(longer.times) == len(longer.rates) < 20
