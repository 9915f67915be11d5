"""What the reduced engine must notice by itself: gravity, the end of its tables, other stops."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin import Case, InputError, load, simulate
from nipper_pin.reduced import ReducedModel, Status, build, transition, transitions
from nipper_pin.reduced.kernels.flight import _first_zero
from nipper_pin.reduced.kernels.grids import grids as shared_grids
from nipper_pin.reduced.kernels.layout import (
    LEVELS,
    NODE_A,
    NODE_V,
    NODE_X,
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
