"""Flights of known equations of motion: by a Runge-Kutta method of high order, by closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Chebyshev, chebyshev
from scipy.integrate import quad, solve_ivp
from written_tables import bounce, bounded, case, level, linear, solver_of, tables_of, x_dd

from nipper_pin import Mechanism
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import rad_s_from_rpm
from nipper_pin.reduced.kernels import (
    flight,
    flight_errors,
    layout,
    panel,
    turn,
    turn_charts,
    turn_events,
    turn_quantities,
    turn_torques,
)
from nipper_pin.reduced.kernels.hits import SolvedPanel
from nipper_pin.reduced.kernels.layout import (
    AT_REST,
    BY_U,
    BY_V,
    BY_X,
    GROWTH,
    LEFT_GAP,
    LEFT_TRAVEL,
    LEVELS,
    NODE_A,
    NODE_V,
    NODE_X,
    OTHER_STOP,
    PROBES,
    RESIDUAL,
    SCRATCH_ROWS,
    SERIES_ONCE,
    SIGMA,
    UNRESOLVED,
    Charts,
    Motion,
    Settings,
    Solver,
)
from nipper_pin.reduced.kernels.panel import grids
from nipper_pin.reduced.turns import turn_model
from nipper_pin.tolerances.mechanics import EPS

pytestmark = pytest.mark.usefixtures("plain")

SPEED, SPRINGS = 3.0, [(40.0, 0.05)]
LOW, HIGH, TRAVEL = -0.5, 2.0, 6.0


def by_u(function: Any, cells: int = 12, count: int = 12) -> Charts:
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


def mixture() -> Charts:
    """All functions, all of them of travel and coordinate; one cell, so they are smooth."""
    equation = np.zeros((6, 1, 5, 3))
    equation[:, :, :4] = 0.04 * np.random.default_rng(4).normal(size=(6, 1, 4, 3))
    equation[:, 0, 4, 0] = 0.01
    equation[0, :, 0, 0], equation[3, :, 0, 0], equation[4, :, 0, 0] = -0.8, -1.0, -1.0
    equation[5, :, 0] -= linear(0.3, LOW, HIGH)
    return tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL)


def spring() -> Charts:
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


def solved(tables: Charts, u: float, x: float, v: float) -> Any:
    """The same motion: dense output, and its time."""

    def rates(t: float, state: Any) -> list[float]:
        return [
            state[1],
            x_dd(tables, u + SPEED * t, state[0], state[1], SPEED, SPRINGS),
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


def flown(tables: Charts, u: float, x: float, v: float, tolerance: float = 1e-10) -> Any:
    k, p = np.array(SPRINGS).T
    solver = solver_of(tables, case(SPEED, k, p))
    panel.contract(solver, 0, 0, u)
    found = flight.flight(solver, Motion(0, u, 0.0, x, v, 0.0, 0.0, 0.0), tolerance)
    return found, solver.work


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
@pytest.mark.parametrize("name", FLIGHTS)
def test_every_number_of_a_flight(name: str, tolerance: float) -> None:
    """Time, rate, amplitude, its time, acceleration at the end and fastest rate; stated errors."""
    tables, u, x, v = FLIGHTS[name]
    tables = bounded(tables)
    found, work = flown(tables, u, x, v, tolerance)
    status, T, rate, top, peak, a, fastest, changed, left, last, hit, _ = found
    assert hit == -1.0
    motion, end, back = solved(tables, u, x, v)
    assert status == (AT_REST if back else LEFT_TRAVEL)
    duration, wrong, height = flight_errors.flight_errors(work.sizes[0], SPEED, found, 0.0, 0.0)
    judged = 1e-11
    assert duration <= 1e3 * tolerance * max(T, 1.0) or name == "small"
    assert abs(T - end) <= 4.0 * duration + judged * end
    assert abs(rate - motion(end)[1]) <= 4.0 * wrong + judged * max(abs(rate), fastest)
    times = np.linspace(0.0, end, 4001)
    path, rates = motion(times)
    if back:
        expected = x_dd(tables, u + SPEED * end, 0.0, motion(end)[1], SPEED, SPRINGS)
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
    assert fastest >= max(abs(v), (1.0 - 1e-7) * abs(rate))
    assert 0.0 <= changed <= tolerance * 1e3
    assert 0.0 < left <= tolerance * 1e3


def test_a_flight_above_its_tables() -> None:
    """Too high: its other numbers are zero."""
    low = tables_of(level(-1.0), low=LOW, high=0.3, travel=TRAVEL)
    assert flown(low, 0.5, 0.0, 3.0, 1e-9)[0] == (LEFT_GAP, *[0.0] * 9, -1, False)


@pytest.mark.parametrize(("jump", "expected"), [(-1e9, UNRESOLVED), (1e9, LEFT_GAP)])
def test_a_motion_that_no_panel_follows(jump: float, expected: int) -> None:
    """A jump of x'' by travel; one that throws the motion out of the tables is such a motion."""
    equation = level(-1.0, cells=2)
    equation[0, 1, 0, 0] = jump
    tables = tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL)
    assert flown(tables, 2.9999, 0.0, 3.0, 1e-12)[0] == (expected, *[0.0] * 9, -1, False)


def test_accelerations_without_a_bound_are_no_flight() -> None:
    """A damping that grows with the rate: what overflows is within no tolerance of itself."""
    equation = 0.04 * np.random.default_rng(4).normal(size=(6, 1, 5, 3))
    equation[0, :, 0, 0], equation[3, :, 0, 0], equation[4, :, 0, 0] = -0.8, -1.0, -1.0
    equation[5, :, 0] -= linear(0.3, LOW, HIGH)
    tables = bounded(tables_of(equation, low=LOW, high=HIGH, travel=TRAVEL))
    assert flown(tables, 0.0, 0.0, 3.0, 1e-6)[0] == (UNRESOLVED, *[0.0] * 9, -1, False)


def sizes() -> Any:
    """Bounds by residuals, slopes and largest values, and the polynomials that they have to give.

    Polynomials of the rate v: w^2 F0 + w F1 v + F2 v^2 + Fg + |k| (|p| F_k + F_ks).
    """
    random = np.random.default_rng(8)
    rows = {
        name: random.uniform(0.1, 1.0, 6)
        for name in ("residual", "steepest_x", "steepest_u", "largest")
    }
    found = np.zeros(12)
    k, p = np.array([40.0]), np.array([-0.05])
    (bounds,) = tables_of(level(-1.0), **rows).bounds
    flight_errors.sizes_of(bounds, found, case(SPEED, k, p))

    def bound(name: str, v: float) -> float:
        f = rows[name]
        still = SPEED**2 * f[0] + f[3] + 40.0 * (0.05 * f[4] + f[5])
        return float(still + SPEED * f[1] * v + f[2] * v**2)

    def by_rate(v: float) -> float:
        f = rows["largest"]
        return float(SPEED * f[1] + 2.0 * f[2] * v)

    return found, bound, by_rate


def test_errors_that_were_traced() -> None:
    """They grow as told, twice; of the rate where x is zero by the time of that, too."""
    found, bound, by_rate = sizes()
    g = np.random.default_rng(3).normal(size=6)
    nodes = np.full((SCRATCH_ROWS, 8), np.nan)
    nodes[GROWTH, :6] = g
    T, fastest, dt, dx, dv = 0.01, 1.6, 1e-4, 2e-5, 3e-5
    felt = by_rate(fastest) * T + 0.5 * bound("steepest_x", fastest) * T**2
    e = felt * 1e-3 + 2e-3 + bound("residual", fastest) + SPEED * bound("steepest_u", fastest) * dt
    end, at = bounce(T, -1.4, -9.0, 0.005, fastest, 1e-3, 2e-3), Motion(0, 0, 0, 0, 0, dt, dx, dv)
    for bend in (0.0, 6.4):
        x = abs(g[0]) * dx + abs(g[1]) * dv + g[2] * e
        v = abs(g[3] - bend * g[0]) * dx + abs(g[4] - bend * g[1]) * dv + (g[5] + bend * g[2]) * e
        true = 2.0 * x, 2.0 * v + 4.0 * EPS * fastest
        off = turn_events.errors_after(nodes, found, SPEED, end, at, bend)
        assert off == pytest.approx(true, rel=1e-12)


def test_the_error_of_a_torque() -> None:
    """By those of its functions and of the motion; at rest x'' is zero, and surely so."""
    found, bound, by_rate = sizes()
    solver = solver_of(tables_of(level(-1.0)), case(SPEED, [40.0], [-0.05]))
    solver.work.sizes[0] = found
    torques = solver._replace(charts=solver.charts._replace(gap_bounds=np.array([[0.3, 0.7, 0.0]])))
    fastest, dt, dx, dv, da = 1.6, 1e-4, 2e-5, 3e-5, 5e-3
    off = bound("residual", fastest) + SPEED * dt * bound("steepest_u", fastest)
    off += dx * bound("steepest_x", fastest) + dv * by_rate(fastest)
    at = Motion(0, 0.0, 0.0, 0.0, 0.0, dt, dx, dv)
    for steepest, true in ((0.0, off), (9.0, off + 0.3 * 9.0 + 0.7 * (da + off))):
        wrong = turn_torques._wrong(solver, torques, 0, at, fastest, steepest, da)
        assert wrong == pytest.approx(true, rel=1e-12)


def kept_panels(e62: Mechanism, speed: float, tolerance: float) -> FloatArray:
    """Numbers of the panels of a turn, shape (panels, numbers)."""
    model = turn_model(e62, gap_scale=4.0)
    work, events = turn_charts.scratch(model.charts, 256), np.empty((320, layout.COLUMNS))
    records = turn_charts.records_in(events, 1, 320)
    one = turn_charts.case_of(model.charts, np.array([speed, *model.numbers[1:]]))
    solver = Solver(grids(), model.charts, work, one, records)
    turn_charts.prepare(solver, True)
    phase, at = turn_quantities.begun(model.begin, speed)
    turn.follow(solver, Settings(0.0, tolerance), 1, phase, at, model.clamp)
    return records.panels[: records.counts[layout.PANELS], layout.KEPT]


@pytest.mark.parametrize("speed_rpm", [650.0, 1100.0])
def test_panels_that_are_kept(e62: Mechanism, speed_rpm: float) -> None:
    """The first flights and rests begin where those of a much finer turn do, but for errors."""
    speed = rad_s_from_rpm(speed_rpm)
    rough, fine = (kept_panels(e62, speed, tolerance) for tolerance in (1e-5, 1e-13))
    kinds = {(chart, nodes > 0.0) for chart, nodes in rough[:, [flight.CHART, flight.NODES]]}
    assert len(kinds) >= 4
    for chart, flies in kinds:
        one, other = (
            found[(found[:, flight.CHART] == chart) & ((found[:, flight.NODES] > 0.0) == flies)][:2]
            for found in (rough, fine)
        )
        other = other[: len(one)]
        errors = (one + other)[:, [flight.T_WRONG, flight.X_WRONG, flight.V_WRONG]]
        off = np.abs(one - other)[:, [flight.FROM, flight.X_BEGIN, flight.V_BEGIN]]
        assert (off <= errors * (speed, 1.0, 1.0)).all()
        # Those of a flight hold all along it.
        assert not flies or (errors > 0.0).all()


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
        found, SPEED, bounce(T, v, a, peak, fastest, changed, left), dt, dw
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
        np.zeros(12), SPEED, bounce(0.1, -2.0, -40.0, 0.05, 2.0), 0.0, 0.0
    )
    assert found == (4.0 * EPS * 0.1, 4.0 * EPS * 2.0, 0.0)


@pytest.mark.parametrize("past", [0.2, 0.8])
def test_a_top_behind_the_end_of_a_flight_does_not_count(past: float) -> None:
    """x = s (2 p - s), whose top p lies between the end of the flight and the node behind that."""
    order, number = 2, 7
    places = grids()[SIGMA, order, 0]
    end = places[number] + 0.1 * (places[number + 1] - places[number])
    top = end + past * (places[number + 1] - end)
    solver = solver_of(tables_of(level(1.0)), case(SPEED, [], []))
    nodes = solver.work.nodes
    nodes[:] = 0.0
    nodes[NODE_X, : LEVELS[order]] = (places * (2.0 * top - places))[: LEVELS[order]]
    # Its rate, 2 (p - s), as a series on -1 to 1.
    nodes[SERIES_ONCE, :2] = 2.0 * top - 1.0, -1.0
    found = flight._highest(SolvedPanel(solver, 0, order, 0.0, 1.0, 0.0, 0.0), end)
    assert found == (nodes[NODE_X, number], places[number])


@pytest.mark.parametrize("depth", [1e-4, -1e-4])
def test_a_passage_between_two_nodes_is_found(depth: float) -> None:
    """A parabola, x'' = w^2 is 9, whose lowest point lies just below zero or just above."""
    rising = tables_of(level(1.0), low=LOW, high=HIGH, travel=TRAVEL)
    status, T, rate, *_ = flown(rising, 4.2, 0.5 - depth, -3.0)[0]
    if depth < 0.0:
        assert status == LEFT_TRAVEL
        return
    assert status == AT_REST
    assert pytest.approx((3.0 - math.sqrt(18.0 * depth)) / 9.0, rel=1e-10) == T
    assert rate == pytest.approx(-math.sqrt(18.0 * depth), rel=1e-7)


# x'' = -w^2 is -9: x = v t - 4.5 t^2 comes back after t = v / 4.5.
START, THROWN = 0.5, 3.0
Gap = Callable[[Any, Any], Any]


def by_travel(gap: Callable[[Any], Any]) -> Gap:
    """A gap that depends on the travel alone."""
    return lambda u, _: gap(u)


def beside(*gaps: Gap, x: float = 0.0, start: float = START) -> Any:
    """A flight beside stops whose gaps are given as polynomials of (u, x)."""
    coefficients = np.zeros((len(gaps), 1, 5, 5))
    place = np.cos(np.pi * (np.arange(5) + 0.5) / 5)
    basis = np.linalg.inv(chebyshev.chebvander(place, 4))
    u = 0.5 * TRAVEL * (place + 1.0)
    across = LOW + 0.5 * (HIGH - LOW) * (place + 1.0)
    for number, gap in enumerate(gaps):
        values = gap(u[:, None], across[None, :]) + 0.0 * u[:, None] * across
        coefficients[number, 0] = basis @ values @ basis.T
    tables = tables_of(level(-1.0, count=5), gaps=coefficients, low=LOW, high=HIGH, travel=TRAVEL)
    return flown(tables, start, x, THROWN)[0]


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.77, 0.99])
def test_time_place_and_rate_of_a_hit(share: float) -> None:
    """A gap that falls with the travel alone closes at a known time of a known parabola.

    Nothing of the code is used for the expected values; the number of the stop tells which of two
    closes first.
    """
    t = share * THROWN / 4.5
    closes = START + SPEED * t
    found = beside(by_travel(lambda u: closes + 0.01 - u), by_travel(lambda u: closes - u))
    assert found[0] == OTHER_STOP
    assert found[1] == pytest.approx(t, rel=1e-12)
    assert found[2] == pytest.approx(THROWN - 9.0 * t, rel=1e-10, abs=1e-10)
    assert found[5] == pytest.approx(-9.0, rel=1e-10)
    assert found[9] == pytest.approx(THROWN * t - 4.5 * t**2, rel=1e-10)
    assert found[10:] == (1.0, True)
    # The amplitude is what has been reached until then.
    assert found[3] == pytest.approx(found[9] if share < 0.5 else 0.5, rel=1e-9)


def test_a_stop_opposite_is_hit_on_the_way_up() -> None:
    """0.3 - x closes at 0.3, the first root of v t - 4.5 t^2 = 0.3."""
    found = beside(lambda _, x: 0.3 - x)
    t = (THROWN - math.sqrt(THROWN**2 - 4.0 * 4.5 * 0.3)) / 9.0
    assert (found[0], found[10]) == (OTHER_STOP, 0.0)
    assert found[1] == pytest.approx(t, rel=1e-12)
    assert found[9] == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize("depth", [1e-2, 1e-6, -1e-6, -1e-2])
def test_a_gap_that_dips_between_nodes(depth: float) -> None:
    """A parabola of the travel with its lowest point at -depth, between two nodes of any grid."""
    lowest = START + SPEED * 0.2137
    found = beside(by_travel(lambda u: 2.0 * (u - lowest) ** 2 - depth))
    if depth < 0.0:
        assert found[0] == AT_REST
        assert found[1] == pytest.approx(THROWN / 4.5, rel=1e-12)
        return
    assert found[0] == OTHER_STOP
    closes = lowest - math.sqrt(0.5 * depth)
    assert found[1] == pytest.approx((closes - START) / SPEED, rel=1e-9)


def test_what_would_close_after_the_collision_does_not_happen() -> None:
    """The panel goes on a little behind the flight's end, the flight does not."""
    back = START + SPEED * THROWN / 4.5
    assert beside(by_travel(lambda u: back + 1e-9 - u))[0] == AT_REST
    assert beside(by_travel(lambda u: back - 1e-9 - u))[0] == OTHER_STOP


