"""Transitions on tables with constant x'': every row, every stated error, every way to end."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from written_tables import (
    bounce,
    case,
    level,
    rest_of_turn,
    solve,
    tables_of,
    with_bounds,
    with_numbers,
)

from nipper_pin.reduced import ReducedTransition
from nipper_pin.reduced.kernels import flight_errors
from nipper_pin.reduced.kernels import series as bounces
from nipper_pin.reduced.kernels.layout import (
    AMPLITUDE,
    AMPLITUDE_ERROR,
    APPROACH,
    AT_REST,
    COLLISION,
    COLUMNS,
    ENERGY,
    ENERGY_ERROR,
    FAILS,
    HIGH,
    HOLDS,
    IMPULSE,
    IMPULSE_ERROR,
    KIND,
    LEFT_TRAVEL,
    NOT_PRESSED,
    OTHER_STOP,
    RATE_ERROR,
    REBOUND,
    REBOUND_ERROR,
    SEPARATION,
    STOP,
    TIME,
    TIME_ERROR,
    TOO_MANY,
    TRAVEL,
    UNKNOWN,
    UNTOLD,
    Settings,
)

pytestmark = pytest.mark.usefixtures("plain")

# x'' = -A at this speed; the springs and gravity have the same size and cancel.
SPEED, A, RATE = 2.0, 12.0, -1.2
K, P = np.array([300.0]), np.array([0.02])
EQUATION = level(-0.25 * A, 0.0, 0.0, 6.0, -1.0, 0.0)
TABLES: dict[str, Any] = {
    "travel": 5.0, "approach": RATE, "lever": 0.3,
    "residual": np.array([1e-7, 0.0, 0.0, 0.0, 0.0, 0.0]), "approach_residual": 3e-8,
    "inertia_residual": 2e-7, "inertia": np.array([[0.7, 0.02, 0.003]]), "low": -0.1, "high": 1.0,
}  # fmt: skip
E_N, WAITING_E_N, ANGLE = 0.45, 0.5, (0.4, -1.0)


def run(
    charts: Any = None,
    *,
    e: float = E_N,
    rest_rate: float = 0.0,
    most: int = 24,
    turn: Any = None,
    assumed: bool = True,
) -> Any:
    """One transition: its status, its summary, its premise and its table."""
    if charts is None:
        charts = tables_of(EQUATION, **TABLES)
    if charts.stops.shape[1] == 2:
        # A second stop that closes nowhere.
        charts = charts._replace(stops=np.array([[0, 0, 1]]))
    cases = np.concatenate([[SPEED, e, WAITING_E_N], K, P])[None]
    settings = Settings(rest_rate, 1e-9)
    asked = None if assumed else solve(turn, cases, settings, 0, ask=True)
    found = solve(charts, cases, settings, most, angle=ANGLE, before=asked)
    table, told = found
    status, count, premise = told[0]
    if turn is None:
        premise = UNKNOWN
    else:
        premise = solve(turn, cases, settings, 0, ask=True, before=found)[1][0, 2]
    assert np.isnan(table[0, count:-1]).all()
    return status, summary(table[0, -1], table[0, :count]), premise, table[0, :count].T


def summary(rest: Any, collisions: Any) -> Any:
    """What is told of a rest."""
    found = ReducedTransition("", rest, collisions.T, list, len(collisions))
    return found.duration, found.duration_error, found.share, found.error_bound


def expected(count: int) -> dict[int, Any]:
    """All rows of the collisions in closed form, and their errors from one flight to the next."""
    n = np.arange(count)
    before = RATE * SPEED * E_N**n
    w = -E_N * before
    T = 2.0 * w / A
    t = np.concatenate([[0.0], np.cumsum(T)[:-1]])
    u = SPEED * t
    C = chebyshev.chebval(2.0 * u / 5.0 - 1.0, TABLES["inertia"][0])
    sizes = np.zeros(12)
    (bounds,) = tables_of(EQUATION, **TABLES).bounds
    flight_errors.sizes_of(bounds, sizes, case(SPEED, K, P))
    dt, dv = np.zeros(count), np.zeros(count)
    duration, height = np.zeros(count), np.zeros(count)
    dv[0] = 3e-8 * SPEED
    for i in range(count):
        duration[i], rate, height[i] = flight_errors.flight_errors(
            sizes, SPEED, bounce(T[i], -w[i], -A, 0.5 * T[i], w[i]), dt[i], E_N * dv[i]
        )
        if i + 1 < count:
            dt[i + 1], dv[i + 1] = dt[i] + duration[i], rate
    relative = 2e-7 + SPEED * dt / 5.0
    about = dv + np.abs(before) * relative
    return {
        KIND: COLLISION + 0.0 * t, STOP: 0.0 * t,
        TIME: t, TRAVEL: 0.4 - u, APPROACH: before, SEPARATION: w,
        IMPULSE: C * (1.0 + E_N) * np.abs(before) / 0.3,
        ENERGY: 0.5 * C * (1.0 - E_N**2) * before**2,
        AMPLITUDE: 0.5 * w**2 / A, REBOUND: T,
        TIME_ERROR: dt, RATE_ERROR: dv, REBOUND_ERROR: duration, AMPLITUDE_ERROR: height,
        IMPULSE_ERROR: C * (1.0 + E_N) * about / 0.3,
        ENERGY_ERROR: C * (1.0 - E_N**2) * (np.abs(before) * about + dv**2),
    }  # fmt: skip


def test_every_row_of_a_transition_and_its_errors() -> None:
    """Rest comes at the sum of the series; what is stated of it is the error of what was left."""
    status, (rest, error, share, bound), premise, table = run()
    count = table.shape[1]
    assert (status, premise) == (AT_REST, UNKNOWN)
    # A limit is looked for from a thousandth of the fastest rebound on: 0.45^9.
    assert count == 10
    rows = expected(count)
    assert sorted(rows) == list(range(COLUMNS))
    for row, values in rows.items():
        wrong = row >= TIME_ERROR
        np.testing.assert_allclose(
            table[row], values, rtol=1e-5 if wrong else 1e-12, atol=1e-15, err_msg=str(row)
        )
    whole = 2.0 * -RATE * SPEED * E_N / (A * (1.0 - E_N))
    assert rest == pytest.approx(whole, rel=1e-12)
    ahead = whole - table[TIME, -1]
    relative = E_N * rows[RATE_ERROR][-1] / rows[SEPARATION][-1]
    assert error == pytest.approx(rows[TIME_ERROR][-1] + ahead * relative, rel=1e-3)
    assert share == pytest.approx(rows[TIME][2] / whole, rel=1e-12)
    worst = max(
        error / whole, rows[AMPLITUDE_ERROR][0] / rows[AMPLITUDE][0],
        *(rows[REBOUND_ERROR] / rows[REBOUND])[:2],
    )  # fmt: skip
    assert bound == pytest.approx(worst, rel=1e-3)


@pytest.mark.parametrize("worst", range(4))
def test_the_worst_relative_error_of_a_transition(worst: int) -> None:
    """Of its duration, its amplitude and the times of its first two rebounds."""
    errors = np.array([1e-9, 2e-9, 3e-9, 4e-9])
    errors[worst] = 7e-9
    table = np.zeros((4, COLUMNS))
    table[:2, REBOUND], table[0, AMPLITUDE] = (0.02, 0.01), 2e-3
    table[2:, TIME] = 0.03, 0.04
    table[3, TIME_ERROR], table[0, AMPLITUDE_ERROR] = errors[:2] * (0.04, 2e-3)
    table[:2, REBOUND_ERROR] = errors[2:] * (0.02, 0.01)
    found = 0.04, table[3, TIME_ERROR], 0.75, 7e-9
    assert summary(table[3], table[:3]) == pytest.approx(found, rel=1e-12)


def test_a_series_that_is_nearly_over_is_closed_by_its_sum() -> None:
    """Two thousandth parts of what the limit needs: no extrapolation, and the same time of rest."""
    tables = tables_of(EQUATION, **{**TABLES, "approach": -1e-8, "approach_residual": 0.0})
    status, (rest, error, share, _), _, table = run(tables)
    assert (status, table.shape[1]) == (AT_REST, 1)
    assert math.isnan(share)
    assert rest == pytest.approx(2.0 * 1e-8 * SPEED * E_N / (A * (1.0 - E_N)), rel=1e-7)
    assert 0.0 <= error < rest
    # Four times as much is ahead: more than a turn times the tolerance.
    assert run(with_numbers(tables, arrive=-4e-8))[3].shape[1] > 1
    # With slopes x'' changes during the rest of the series, which is stated.
    steep = with_bounds(tables, steepest_u=np.full(6, 1e5))
    _, (_, more, _, _), _, _ = run(steep)
    assert more > 0.5 * rest


def test_the_limit_under_a_force_that_grows() -> None:
    """x'' = -A (1 + u / 2): each bounce is a cubic, followed here until nothing is left."""
    equation = EQUATION.copy()
    equation[0, 0, 0, 0], equation[0, 0, 1, 0] = -0.25 * A * 2.25, -0.25 * A * 1.25
    status, (rest, error, *_), _, table = run(tables_of(equation, **TABLES))
    t, w = 0.0, -RATE * SPEED * E_N
    while w > 1e-14:
        a = -A * (1.0 + 0.5 * SPEED * t)
        # w + a T / 2 - A T^2 / 6 = 0.
        flight = np.roots([-A / 6.0, 0.5 * a, w])
        T = float(flight[flight > 0.0].real.min())
        t, w = t + T, -E_N * (w + a * T - 0.5 * A * T**2)
    assert status == AT_REST
    assert rest == pytest.approx(t, rel=1e-8)
    assert abs(rest - t) <= error < 1e-6
    assert table.shape[1] < 16


def test_another_stop_may_be_closed_at_the_touch_only() -> None:
    """The gap of the other stop grows with the travel from zero; it counts from then on."""
    gaps = np.zeros((1, 1, 3, 3))
    gaps[0, 0, 0, 0] = gaps[0, 0, 1, 0] = 0.3
    assert run(tables_of(EQUATION, gaps=gaps, **TABLES))[0] == AT_REST
    gaps[0, 0, 0, 0] -= 0.02
    assert run(tables_of(EQUATION, gaps=gaps, **TABLES))[0] == OTHER_STOP


def test_rest_by_a_rate() -> None:
    """It is the time of the first collision that leaves with less."""
    rows = expected(12)
    number = int(np.argmax(rows[SEPARATION] < 0.05))
    status, (rest, error, _, _), _, table = run(rest_rate=0.05)
    assert (status, table.shape[1]) == (AT_REST, number + 1)
    assert rest == pytest.approx(rows[TIME][number], rel=1e-12)
    assert error == pytest.approx(rows[TIME_ERROR][number], rel=1e-5)


@pytest.mark.parametrize("rest_rate", [0.0, 0.05])
def test_a_stop_that_is_pulled_open_does_not_rest(rest_rate: float) -> None:
    """However slow it is: it flies on, to the end of the travel."""
    tables = tables_of(level(0.02), **{**TABLES, "approach": -0.05})
    status, told, _, table = run(tables, rest_rate=rest_rate)
    assert status == LEFT_TRAVEL
    assert np.isnan(told).all()
    assert table.shape[1] == 1
    for row in (AMPLITUDE, REBOUND, AMPLITUDE_ERROR, REBOUND_ERROR):
        assert np.isnan(table[row, 0])
    assert table[SEPARATION, 0] == pytest.approx(0.1 * E_N)


@pytest.mark.parametrize(("a", "expected"), [(-3.0, AT_REST), (3.0, NOT_PRESSED)])
def test_without_rebound(a: float, expected: int) -> None:
    """The collision is all there is; a stop that nothing presses does not rest there."""
    tables = tables_of(level(a), **TABLES)
    status, (rest, error, share, bound), _, table = run(tables, e=0.0)
    assert status == expected
    assert table.shape[1] == 1
    assert table[[TIME, SEPARATION, AMPLITUDE, REBOUND, AMPLITUDE_ERROR, REBOUND_ERROR], 0] == (
        pytest.approx(0.0)
    )
    assert table[ENERGY, 0] == pytest.approx(0.5 * 0.683 * (RATE * SPEED) ** 2)
    ends = (0.0, 0.0, 0.0) if a < 0.0 else (math.nan,) * 3
    assert (rest, error, bound) == pytest.approx(ends, nan_ok=True)
    assert math.isnan(share)


def test_bounces_without_loss_end_by_their_number() -> None:
    """All of them are in the table, and there is no rest."""
    status, summary, _, table = run(e=1.0, most=4)
    assert status == TOO_MANY
    assert np.isnan(summary).all()
    np.testing.assert_allclose(table[TIME], np.arange(4) * 2.0 * -RATE * SPEED / A, rtol=1e-12)
    assert not np.isnan(table).any()


def test_there_is_no_limit_of_one_bounce_or_of_growing_ones() -> None:
    series = np.array([[0.0, 1.0, 2.0], [0.5, 0.3, 0.3], [0.0, 0.0, 0.0]])
    assert np.isinf(bounces.limit(series, 1, 0.0)[:2]).all()
    assert np.isfinite(bounces.limit(series, 2, 0.0)[:2]).all()
    assert np.isinf(bounces.limit(series, 3, 0.0)[:2]).all()


@pytest.mark.parametrize(("opening", "push", "told"), [(4.0, -1.0, True), (4.0, 1.0, False),
                                                       (0.1, -1.0, False)])  # fmt: skip
def test_the_premise_needs_a_stop_that_is_pressed_until_the_opening(
    opening: float, push: float, told: bool
) -> None:
    """Else it is not known what the turn does; transitions are the same, assumed or not."""
    turn = rest_of_turn(level(-1.0), math.tau - opening, pressed=push)
    status, (rest, *_), premise, table = run(turn=turn)
    assert status == AT_REST
    assert premise == (HOLDS if told else UNKNOWN)
    again = run(turn=turn, assumed=False)
    assert (again[0], again[2]) == (AT_REST, premise)
    assert again[1][0] == rest
    np.testing.assert_array_equal(again[3], table)


def test_a_machine_that_arrives_in_flight_falls_onto_its_stop_first() -> None:
    """A body y that is thrown at the opening and is still up at the touch, with x = y / 2 + 0.01.

    Then x falls from there with x'' = -A: the first collision is late, by what a fall takes.
    """
    turn = rest_of_turn(level(-1.0), 0.5)
    status, (rest, *_), premise, table = run(turn=turn, assumed=False)
    assert (status, premise) == (AT_REST, FAILS)
    t, w, a = 0.5 / SPEED, 0.5 * 1.0 * SPEED, SPEED**2
    x = 0.01 + 0.5 * (w * t - 0.5 * a * t**2)
    v = 0.5 * (w - a * t) - 0.07 * SPEED
    fall = (v + math.sqrt(v * v + 2.0 * A * x)) / A
    assert table[TRAVEL, 0] == pytest.approx(0.4 - SPEED * fall, rel=1e-9)
    assert table[TIME, 0] == 0.0
    assert table[APPROACH, 0] == pytest.approx(v - A * fall, rel=1e-9)
    assert rest == pytest.approx(2.0 * (A * fall - v) * E_N / (A * (1.0 - E_N)), rel=1e-8)
    assert table[TIME_ERROR, 0] > 0.0
    assert table[RATE_ERROR, 0] > 0.0
    # As assumed it starts at the touch, and the verdict is the same; beyond the tables nothing is.
    assumed = run(turn=turn)
    assert (assumed[0], assumed[2]) == (AT_REST, FAILS)
    assert assumed[3][APPROACH, 0] == pytest.approx(RATE * SPEED)
    high = turn.numbers.copy()
    high[0, HIGH] = 0.9 * x
    assert run(turn=turn._replace(numbers=high), assumed=False)[0] == UNTOLD
    vague = rest_of_turn(level(-1.0), 0.5, residual=np.array([0.1, *[0.0] * 5]))
    told = run(turn=vague, assumed=False)
    assert (told[0], told[2]) == (UNTOLD, UNKNOWN)
