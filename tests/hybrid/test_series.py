"""The end of a bounce series: extrapolation of t(w) to w = 0."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin.hybrid.series import BounceSeries

T_REST = 1.25
EPS = float(np.finfo(float).eps)


def _series(e: float, bounces: int, first: float = 1.0) -> BounceSeries:
    """Collisions on the smooth curve t(w) = T_REST - 0.3 log(1 + w), rates nearly geometric."""
    series = BounceSeries("stop", T_REST - 0.3 * float(np.log1p(first)))
    w = first
    for _ in range(bounces):
        series = series.bounced(T_REST - 0.3 * float(np.log1p(w)), w)
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
    limit, error = series.limit()
    assert abs(limit - T_REST) <= 1e-13
    assert error <= 1e-13
    assert abs(series.times[-1] - T_REST) > 1e-9


@pytest.mark.parametrize("e", [0.05, 0.2, 0.5, 0.9])
def test_error_estimate_is_not_too_small(e: float) -> None:
    """At every length of the series the true error is of the order of the estimate or less.

    The estimate is the step between two orders, which the remainder of the lower one dominates;
    a factor of 10 covers its neighbours, and a few round-offs of the times the floor.
    """
    for bounces in range(3, 14):
        limit, error = _series(e, bounces, first=0.3).limit()
        assert abs(limit - T_REST) <= 10.0 * error + 8.0 * EPS * T_REST, bounces


def test_a_straight_line_is_met_by_two_points() -> None:
    """With t = t_rest - c w, the law of a bouncing ball, two collisions give the limit."""
    e, c = 0.5, 0.25
    series = BounceSeries("stop", 0.0)
    for w in (1.0, e):
        series = series.bounced(2.0 - c * w, w)
    limit, _ = series.limit()
    assert limit == pytest.approx(2.0, abs=4.0 * EPS * 2.0)


@pytest.mark.parametrize("rates", [[], [1.0], [1.0, 1.0], [0.5, 1.0], [1.0, 0.5, 0.6]])
def test_no_limit_while_the_rates_do_not_fall(rates: list[float]) -> None:
    """Too few collisions or rates that do not fall leave the end and its error infinite."""
    series = BounceSeries("stop", 0.0)
    for number, rate in enumerate(rates):
        series = series.bounced(0.1 * number, rate)
    assert series.limit() == (np.inf, np.inf)


def test_series_remembers_its_start_and_its_fastest_rate() -> None:
    """Old points are forgotten; start and fastest rate are not, and the series is not changed."""
    series = BounceSeries("stop", 0.25)
    longer = series
    for number in range(20):
        longer = longer.bounced(0.25 + number, 2.0**-number)
    assert series.times == ()
    assert longer.start == 0.25
    assert longer.fastest == 1.0
    assert longer.times[-1] == 19.25
    assert len(longer.times) == len(longer.rates) < 20