def test_a_stop_that_has_just_been_thrown_open_is_not_hit_at_the_start() -> None:
    """Its gap is zero where a chart begins, by a collision, and counts from the first node on.

    A flight from above the stop ends there at once, and so do one from elsewhere and one beside a
    closed stop.
    """
    opening = by_travel(lambda u: u - 1e-9)
    assert beside(opening, start=0.0)[0] == AT_REST
    for ended in (
        beside(opening, x=0.1, start=0.0),
        beside(by_travel(lambda u: u - START - 1e-9)),
        beside(by_travel(lambda u: -1.0 + 0.0 * u), start=0.0),
    ):
        assert (ended[0], ended[10]) == (OTHER_STOP, 0.0)
        assert ended[1] == pytest.approx(0.0, abs=1e-15)
    falling = beside(by_travel(lambda u: u * (0.9 - u)), start=0.0)
    assert falling[0] == OTHER_STOP
    assert falling[1] == pytest.approx(0.9 / SPEED, rel=1e-9)


# Panels of a flight: a damped oscillator.

QUICK = 6.5


def oscillator(rate: float, damping: float, low: float, high: float) -> Any:
    """x'' = -w^2 (k x + 1) - 2 d w x', as tables and in closed form."""
    equation = np.zeros((6, 2, 3, 3))
    equation[0, :, 0, 0] = -1.0 - rate * 0.5 * (low + high)
    equation[0, :, 0, 1] = -rate * 0.5 * (high - low)
    equation[1, :, 0, 0] = -2.0 * damping
    tables = tables_of(equation, low=low, high=high, travel=30.0)
    bent = QUICK * np.sqrt(rate - damping**2)

    def motion(t: Any, x0: float, v0: float) -> tuple[Any, Any]:
        fade, d = np.exp(-damping * QUICK * t), damping * QUICK
        b = x0 + 1.0 / rate
        c = (v0 + d * b) / bent
        x = fade * (b * np.cos(bent * t) + c * np.sin(bent * t)) - 1.0 / rate
        v = fade * ((c * bent - d * b) * np.cos(bent * t) - (b * bent + d * c) * np.sin(bent * t))
        return x, v

    return tables, motion


