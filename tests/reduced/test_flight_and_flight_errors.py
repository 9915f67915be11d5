"""Flights of known equations of motion, judged by a Runge-Kutta method of high order."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.integrate import quad, solve_ivp
from written_tables import bounded, level, linear, tables_of, work_of, x_dd

from nipper_pin.reduced.kernels import arrival_check, flight, flight_errors
from nipper_pin.reduced.kernels.grids import grids
from nipper_pin.reduced.kernels.layout import (
    AT_REST,
    BY_U,
    BY_V,
    BY_X,
    LEFT_GAP,
    LEFT_TRAVEL,
    OTHER_STOP,
    RESIDUAL,
    UNRESOLVED,
    Tables,
)
from nipper_pin.tolerances.mechanics import EPS

pytestmark = pytest.mark.usefixtures("plain")

SPEED, GRAVITY, SPRINGS = 3.0, 0.8, [(40.0, 0.05)]
LOW, HIGH, TRAVEL = -0.5, 2.0, 6.0


def by_u(function: Any, cells: int = 12, count: int = 12) -> Tables:
    """x'' = w^2 f(u) alone."""
    width = TRAVEL / cells
    equation = np.zeros((6, cells, count, 3))
    for cell in range(cells):
        middle = (cell + 0.5) * width
        series = chebyshev.chebinterpolate(
            lambda place, at=middle: function(at + 0.5 * width * place), count - 1
        )
        equation[0, cell, :, 0] = series
    return tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL)


def mixture() -> Tables:
    """All functions, all of them of travel and coordinate; two equal cells, so they are smooth."""
    equation = np.zeros((6, 1, 4, 3))
    equation[:] = 0.04 * np.random.default_rng(4).normal(size=equation.shape)
    equation[0, :, 0, 0], equation[3, :, 0, 0], equation[4, :, 0, 0] = -0.8, -1.0, -1.0
    equation[5, :, 0] -= linear(0.3, LOW, HIGH)
    return tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL)


def spring() -> Tables:
    equation = level(-0.2, -0.1)
    equation[0, :, 0] -= linear(1.5, LOW, HIGH)
    return tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL)


FLIGHTS = {
    "ballistic": (tables_of(level(-1.0), low=LOW, high=HIGH, travel=TRAVEL), 0.5, 0.0, 2.0),
    "spring": (spring(), 0.0, 0.0, 3.0),
    "falling": (spring(), 0.0, 0.8, -1.0),
    "thrown": (spring(), 0.2, 0.8, 1.0),
    "all": (mixture(), 0.0, 0.0, 3.0),
    "small": (mixture(), 0.4, 0.0, 1e-3),
    "several panels": (by_u(lambda u: -1.0 + 2.5 * np.sin(5.0 * u)), 0.7, 0.0, 4.0),
    "left behind": (by_u(lambda u: 0.3 * (u - 0.5) * np.exp(-u)), 0.5, 0.0, 0.0),
    "not back": (by_u(lambda u: -0.05 + 0.0 * u), 2.0, 0.0, 0.9),
}


def solved(tables: Tables, u: float, x: float, v: float) -> Any:
    """The same motion: dense output, and its time."""

    def rates(t: float, state: Any) -> list[float]:
        return [
            state[1],
            x_dd(tables, u + SPEED * t, state[0], state[1], SPEED, GRAVITY, SPRINGS),
        ]

    def closes(t: float, state: Any) -> float:
        return float(state[0]) if t > 1e-5 else 1.0

    closes.terminal, closes.direction = True, -1.0  # type: ignore[attr-defined]
    whole = (TRAVEL - u) / SPEED
    found = solve_ivp(
        rates, (0.0, whole), [x, v], "DOP853", events=closes, dense_output=True,
        rtol=3e-14, atol=1e-15, max_step=0.05 * whole,
    )  # fmt: skip
    return found.sol, float(found.t[-1]), bool(found.t_events[0].size)


def flown(tables: Tables, u: float, x: float, v: float, tolerance: float) -> Any:
    work = work_of(tables)
    k, p = np.array(SPRINGS).T
    arrival_check.prepare(tables, work, SPEED, GRAVITY, k, p)
    found = flight.flight(
        grids(), work.case, work.mixed, work.poly, work.nodes, tables.equation.shape[3], u, x, v,
        tolerance, x == 0.0,
    )  # fmt: skip
    return found, work


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
@pytest.mark.parametrize("name", FLIGHTS)
def test_every_number_of_a_flight(name: str, tolerance: float) -> None:
    """Time, rate, amplitude, its time, acceleration at the end and fastest rate; stated errors."""
    tables, u, x, v = FLIGHTS[name]
    tables = bounded(tables)
    found, work = flown(tables, u, x, v, tolerance)
    status, T, rate, top, peak, a, fastest, changed, left, last, hit = found
    assert hit == -1.0
    motion, end, back = solved(tables, u, x, v)
    assert status == (AT_REST if back else LEFT_TRAVEL)
    duration, wrong, height = flight_errors.flight_errors(
        work.sizes, SPEED, T, rate, a, peak, fastest, changed, left, 0.0, 0.0
    )
    judged = 1e-11
    assert duration <= 1e3 * tolerance * max(T, 1.0) or name == "small"
    assert abs(T - end) <= 4.0 * duration + judged * end
    assert abs(rate - motion(end)[1]) <= 4.0 * wrong + judged * max(abs(rate), fastest)
    times = np.linspace(0.0, end, 4001)
    path, rates = motion(times)
    if back:
        expected = x_dd(tables, u + SPEED * end, 0.0, motion(end)[1], SPEED, GRAVITY, SPRINGS)
        assert a == pytest.approx(expected, rel=1e4 * tolerance + 1e-9, abs=1e-9)
        assert top == pytest.approx(path.max(), rel=1e4 * tolerance + 1e-6)
        assert abs(peak - times[path.argmax()]) <= 2.0 * end / 4000.0
        slope = motion(peak)[1]
        assert peak == 0.0 or abs(slope) <= (1e4 * tolerance + 1e-8) * fastest
        best = motion(peak)[0]
        assert abs(top - best) <= 4.0 * height + judged * best
    else:
        assert pytest.approx((TRAVEL - u) / SPEED, rel=1e-12) == T
        assert last == pytest.approx(motion(end)[0], rel=1e4 * tolerance + 1e-9)
        assert top <= last * (1.0 + 1e-9)
    largest = np.abs(rates).max()
    # Between nodes it may be a little larger, and panels end a little behind the flight.
    assert 0.95 * largest <= fastest <= 1.1 * largest
    assert 0.0 <= changed <= tolerance * 1e3
    assert 0.0 < left <= tolerance * 1e3


@pytest.mark.parametrize(
    ("high", "gap", "expected"),
    [(0.3, 1.0, LEFT_GAP), (2.0, -1.0, OTHER_STOP), (2.0, 1.0, AT_REST)],
)
def test_ends_of_a_flight(high: float, gap: float, expected: int) -> None:
    """Too high: its other numbers are zero; or another stop is closed already: it ends at once."""
    gaps = np.zeros((1, 1, 3, 3))
    gaps[0, 0, 0, 0] = gap
    tables = tables_of(level(-1.0), gaps=gaps, low=LOW, high=high, travel=TRAVEL)
    found, _ = flown(tables, 0.5, 0.0, 3.0, 1e-9)
    assert found[0] == expected
    if expected == LEFT_GAP:
        assert found[1:] == (*[0.0] * 9, -1.0)
    if expected == OTHER_STOP:
        assert found[1] == pytest.approx(0.0, abs=1e-15)
        assert found[10] == 0.0


@pytest.mark.parametrize(("jump", "expected"), [(-1e9, UNRESOLVED), (1e9, LEFT_GAP)])
def test_a_motion_that_no_panel_follows(jump: float, expected: int) -> None:
    """A jump of x'' by travel; one that throws the motion out of the tables is such a motion."""
    equation = level(-1.0, cells=2)
    equation[0, 1, 0, 0] = jump
    tables = tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL)
    assert flown(tables, 2.9999, 0.0, 3.0, 1e-12)[0] == (expected, *[0.0] * 9, -1.0)


def sizes() -> Any:
    """Bounds by residuals, slopes and largest values, and the polynomials that they have to give.

    Polynomials of the rate v: w^2 F0 + w F1 v + F2 v^2 + |g| Fg + |k| (|p| F_k + F_ks).
    """
    random = np.random.default_rng(8)
    rows = {
        name: random.uniform(0.1, 1.0, 6)
        for name in ("residual", "steepest_x", "steepest_u", "largest")
    }
    found = np.zeros((4, 3))
    k, p = np.array([40.0]), np.array([-0.05])
    flight_errors.sizes_of(tables_of(level(-1.0), **rows), found, SPEED, -0.8, k, p)

    def bound(name: str, v: float) -> float:
        f = rows[name]
        still = SPEED**2 * f[0] + 0.8 * f[3] + 40.0 * (0.05 * f[4] + f[5])
        return float(still + SPEED * f[1] * v + f[2] * v**2)

    def by_rate(v: float) -> float:
        f = rows["largest"]
        return float(SPEED * f[1] + 2.0 * f[2] * v)

    return found, bound, by_rate


def test_bounds_of_a_case() -> None:
    """Of x'' itself, its slopes by coordinate and travel, and its derivative by the rate."""
    found, bound, by_rate = sizes()
    for v in (0.0, 0.3, 2.0):
        for row, name in ((RESIDUAL, "residual"), (BY_X, "steepest_x"), (BY_U, "steepest_u")):
            assert flight_errors.size(found, row, v) == pytest.approx(bound(name, v), rel=1e-14)
        assert flight_errors.size(found, BY_V, v) == pytest.approx(by_rate(v), rel=1e-14)


@pytest.mark.parametrize("a", [-40.0, -13.0, -60.0, -3.0, 8.0])
@pytest.mark.parametrize(("dt", "dw"), [(0.0, 0.0), (1e-7, 0.0), (0.0, 1e-6), (1e-6, 1e-5)])
@pytest.mark.parametrize("given", [(0.0, 0.0), (1e-5, 0.0), (0.0, 1e-5)])
def test_errors_at_the_end_of_a_flight(
    a: float, dt: float, dw: float, given: tuple[float, float]
) -> None:
    """The formula of ``build`` with its integral by quadrature."""
    found, bound, by_rate = sizes()
    T, v, peak, fastest = 0.09, -1.8, 0.04, 2.0
    changed, left = given
    F = by_rate(fastest) * T + 0.5 * bound("steepest_x", fastest) * T**2
    K, rho = math.exp(F), a * T / v
    shifted = SPEED * bound("steepest_u", fastest) * dt
    steady = F * changed + bound("residual", fastest)
    whole = steady + shifted + left
    lever = quad(lambda s: abs(1.0 - rho * s), 0.0, 1.0, points=[min(max(1.0 / rho, 0.0), 1.0)])[0]
    even = min(abs(1.0 - 0.5 * rho) + 4.0 * SPEED * T * lever, lever)
    duration, rate, height = flight_errors.flight_errors(
        found, SPEED, T, v, a, peak, fastest, changed, left, dt, dw
    )
    expected = K * (dw * T + 0.5 * whole * T**2) / abs(v) + 4.0 * EPS * T
    assert duration == pytest.approx(expected, rel=1e-9)
    expected = (abs(1.0 - rho) + (K - 1.0) * (1.0 + abs(rho))) * dw
    expected += K * T * (steady * lever + shifted * even + left) + 4.0 * EPS * abs(v)
    assert rate == pytest.approx(expected, rel=1e-7)
    assert height == pytest.approx(K * (dw * peak + 0.5 * whole * peak**2), rel=1e-9)


@pytest.mark.parametrize(("w", "ahead"), [(1e-4, 1e-4), (1e-3, 1e-5), (2.0, 3.0)])
def test_what_is_ahead_of_a_series_drifts(w: float, ahead: float) -> None:
    """x'' changes by its slopes times what is left of time, height and rate; no more than all."""
    found, bound, by_rate = sizes()
    a = -30.0
    change = SPEED * ahead * bound("steepest_u", w) + 2.0 * w * by_rate(w)
    change += w**2 / (2.0 * 30.0) * bound("steepest_x", w)
    drift = flight_errors.drift(found, SPEED, w, a, ahead)
    assert drift == pytest.approx(min(3.0 * change / 30.0, 1.0), rel=1e-12)


def test_without_any_errors_round_off_is_left() -> None:
    """Four units of it, of the time and of the rate."""
    found = flight_errors.flight_errors(
        np.zeros((4, 3)), SPEED, 0.1, -2.0, -40.0, 0.05, 2.0, 0.0, 0.0, 0.0, 0.0
    )
    assert found == (4.0 * EPS * 0.1, 4.0 * EPS * 2.0, 0.0)


def test_another_stop_may_be_closed_where_the_flight_begins() -> None:
    """It opens with the collision: its gap is zero there, and counts from the first node on."""
    gaps = np.zeros((1, 1, 3, 3))
    gaps[0, 0, 0, 0], gaps[0, 0, 1, 0] = 0.3 * (0.5 * TRAVEL - 0.5), 0.3 * 0.5 * TRAVEL
    tables = tables_of(level(-1.0), gaps=gaps, low=LOW, high=HIGH, travel=TRAVEL)
    assert flown(tables, 0.5, 0.0, 3.0, 1e-9)[0][0] == AT_REST
    assert flown(tables, 0.5, 0.1, 3.0, 1e-9)[0][0] == OTHER_STOP
