"""Panels of a flight: combined functions, operators of the grids, defects, all by closed forms.

Polynomials whose degree the grids hold are right to round-off; every other number is derived.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Polynomial, chebyshev
from written_tables import case, tables_of, value, work_of, x_dd

from nipper_pin.reduced.kernels import panel, turn_charts
from nipper_pin.reduced.kernels.layout import (
    DOUBLE,
    INTEGRAL,
    LEVELS,
    NODE_A,
    NODE_V,
    NODE_X,
    ONCE,
    PROBE,
    PROBE_ONCE,
    PROBE_TWICE,
    PROBES,
    REFINE,
    SIGMA,
    TWICE,
    VALUE,
)
from nipper_pin.reduced.kernels.panel import grids
from nipper_pin.tolerances.mechanics import EPS

pytestmark = pytest.mark.usefixtures("plain")

SPRINGS = [(900.0, 0.013), (70.0, -0.4)]
SPEED, GRAVITY = 6.5, 0.7


def prepared(count_u: int, count_x: int, cells: int = 3, springs: Any = SPRINGS) -> Any:
    """Tables of random functions with two other stops, and their scratch arrays for a case."""
    random = np.random.default_rng(count_u)
    shape = (4 + 2 * len(springs), cells, count_u, count_x)
    gaps = random.normal(size=(2, *shape[1:]))
    tables = tables_of(random.normal(size=shape), gaps=gaps, low=-0.3, high=1.7, travel=2.4)
    k, p = np.array(springs).reshape(-1, 2).T
    return tables, work_of(tables, case(SPEED, GRAVITY, k, p))[0]


@pytest.mark.parametrize("count_u", [2, 3, 4, 5, 6])
@pytest.mark.parametrize("u", [0.0, 0.3, 0.8, 1.5, 2.4])
def test_functions_of_a_case(count_u: int, u: float) -> None:
    """x'' and the gaps at a point are sums of two-dimensional series, in the cell of the travel."""
    tables, work = prepared(count_u, 4)
    row = len(work.poly) - 1
    panel.contract(work.mixed[0], work.poly, row, 2.4, u)
    for x, v in ((-0.2, 3.0), (1.1, -0.4)):
        found = panel.acceleration(work.case[0], work.poly, 4, x, v)
        expected = x_dd(tables, u, x, v, SPEED, GRAVITY, SPRINGS)
        assert found == pytest.approx(expected, rel=1e-12)
        place = x - 0.7
        for stop in (0, 1):
            found = panel.chebyshev(work.poly, row, (3 + stop) * 4, 4, place)
            expected = value(tables, tables.gaps[0, stop], u, x)
            assert found == pytest.approx(expected, rel=1e-11, abs=1e-12)


def test_cells_are_combined_where_a_motion_goes() -> None:
    """Those between two travels, once; the others stay as they are."""
    tables, work = prepared(4, 4, cells=5)
    one, whole = case(SPEED, GRAVITY, *np.array(SPRINGS).T), work.mixed[0].copy()
    source = turn_charts.source_of(tables, work, 0, one)
    source.ready[:], source.mixed[:] = False, np.nan
    width = 2.4 / 5.0
    panel.reach(source, 2.4, 1.5 * width, 3.5 * width)
    assert source.ready.tolist() == [False, True, True, True, False]
    np.testing.assert_array_equal(source.mixed[1:4], whole[1:4])
    assert np.isnan(source.mixed[[0, 4]]).all()
    source.mixed[2] = 7.0
    panel.reach(source, 2.4, 2.5 * width, 9.0)
    assert (source.mixed[2] == 7.0).all()
    np.testing.assert_array_equal(source.mixed[4], whole[4])


def test_a_case_without_springs_or_other_stops() -> None:
    """Nothing is added for them."""
    tables, work = prepared(3, 4, springs=[])
    panel.contract(work.mixed[0], work.poly, len(work.poly) - 1, 2.4, 0.3)
    expected = x_dd(tables, 0.3, 0.2, 0.9, SPEED, GRAVITY, [])
    assert panel.acceleration(work.case[0], work.poly, 4, 0.2, 0.9) == pytest.approx(expected)


@pytest.mark.parametrize("level", range(len(LEVELS)))
def test_operators_of_the_grids(level: int) -> None:
    """Every power of sigma that the nodes hold, and its integrals, at nodes, probes and as series.

    Nodes are those of Lobatto, and probes lie halfway in angle between two of them.
    """
    given, count = grids()[:, level], LEVELS[level]
    angle = np.pi * np.arange(count) / (count - 1)
    nodes = 0.5 - 0.5 * np.cos(angle)
    np.testing.assert_allclose(given[SIGMA, 0, :count], nodes, atol=1e-15)
    probes = given[SIGMA, 1, :PROBES]
    halves = (np.arccos(1.0 - 2.0 * probes) / np.pi) * (count - 1) % 1.0
    np.testing.assert_allclose(halves, 0.5, atol=1e-12)
    assert probes[0] + probes[2] == pytest.approx(1.0)
    assert 0.0 < probes[0] < probes[1] < probes[2]
    for power in range(count):
        values = nodes**power
        once, twice = (
            lambda s, n=power: s ** (n + 1) / (n + 1),
            lambda s, n=power: s ** (n + 2) / ((n + 1) * (n + 2)),
        )
        for kind, places, expected in (
            (ONCE, nodes, once), (TWICE, nodes, twice), (PROBE, probes, lambda s, n=power: s**n),
            (PROBE_ONCE, probes, once), (PROBE_TWICE, probes, twice),
        ):  # fmt: skip
            found = values @ given[kind, :count, : len(places)]
            np.testing.assert_allclose(found, expected(places), atol=1e-14, err_msg=str(kind))
        for kind, expected in ((VALUE, lambda s, n=power: s**n), (INTEGRAL, once), (DOUBLE, twice)):
            series = values @ given[kind, :count]
            found = chebyshev.chebval(2.0 * nodes - 1.0, series)
            np.testing.assert_allclose(found, expected(nodes), atol=1e-14, err_msg=str(kind))
        if level and power < LEVELS[level - 1]:
            coarse = LEVELS[level - 1]
            found = (0.5 - 0.5 * np.cos(np.pi * np.arange(coarse) / (coarse - 1))) ** power
            found = found @ given[REFINE, :coarse, :count]
            np.testing.assert_allclose(found, values, atol=1e-13)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_the_motion_of_a_panel_and_its_defect(level: int) -> None:
    """Positions, rates, series and the largest defect at the probes, of any accelerations."""
    tables, work = prepared(4, 4)
    count, nodes = LEVELS[level], work.nodes
    sigma = grids()[SIGMA, level, 0, :count]
    a = np.random.default_rng(level).normal(size=4)
    poly = Polynomial(a)
    u, h, x0, v0 = 0.4, 0.3, 0.2, 1.1
    nodes[NODE_A, :count] = poly(sigma)
    rate = v0 + h * poly.integ()
    path = x0 + h * (v0 * Polynomial([0.0, 1.0]) + h * poly.integ(2))
    panel._positions(grids(), nodes, level, h, x0, v0)
    np.testing.assert_allclose(nodes[NODE_X, :count], path(sigma), rtol=1e-13)
    np.testing.assert_allclose(nodes[NODE_V, :count], rate(sigma), rtol=1e-13)
    panel.coefficients(grids(), nodes, level)
    for s in (0.0, 0.37, 1.0):
        assert panel.position(nodes, count, h, x0, v0, s) == pytest.approx(path(s), rel=1e-13)
        assert panel.rate_at(nodes, count, h, v0, s) == pytest.approx(rate(s), rel=1e-13)
    misses = [
        abs(x_dd(tables, u + h * SPEED * s, path(s), rate(s), SPEED, GRAVITY, SPRINGS) - poly(s))
        for s in grids()[SIGMA, level, 1, :PROBES]
    ]
    found = panel._defect(
        grids(), work.case[0], work.mixed[0], work.poly, nodes, 4, level, u, h, x0, v0
    )
    assert found == pytest.approx(max(misses), rel=1e-11)


def test_a_sweep_puts_the_equation_of_motion_in() -> None:
    """Accelerations at the nodes are those of the motion before; the largest change is returned."""
    level = 1
    tables, work = prepared(4, 4)
    count, nodes = LEVELS[level], work.nodes
    sigma = grids()[SIGMA, level, 0, :count]
    u, h, x0, v0, a0 = 0.4, 0.2, 0.2, 1.1, 0.8
    nodes[NODE_A, :count] = a0
    for j, s in enumerate(sigma):
        panel.contract(work.mixed[0], work.poly, j, 2.4, u + h * SPEED * s)
    change = panel._sweep(grids(), work.case[0], work.poly, nodes, 4, level, h, x0, v0)
    t = h * sigma
    expected = np.array([
        x_dd(tables, u + SPEED * at, x0 + v0 * at + 0.5 * a0 * at**2, v0 + a0 * at, SPEED, GRAVITY,
             SPRINGS)
        for at in t
    ])  # fmt: skip
    np.testing.assert_allclose(nodes[NODE_A, :count], expected, rtol=1e-11)
    assert change == pytest.approx(np.abs(expected - a0).max(), rel=1e-11)


def oscillator(rate: float, damping: float, low: float, high: float) -> Any:
    """x'' = -w^2 (k x + 1) - 2 d w x', as tables and in closed form."""
    equation = np.zeros((6, 2, 3, 3))
    equation[0, :, 0, 0] = -1.0 - rate * 0.5 * (low + high)
    equation[0, :, 0, 1] = -rate * 0.5 * (high - low)
    equation[1, :, 0, 0] = -2.0 * damping
    tables = tables_of(equation, low=low, high=high, travel=30.0)
    bent = SPEED * np.sqrt(rate - damping**2)

    def motion(t: Any, x0: float, v0: float) -> tuple[Any, Any]:
        fade, d = np.exp(-damping * SPEED * t), damping * SPEED
        b = x0 + 1.0 / rate
        c = (v0 + d * b) / bent
        x = fade * (b * np.cos(bent * t) + c * np.sin(bent * t)) - 1.0 / rate
        v = fade * ((c * bent - d * b) * np.cos(bent * t) - (b * bent + d * c) * np.sin(bent * t))
        return x, v

    return tables, motion