@pytest.mark.parametrize("tolerance", [1e-5, 1e-9, 1e-12, 3e-17])
@pytest.mark.parametrize(
    ("h", "x0", "v0"), [(0.31, 0.0, 4.0), (0.1, 0.3, -0.5), (0.02, 0.1, -6.0), (1e-3, 1.0, 0.2)]
)
def test_a_panel_is_as_accurate_as_it_says(
    tolerance: float, h: float, x0: float, v0: float
) -> None:
    """A damped oscillator: motion at the nodes, and the stated error of x'' by its own formula.

    No grid can be as fine as the least tolerance; what is at round-off counts as resolved.
    """
    tables, motion = oscillator(1.5, 0.2, -0.5, 2.0)
    solver = solver_of(tables, case(QUICK, [], []))
    nodes = solver.work.nodes
    a0 = -(QUICK**2) * (1.5 * x0 + 1.0) - 0.4 * QUICK * v0
    panel.contract(solver, 0, 0, 0.0)
    level, length, change, left = panel.solve_panel(solver, 0, 0.0, h, x0, v0, a0, False, tolerance)
    assert length == h
    count = LEVELS[level]
    x, v = motion(h * grids()[SIGMA, level, 0, :count], x0, v0)
    scale = abs(v0) / h + np.abs(nodes[NODE_A, :count]).max()
    # A steady error of x'' changes rates by itself times the time.
    assert np.abs(nodes[NODE_V, :count] - v).max() <= 3.0 * (change + left) * h + 4.0 * EPS * 6.0
    assert np.abs(nodes[NODE_X, :count] - x).max() <= 3.0 * (change + left) * h * h + 4.0 * EPS
    assert change <= max(tolerance, 1e3 * EPS) * scale
    # Between the nodes x'' of the panel misses the equation of motion, by itself and its integrals.
    a = Chebyshev.fit(grids()[SIGMA, level, 0, :count], nodes[NODE_A, :count], count - 1, [0, 1])
    s = grids()[SIGMA, level, 1, :PROBES]
    rate, path = v0 + h * a.integ(lbnd=0)(s), x0 + h * (s * v0 + h * a.integ(2, lbnd=0)(s))
    missing = np.abs(-(QUICK**2) * (1.5 * path + 1.0) - 0.4 * QUICK * rate - a(s)).max()
    rounding = 8.0 * EPS * scale
    assert left == pytest.approx(12.0 * missing / count**2 + rounding, rel=1e-6, abs=rounding)
    assert left - rounding <= tolerance * scale


