"""Flights that another stop ends: where its gap, a function of travel and coordinate, is zero."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from written_tables import level, tables_of, work_of

from nipper_pin.reduced.kernels import arrival_check, flight
from nipper_pin.reduced.kernels.grids import grids
from nipper_pin.reduced.kernels.layout import AT_REST, OTHER_STOP

pytestmark = pytest.mark.usefixtures("plain")

# x'' = -w^2 is -9: x = v t - 4.5 t^2 comes back after t = v / 4.5.
SPEED, LOW, HIGH, TRAVEL = 3.0, -0.5, 2.0, 6.0
START, THROWN = 0.5, 3.0
NONE = np.zeros(0)
Gap = Callable[[Any, Any], Any]


def by_travel(gap: Callable[[Any], Any]) -> Gap:
    """A gap that depends on the travel alone."""
    return lambda u, _: gap(u)


def flown(*gaps: Gap, x: float = 0.0, v: float = THROWN) -> Any:
    """A flight beside stops whose gaps are given as polynomials of (u, x)."""
    coefficients = np.zeros((len(gaps), 1, 5, 5))
    for number, gap in enumerate(gaps):
        place = np.cos(np.pi * (np.arange(5) + 0.5) / 5)
        u = 0.5 * TRAVEL * (place + 1.0)
        across = LOW + 0.5 * (HIGH - LOW) * (place + 1.0)
        values = gap(u[:, None], across[None, :]) + 0.0 * u[:, None] * across
        basis = np.linalg.inv(chebyshev.chebvander(place, 4))
        coefficients[number, 0] = basis @ values @ basis.T
    tables = tables_of(level(-1.0, count=5), gaps=coefficients, low=LOW, high=HIGH, travel=TRAVEL)
    work = work_of(tables)
    arrival_check.prepare(tables, work, SPEED, 0.0, NONE, NONE)
    return flight.flight(
        grids(), work.case, work.mixed, work.poly, work.nodes, 5, START, x, v, 1e-10, x == 0.0
    )


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.77, 0.99])
def test_time_place_and_rate_of_a_hit(share: float) -> None:
    """A gap that falls with the travel alone closes at a known time of a known parabola.

    Nothing of the code is used for the expected values; the number of the stop tells which of two
    closes first.
    """
    t = share * THROWN / 4.5
    closes = START + SPEED * t
    found = flown(by_travel(lambda u: closes + 0.01 - u), by_travel(lambda u: closes - u))
    assert found[0] == OTHER_STOP
    assert found[1] == pytest.approx(t, rel=1e-12)
    assert found[2] == pytest.approx(THROWN - 9.0 * t, rel=1e-10, abs=1e-10)
    assert found[5] == pytest.approx(-9.0, rel=1e-10)
    assert found[9] == pytest.approx(THROWN * t - 4.5 * t**2, rel=1e-10)
    assert found[10] == 1.0
    # The amplitude is what has been reached until then.
    assert found[3] == pytest.approx(found[9] if share < 0.5 else 0.5, rel=1e-9)


def test_a_stop_opposite_is_hit_on_the_way_up() -> None:
    """0.3 - x closes at 0.3, the first root of v t - 4.5 t^2 = 0.3."""
    found = flown(lambda _, x: 0.3 - x)
    t = (THROWN - math.sqrt(THROWN**2 - 4.0 * 4.5 * 0.3)) / 9.0
    assert (found[0], found[10]) == (OTHER_STOP, 0.0)
    assert found[1] == pytest.approx(t, rel=1e-12)
    assert found[9] == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize("depth", [1e-2, 1e-6, -1e-6, -1e-2])
def test_a_gap_that_dips_between_nodes(depth: float) -> None:
    """A parabola of the travel with its lowest point at -depth, between two nodes of any grid."""
    lowest = START + SPEED * 0.2137
    found = flown(by_travel(lambda u: 2.0 * (u - lowest) ** 2 - depth))
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
    assert flown(by_travel(lambda u: back + 1e-9 - u))[0] == AT_REST
    assert flown(by_travel(lambda u: back - 1e-9 - u))[0] == OTHER_STOP


def test_a_stop_that_has_just_been_thrown_open_is_not_hit_at_the_start() -> None:
    """Its gap is zero at the start of a flight from the stop, and counts from the first node on."""
    assert flown(by_travel(lambda u: u - START))[0] == AT_REST
    falling = flown(by_travel(lambda u: (u - START) * (START + 0.9 - u)))
    assert falling[0] == OTHER_STOP
    assert falling[1] == pytest.approx(0.9 / SPEED, rel=1e-9)
