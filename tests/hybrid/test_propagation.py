"""Growth of small errors over a flight: closed forms, and two neighbouring motions of the E62."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, Resolution, Solution, Window, load, simulate
from nipper_pin.hybrid.error_estimate.freedoms import free_coordinates
from nipper_pin.hybrid.error_estimate.variational import flight_map
from nipper_pin.hybrid.motion.chebyshev import evaluate

BENCHMARKS = Path(__file__).parents[2] / "models" / "benchmarks"


def _matrix(solution: Solution, number: int, stop: str) -> np.ndarray:
    """Gap and rate of a stop at the end of a flight with one freedom by those at its start."""
    segment, system = solution.segments[number], solution.system
    rows = system.constraint_set(segment.closed)
    index, nv = solution.mechanism.stop(stop).index, system.body.nv
    whole = np.eye(2 * nv)
    for panel, begin, end in segment.pieces():
        assert free_coordinates(rows, panel.split) == [index]
        whole = flight_map(system, rows, panel, end - begin)[0] @ whole
    return whole[np.ix_([index, nv + index], [index, nv + index])]


def test_errors_of_a_ballistic_flight_grow_with_its_length() -> None:
    """(1, T; 0, 1): an error of the rate moves the ball by T times as much and stays the same.

    Differences of accelerations that do not depend on anything are round-off over the step of 1e-6:
    1e-16 g / 1e-6, times T^2, is below 1e-9.
    """
    ball = load(BENCHMARKS / "bouncing_ball")
    solution = simulate(ball, Case(speed_rpm=ball.cylinder.rated_speed_rpm, window=Window.CYCLE))
    stop = ball.stops[0].name
    number = next(i for i, item in enumerate(solution.segments) if not item.closed)
    length = solution.segments[number].t_end - solution.segments[number].t_start
    np.testing.assert_allclose(
        _matrix(solution, number, stop), [[1.0, length], [0.0, 1.0]], atol=1e-8
    )


def test_errors_along_the_e62_are_those_of_a_neighbouring_motion() -> None:
    """The first flight after the first collision, started again at a rate larger by 1e-6.

    The restitution changes the first rebound rate and nothing before it. Neighbouring motions are
    those of the whole engine; the matrix is of first order, so 1e-6 of relative change leaves a
    relative difference of some 1e-6 of what is compared, and differences of times solved to 1e-13
    leave 1e-7. Errors of a ballistic flight would be 3 % off here.
    """
    change = 1e-6
    resolution = Resolution(tolerance=1e-13)
    case = Case(speed_rpm=650.0, resolution=resolution)
    base, other = (
        simulate(load("e62", {"stops.jaw.restitution": 0.2 * factor}), case)
        for factor in (1.0, 1.0 + change)
    )
    jaw = base.mechanism.stop("jaw").index
    matrix = _matrix(base, 0, "jaw")
    segment = base.segments[0]
    _, v = segment.panels[-1].interpolate(np.array([segment.t_end]))
    rate = base.events[0].v_after[jaw]
    late = matrix[0, 1] * change * rate / -v[0, jaw]
    assert other.events[1].t - base.events[1].t == pytest.approx(late, rel=1e-4)
    last = segment.panels[-1]
    end = np.array([(segment.t_end - last.t) / last.h])
    a = evaluate(last.a[:, jaw], end, 0)[0]
    faster = matrix[1, 1] * change * rate + a * late
    measured = other.events[1].v_before[jaw] - base.events[1].v_before[jaw]
    assert measured == pytest.approx(faster, rel=1e-4)
    ballistic = (segment.t_end - segment.t_start) * change
    assert late != pytest.approx(ballistic, rel=1e-2)