@pytest.mark.parametrize("guess", [0.3, 0.11, 0.16, 0.004])
@pytest.mark.parametrize("left_over", [30.0, 0.1])
def test_the_length_of_a_panel_meets_the_next_zero(guess: float, left_over: float) -> None:
    """From a guess that is too long or too short, but never beyond the travel."""
    tables, motion = oscillator(1.5, 0.2, -0.5, 2.0)
    solver, u = solver_of(tables, case(QUICK, [], [])), 30.0 - left_over
    panel.contract(solver, 0, 0, u)
    level, length, _, _ = panel.solve_panel(
        solver, 0, u, guess, 0.0, 4.0, -(QUICK**2) - 0.4 * QUICK * 4.0, True, 1e-10
    )
    assert level >= 0
    x, v = motion(length * grids()[SIGMA, level, 0, : LEVELS[level]], 0.0, 4.0)
    np.testing.assert_allclose(solver.work.nodes[NODE_X, : LEVELS[level]], x, atol=1e-9)
    if left_over < 1.0:
        assert length <= left_over / QUICK * (1.0 + 1e-12)
        assert guess < 0.01 or length == pytest.approx(left_over / QUICK)
    elif guess > 0.01:
        # Its end lies behind the zero, by no more than a twentieth of the flight.
        assert -0.053 * length < -x[-1] / v[-1] < 0.0
