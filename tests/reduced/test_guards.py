"""What the reduced engine must notice by itself: gravity, the end of its tables, other stops."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin import Case, InputError, load, simulate
from nipper_pin.reduced import ReducedModel, Status, build, transition, transitions
from nipper_pin.reduced.kernels.flight import _first_zero, _others_open
from nipper_pin.reduced.kernels.grids import grids as shared_grids
from nipper_pin.reduced.kernels.layout import (
    CASE_NUMBERS,
    LEVELS,
    LOW,
    NODE_A,
    NODE_V,
    NODE_X,
    SCALE,
    SCRATCH_ROWS,
    SIGMA,
)
from nipper_pin.reduced.kernels.panel import coefficients

# Both engines agree to 1e-10 (test_transition.py); gravity is a few per cent of the acceleration.
AGREED = 1e-9


@pytest.fixture(scope="module")
def on_mars() -> ReducedModel:
    return build(load("e62", {"gravity_m_s2": 3.7}))


def durations(gravity: float) -> float:
    mechanism = load("e62", {"gravity_m_s2": gravity})
    return simulate(mechanism, Case(speed_rpm=650.0)).transitions[0].duration


def test_gravity_shows_in_the_duration() -> None:
    """Otherwise the comparisons below would compare nothing."""
    assert abs(durations(3.7) / durations(9.81) - 1.0) > 1e3 * AGREED


@pytest.mark.slow
def test_a_model_of_another_gravity_has_that_gravity(on_mars: ReducedModel) -> None:
    """By default its own, and in a case any: the direct engine says the same."""
    found = transition(on_mars, speed_rpm=650.0, tolerance=1e-12)
    assert found.duration == pytest.approx(durations(3.7), rel=AGREED)
    found = transition(on_mars, speed_rpm=650.0, gravity=9.81, tolerance=1e-12)
    assert found.duration == pytest.approx(durations(9.81), rel=AGREED)
    speeds = np.array([650.0, 650.0])
    batch = transitions(on_mars, speed_rpm=speeds, gravity=np.array([3.7, 9.81]), tolerance=1e-12)
    expected = [durations(3.7), durations(9.81)]
    np.testing.assert_allclose(batch.duration, expected, rtol=AGREED)


def test_a_model_of_the_usual_gravity_can_be_asked_for_another(model: ReducedModel) -> None:
    found = transition(model, speed_rpm=650.0, gravity=3.7, tolerance=1e-12)
    assert found.duration == pytest.approx(durations(3.7), rel=AGREED)


def test_rebounds_beyond_the_tables_are_not_computed(model: ReducedModel) -> None:
    """Tables that end a little below the first rebound, and a little above it."""
    highest = float(transition(model, speed_rpm=650.0).rebound_amplitude[0])
    low, high = (
        build(load("e62"), gap_max=factor * highest) for factor in (0.98, 1.02)
    )  # fmt: skip
    with pytest.raises(InputError, match="rebound"):
        transition(low, speed_rpm=650.0)
    status = [
        Status(int(transitions(item, speed_rpm=np.array([650.0])).status[0]))
        for item in (low, high)
    ]  # fmt: skip
    assert status == [Status.LEFT_GAP, Status.AT_REST]


@pytest.mark.parametrize(
    ("gaps", "is_open"),
    [
        ((1.0, 0.9, 0.8, 0.7), True),
        ((1.0, 0.9, 0.0, 0.7), False),
        ((1.0, -1e-9, 0.8, 0.7), False),
        # A parabola through 1, 0.4, 1 may fall by half of 0.6 below 0.4: it stays above zero.
        ((2.0, 1.0, 0.4, 1.0), True),
        # Through 1, 0.2, 1 it may fall by 0.4 below 0.2.
        ((2.0, 1.0, 0.2, 1.0), False),
        ((1.0, 0.2, 1.0, 2.0), False),
    ],
)
def test_other_stops_that_dip_between_nodes_are_found(
    gaps: tuple[float, ...], is_open: bool
) -> None:
    grids = shared_grids()
    case = np.zeros(CASE_NUMBERS)
    case[LOW], case[SCALE] = 0.0, 1.0
    nodes = np.ones((SCRATCH_ROWS, LEVELS[-1] + 2))
    # With one coefficient a function; the first three are those of the acceleration.
    poly = np.zeros((len(gaps) + 1, 4))
    poly[:-1, 3] = gaps
    assert _others_open(grids, case, poly, nodes, 1, 0, 1.0, 0) is is_open


def test_other_stops_count_until_the_end_of_the_flight_only() -> None:
    """What the panel holds behind the next collision does not happen; nor does the start."""
    grids = shared_grids()
    case = np.zeros(CASE_NUMBERS)
    case[SCALE] = 1.0
    nodes = np.ones((SCRATCH_ROWS, LEVELS[-1] + 2))
    poly = np.zeros((5, 4))
    poly[:-1, 3] = 1.0, 1.0, 1.0, -1.0
    middle = float(grids[SIGMA, 0, 0, 2])
    assert _others_open(grids, case, poly, nodes, 1, 0, middle, 0)
    assert not _others_open(grids, case, poly, nodes, 1, 0, 1.0, 0)
    poly[:-1, 3] = 0.0, 1.0, 1.0, 1.0
    assert _others_open(grids, case, poly, nodes, 1, 0, 1.0, 1)
    assert not _others_open(grids, case, poly, nodes, 1, 0, 1.0, 0)


@pytest.mark.parametrize(("depth", "found"), [(1e-3, True), (-1e-3, False)])
def test_a_passage_between_two_nodes_is_found(depth: float, found: bool) -> None:
    """A parabola whose lowest point lies between two nodes, just below zero or just above."""
    grids, level = shared_grids(), 1
    count = LEVELS[level]
    sigma = grids[SIGMA, level, 0, :count]
    lowest, bend = 0.5 * (sigma[2] + sigma[3]), 2.0
    x0, v0 = 0.5 * bend * lowest**2 - depth, -bend * lowest
    nodes = np.zeros((SCRATCH_ROWS, LEVELS[-1] + 2))
    nodes[NODE_A, :count] = bend
    nodes[NODE_V, :count] = v0 + bend * sigma
    nodes[NODE_X, :count] = x0 + v0 * sigma + 0.5 * bend * sigma**2
    assert nodes[NODE_X, :count].min() > 0.0
    coefficients(grids, nodes, level)
    place = _first_zero(grids, nodes, level, 1.0, x0, v0)
    if found:
        assert place == pytest.approx(lowest - np.sqrt(2.0 * depth / bend), rel=1e-10)
    else:
        assert place == -1.0