@pytest.mark.parametrize("level", [1, 2, 3])
def test_a_finer_grid_begins_with_the_motion_of_the_coarser_one(level: int) -> None:
    """Accelerations go over to the new nodes; functions of old nodes move to their places."""
    _, work = prepared(4, 4)
    coarse, fine = (grids()[SIGMA, at, 0, : LEVELS[at]] for at in (level - 1, level))
    poly = Polynomial([0.3, -1.0, 2.0, 0.7])
    work.nodes[NODE_A, : len(coarse)] = poly(coarse)
    work.poly[: len(coarse)] = coarse[:, None] + np.arange(work.poly.shape[1])
    panel._spread(grids(), work.poly, work.nodes, level)
    np.testing.assert_allclose(work.nodes[NODE_A, : len(fine)], poly(fine), rtol=1e-12)
    np.testing.assert_allclose(work.poly[: len(fine) : 2, 3], fine[::2] + 3.0, rtol=1e-14)


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
    work, source = work_of(tables, case(SPEED, GRAVITY, [], []))
    nodes = work.nodes
    a0 = -(SPEED**2) * (1.5 * x0 + 1.0) - 0.4 * SPEED * v0
    level, length, change, left = panel.solve_panel(
        grids(), work.case[0], source, work.poly, nodes, 3, 0.0, h, x0, v0, a0, False, tolerance
    )
    assert length == h
    count = LEVELS[level]
    x, v = motion(h * grids()[SIGMA, level, 0, :count], x0, v0)
    scale = abs(v0) / h + np.abs(nodes[NODE_A, :count]).max()
    # A steady error of x'' changes rates by itself times the time.
    assert np.abs(nodes[NODE_V, :count] - v).max() <= 3.0 * (change + left) * h + 4.0 * EPS * 6.0
    assert np.abs(nodes[NODE_X, :count] - x).max() <= 3.0 * (change + left) * h * h + 4.0 * EPS
    assert change <= max(tolerance, 1e3 * EPS) * scale
    missing = panel._defect(
        grids(), work.case[0], work.mixed[0], work.poly, nodes, 3, level, 0.0, h, x0, v0
    )
    rounding = 8.0 * EPS * scale
    assert left == pytest.approx(12.0 * missing / count**2 + rounding, rel=1e-9)
    assert left - rounding <= tolerance * scale
    # Positions belong to the last accelerations.
    before = nodes[[NODE_X, NODE_V], :count].copy()
    panel._positions(grids(), nodes, level, h, x0, v0)
    np.testing.assert_array_equal(nodes[[NODE_X, NODE_V], :count], before)


