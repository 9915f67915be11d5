"""One flight of the reduced engine by itself, judged by the direct engine."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, Resolution, simulate
from nipper_pin.reduced import ReducedModel
from nipper_pin.reduced.kernels.arrival_check import prepare
from nipper_pin.reduced.kernels.flight import _highest, flight
from nipper_pin.reduced.kernels.grids import grids
from nipper_pin.reduced.kernels.kernel import _scratch
from nipper_pin.reduced.kernels.layout import AT_REST, LEVELS, NODE_X, SERIES_ONCE, SIGMA
from nipper_pin.reduced.kernels.panel import OVERSHOOT

TOLERANCE = 1e-10


def test_the_fastest_rate_of_a_flight_is_its_largest(e62: Mechanism, model: ReducedModel) -> None:
    """Bounds grow with the largest rate, so none on the way may be larger than the one returned.

    The direct engine's rates are equal to it to the tolerance. Panels end beyond the flight, by no
    more than their overshoot at its largest acceleration, which is that of the fall: all of it at
    the rate of the end, relatively.
    """
    speed = 650.0 * math.tau / 60.0
    work = _scratch(model.tables, model.arrival.turn, 1)
    prepare(model.tables, work, speed, 1.0, model.stiffness, model.preload)
    first, second = simulate(
        e62, Case(speed_rpm=650.0, resolution=Resolution(tolerance=1e-13))
    ).collisions[:2]
    status, duration, rate, _, _, acceleration, fastest, _, _, _, _ = flight(
        grids(), work.case, work.mixed, work.poly, work.nodes, model.tables.equation.shape[3],
        0.0, 0.0, first.separation_rate, TOLERANCE, True,
    )  # fmt: skip
    assert int(status) == AT_REST
    assert math.isclose(rate, second.approach_rate, rel_tol=1e3 * TOLERANCE)
    largest = max(first.separation_rate, -second.approach_rate)
    beyond = 2.0 * (OVERSHOOT - 1.0) * duration * abs(acceleration)
    assert (1.0 - 1e3 * TOLERANCE) * largest <= fastest <= largest + beyond
    assert np.isfinite(fastest)


@pytest.mark.parametrize("past", [0.2, 0.8])
def test_a_top_behind_the_end_of_a_flight_does_not_count(past: float) -> None:
    """x = s (2 p - s), whose top p lies between the end of the flight and the node behind that."""
    level, number = 2, 7
    places = grids()[SIGMA, level, 0]
    end = places[number] + 0.1 * (places[number + 1] - places[number])
    top = end + past * (places[number + 1] - end)
    nodes = np.zeros((7, LEVELS[-1] + 2))
    nodes[NODE_X, : LEVELS[level]] = (places * (2.0 * top - places))[: LEVELS[level]]
    # Its rate, 2 (p - s), as a series on -1 to 1.
    nodes[SERIES_ONCE, :2] = 2.0 * top - 1.0, -1.0
    found = _highest(grids(), nodes, level, 1.0, 0.0, 0.0, end)
    assert found == (nodes[NODE_X, number], places[number])
