"""Ends of series of bounces, of one stop and of two that keep throwing each other open."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from lid_box import DROP, GRAVITY, Numbers, followed, lid_box

from nipper_pin import Case, Event, EventKind, Outcome, Resolution, Solution, Window, simulate
from nipper_pin.hybrid.contact.bounce_series import BounceSeries, NestedSeries
from nipper_pin.hybrid.run.series.bounces import lowest_gap

T_REST = 1.25
EPS = float(np.finfo(float).eps)


def series_of(e: float, bounces: int, first: float = 1.0) -> BounceSeries:
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


@pytest.mark.parametrize(("e", "enough"), [(0.05, 6), (0.2, 9), (0.5, 16), (0.9, 90)])
def test_limits_of_a_smooth_series(e: float, enough: int) -> None:
    """At every length the true error is of the order of the estimate; with enough it is 1e-13.

    The estimate is the step between two orders, which the remainder of the lower one dominates;
    a factor of 10 covers its neighbours, and a few round-offs of the times the floor. Round-off is
    amplified by the sum of the Lagrange weights at w = 0, about 30 for e = 0.5 and 1e4 for 0.9,
    so that the best of the orders is returned and not the highest. The times end far from the rest.
    """
    for bounces in range(3, 14):
        limit, error = series_of(e, bounces, first=0.3).limit(e)
        assert abs(limit - T_REST) <= 10.0 * error + 8.0 * EPS * T_REST, bounces
    series = series_of(e, enough)
    limit, error = series.limit(e)
    assert abs(limit - T_REST) <= 1e-13
    assert error <= 4e-13
    assert abs(series.times[-1] - T_REST) > 1e-9
    assert series.limit(1.0) == (np.inf, np.inf)


@pytest.mark.parametrize("rates", [[1.0, 0.5], [1.0, 1.0, 0.5], [0.5, 1.0, 0.2], [1.0, 0.5, 0.6]])
def test_no_limit_while_the_rates_do_not_fall(rates: list[float]) -> None:
    """Nor where a deceleration passes zero before the limit."""
    series = passing = BounceSeries("stop", 0.0)
    for number, rate in enumerate(rates):
        series = series.bounced(0.1 * number, rate, 1.0)
    for w in (1.0, 0.5, 0.25):
        passing = passing.bounced(-w, w, w - 0.1)
    assert series.limit(0.5) == passing.limit(0.5) == (np.inf, np.inf)


def struck(times: list[float], rates: list[float]) -> NestedSeries:
    series = NestedSeries()
    for t, rate in zip(times, rates, strict=True):
        series = series.struck(t, rate)
    return series


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.9])
def test_limit_of_a_smooth_function_of_the_rate(ratio: float) -> None:
    """Times 2 - 3 w + w^2 - w^3 / 2 of rates that fall by a factor end at 2, within the error.

    The last time is off by 3 w, seven orders of magnitude more than what is asked for.
    """
    count = math.ceil(math.log(1e-4) / math.log(ratio))
    rates = [ratio**n for n in range(count)]
    t, error = struck([2.0 - 3.0 * w + w * w - 0.5 * w**3 for w in rates], rates).limit()
    assert abs(t - 2.0) <= error
    assert error < 1e-11


def test_no_limit_without_a_series() -> None:
    """Too few collisions, rates that do not fall, and those of turns that resemble one another.

    A machine that settles collides once a turn at rates that fall by less and less: they would
    extrapolate to somewhere, but not to where a series with such steps could end.
    """
    assert struck([0.0, 1.0, 1.5], [1.0, 0.5, 0.25]).limit() == (math.inf, math.inf)
    again = struck([0.0, 1.0, 1.5, 1.75, 5.0], [1.0, 0.5, 0.25, 0.125, 0.125])
    assert (again.times, again.start, again.fastest) == ((5.0,), 5.0, 0.125)
    turns = np.arange(12.0)
    t, error = struck(turns.tolist(), (1.0 + 0.5**turns).tolist()).limit()
    assert t == math.inf or error > 0.1


BOTH = {"floor", "lid"}

CASE = {"speed_rpm": 60.0, "window": Window.CYCLE}


@cache
def run(numbers: Numbers, stiffness: float = 0.0, **case: object) -> Solution:
    return simulate(lid_box(numbers, stiffness), Case(**{**CASE, **case}))  # type: ignore[arg-type]


def rest_of(solution: Solution) -> Event:
    """The event that closes the second stop for good."""
    (event,) = (
        event
        for event in solution.events
        if event.kind is EventKind.REST and set(event.closed_after) == BOTH
    )
    assert solution.outcome is Outcome.COMPLETED
    assert solution.events[-1] is event
    return event


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "numbers",
    [
        (1.0, 1.0, 0.0, 0.0, 30.0),
        (1.0, 1.0, 0.3, 0.3, 30.0),
        (1.0, 2.0, 0.2, 0.0, 60.0),
        (1.0, 0.5, 0.0, 0.3, 30.0),
    ],
)
def test_rest_in_closed_form(numbers: Numbers) -> None:
    """While the inner series ends before the other stop is back, the time has a closed form.

    Bounces at one stop do not show in the motion relative to them, so restitutions drop out: the
    mass is back at the lid after 2 w / alpha, throws the box up at r w, r = m / (M + m), which is
    back after 2 r w / g: a geometric series of both. Event times are computed to 1e-12 of a series
    that lasts some tenths of a second; the last collision that is followed lies more than 1e-6 s
    before the end, so without the limit the time would be off by that.
    """
    box, mass, _, _, force = numbers
    w = math.sqrt(2.0 * GRAVITY * DROP)
    ratio, alpha = mass / (box + mass), force / mass - GRAVITY
    duration = (2.0 * w / alpha + 2.0 * ratio * w / GRAVITY) / (1.0 - ratio)
    solution = run(numbers)
    event = rest_of(solution)
    assert event.t == pytest.approx(w / GRAVITY + duration, abs=1e-11)
    assert event.t - solution.collisions[-1].t > 1e-6
    assert abs(event.t - w / GRAVITY - duration) <= 1e-15 + solution.errors[event.number - 1].time


@pytest.mark.slow
@pytest.mark.parametrize(
    "numbers",
    [(1.0, 0.3, 0.8, 0.8, 60.0), (1.0, 0.3, 0.6, 0.7, 60.0), (1.0, 1.0, 0.5, 0.2, 30.0)],
)
def test_rest_against_every_bounce(numbers: Numbers) -> None:
    """The same time as that of ten thousand bounces followed one by one in 60 digits.

    In the livelier boxes floor and lid are struck in turns many times before one of them comes to
    rest, and the closed form does not hold: the two differ by more than 1e-2 s.
    """
    solution = run(numbers)
    assert rest_of(solution).t == pytest.approx(followed(numbers), abs=1e-11)
    assert len(solution.collisions) < 500


def test_rest_where_the_forces_change() -> None:
    """With a linear spring the flights are not parabolas, and the series not geometric.

    With the box on the floor the mass swings about the spring's end: it is back at the lid after
    (2 / W) atan(W w / alpha), at the rate w that it left with, W^2 = k / m and alpha its
    acceleration at the lid. The sum is taken bounce by bounce to its last digit; it differs from
    the geometric one by 3 %.
    """
    numbers, stiffness = (1.0, 1.0, 0.0, 0.0, 30.0), 1200.0
    box, mass, _, _, force = numbers
    ratio, alpha = mass / (box + mass), force / mass - GRAVITY
    swing, w = math.sqrt(stiffness / mass), math.sqrt(2.0 * GRAVITY * DROP)
    t = w / GRAVITY
    parts = []
    for _ in range(200):
        parts += [2.0 / swing * math.atan(swing * w / alpha), 2.0 * ratio * w / GRAVITY]
        w *= ratio
    geometric = (2.0 * GRAVITY * t / alpha + 2.0 * ratio * t) / (1.0 - ratio)
    assert abs(math.fsum(parts) / geometric - 1.0) > 0.03
    assert rest_of(run(numbers, stiffness)).t == pytest.approx(t + math.fsum(parts), abs=1e-12)


def test_rest_does_not_depend_on_the_resolution() -> None:
    """With a linear spring and bounces, tolerances a hundred times apart give one time of rest."""
    numbers = (1.0, 0.7, 0.4, 0.3, 40.0)
    times = [
        rest_of(run(numbers, 900.0, resolution=Resolution(tolerance=tolerance))).t
        for tolerance in (1e-9, 1e-11, 1e-13)
    ]
    assert abs(times[0] - times[2]) < 1e-8
    assert abs(times[1] - times[2]) < 1e-10


def test_forces_at_rest_and_energy() -> None:
    """Both stops bear what statics says, and no energy is missing.

    At rest the floor carries both weights and the lid the spring less the weight of the mass. What
    is left out of the series counts as lost: the energy of the fall plus nothing else.
    """
    box, mass, _, _, force = numbers = (1.0, 0.7, 0.4, 0.3, 40.0)
    solution = run(numbers)
    event = rest_of(solution)
    forces = solution.trajectory.reactions(np.linspace(event.t + 1e-6, 0.99, 7)).stops
    np.testing.assert_allclose(forces["floor"], GRAVITY * (box + mass), rtol=1e-13)
    np.testing.assert_allclose(forces["lid"], force - GRAVITY * mass, rtol=1e-13)
    # The mass ends where it began, at the lid: all that is lost is the work of gravity.
    assert solution.energy.impact_losses == pytest.approx((box + mass) * GRAVITY * DROP, rel=1e-11)
    assert solution.checks.energy_balance < 1e-12


def test_a_stop_that_loses_nothing_has_no_limit() -> None:
    """With restitution 1 at the floor the lid alone loses energy, and no limit is taken.

    It is followed until its flights last no longer than the round-off of time, 1e-15 of a turn; of
    that it has lain still from then on.
    """
    solution = run((1.0, 1.0, 1.0, 0.3, 30.0), max_collisions=300)
    closings = [event for event in solution.events if "floor" in event.closed_after]
    assert solution.outcome is Outcome.COMPLETED
    assert "floor" in closings[0].stops
    assert closings[0].series_error == 0.0
    latest = [hit for hit in solution.collisions if "floor" in hit.event.stops]
    assert latest[-1].t == pytest.approx(closings[0].t, abs=1e-14)
    assert abs(latest[-1].approach_rate) < 1e-14 * abs(latest[0].approach_rate) * 10.0


def test_rest_by_a_rate() -> None:
    """With a threshold all stops rest as soon as none opens faster, and the time is short by that.

    What is left is proportional to the rate: 2 w (1 / alpha + r / g) / (1 - r) at most, of the
    collision at the floor that opens the lid at w.
    """
    numbers = (1.0, 1.0, 0.3, 0.3, 30.0)
    exact = rest_of(run(numbers)).t
    factor = 2.0 * (1.0 / (30.0 - GRAVITY) + 0.5 / GRAVITY) / 0.5
    for rate in (1e-2, 1e-3, 1e-4):
        event = rest_of(run(numbers, rest_rate=rate))
        assert 0.1 * factor * rate < exact - event.t < 2.0 * factor * rate


def test_a_box_that_is_not_pressed_down_comes_to_no_rest_together() -> None:
    """A mass too heavy for its spring leaves the lid for good: the lid is at rest nowhere."""
    solution = run((1.0, 1.0, 0.3, 0.3, 9.0))
    assert not any(set(event.closed_after) == BOTH for event in solution.events)


@pytest.mark.parametrize("rate", [-3e-3, -1e-4, 0.0, 2e-3])
@pytest.mark.parametrize("acceleration", [-20.0, 0.0, 18.0, 200.0])
def test_a_stop_that_a_gap_passes_on_the_way_is_met(rate: float, acceleration: float) -> None:
    """Found by case 2489 of seed 301: a link in a clearance of 4.4e-9 rad struck its other side.

    It left one stop at 2.8e-3 rad/s and was pressed back with 18 rad/s2, so that at the end of the
    time left, 3e-4 s, it would have been back; on its way it is 2e-7 rad further. The lowest point
    of the parabola is sampled here; what is found may be lower, where the gap goes on falling.
    """
    gap, left = 4.4193272225297254e-09, 3.07e-4
    t = np.linspace(0.0, left, 20001)
    sampled = float((gap + rate * t + 0.5 * acceleration * t**2).min())
    found = lowest_gap(gap, rate, acceleration, left)
    if acceleration <= 0.0 or rate < 0.0:
        assert found <= sampled + 1e-15
    if rate < 0.0 < acceleration:
        # The lowest sample is beside the lowest point by less than one of 1.6e-8 s.
        assert found == pytest.approx(sampled, rel=0.0, abs=1e-13)
    assert (found > 0.0) == (sampled > 0.0)