@pytest.mark.parametrize("guess", [0.3, 0.11, 0.16, 0.004])
@pytest.mark.parametrize("left_over", [30.0, 0.1])
def test_the_length_of_a_panel_meets_the_next_zero(guess: float, left_over: float) -> None:
    """From a guess that is too long or too short, but never beyond the travel."""
    tables, motion = oscillator(1.5, 0.2, -0.5, 2.0)
    work, source = work_of(tables, case(SPEED, GRAVITY, [], []))
    level, length, _, _ = panel.solve_panel(
        grids(), work.case[0], source, work.poly, work.nodes, 3, 30.0 - left_over, guess,
        0.0, 4.0, -(SPEED**2) - 0.4 * SPEED * 4.0, True, 1e-10,
    )  # fmt: skip
    assert level >= 0
    x, v = motion(length * grids()[SIGMA, level, 0, : LEVELS[level]], 0.0, 4.0)
    np.testing.assert_allclose(work.nodes[NODE_X, : LEVELS[level]], x, atol=1e-9)
    if left_over < 1.0:
        assert length <= left_over / SPEED * (1.0 + 1e-12)
        assert guess < 0.01 or length == pytest.approx(left_over / SPEED)
    elif guess > 0.01:
        # Its end lies behind the zero, by no more than a twentieth of the flight.
        assert -0.053 * length < -x[-1] / v[-1] < 0.0


def test_what_cannot_be_resolved_is_said() -> None:
    """A rate of change that no grid follows: no level."""
    tables, _ = oscillator(4e4, 0.2, -0.5, 2.0)
    work, source = work_of(tables, case(SPEED, GRAVITY, [], []))
    level, _, change, left = panel.solve_panel(
        grids(), work.case[0], source, work.poly, work.nodes, 3, 0.0, 0.3, 0.0, 4.0, -100.0,
        False, 1e-10,
    )  # fmt: skip
    assert level == -1
    assert math.isinf(change)
    assert math.isinf(left)
