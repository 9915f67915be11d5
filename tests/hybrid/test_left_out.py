"""Stated errors include the effect of bounces that are not computed on other freedoms.

Case 2621 of seed 411: "impulses 0.590419 and 0.590419, stated 3.11e-12 of them": 4.6e-12 off, at a
collision of a damped body on a slide that had come to rest before. Errors of a rest were those of
its time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_machines import link, machine, slide

from benchmarks.stress.checks.agreement import within_errors
from nipper_pin import Case, EventKind, Resolution, Solution, Window, simulate
from nipper_pin.hybrid.error_estimate.by_part import part_of
from nipper_pin.hybrid.error_estimate.linear_maps import LinearMaps
from nipper_pin.hybrid.error_estimate.panel_maps import PanelMaps
from nipper_pin.hybrid.error_estimate.truncated_bounces import left_out

TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)


def run(tolerance: float, **stops: dict[str, object]) -> Solution:
    """A carriage falls on its floor; a damped block on it slides along a line that leans."""
    bouncing = machine(
        [link("carriage", 1.0), slide("z", "frame", "carriage", axis=(0.0, 1.0)),
         link("block", 1.0), slide("x", "carriage", "block", axis=(0.6, 0.8))], 2, gravity=9.81,
        springs={"coil": {"joint": "x", "stiffness_N_per_m": 100.0, "preload_length_mm": 0.0}},
        dampers={"oil": {"joint": "x", "damping_N_s_per_m": 50.0}},
        stops={"floor": {"joint": "z", "side": "lower", "at_mm": -20.0, "restitution": 0.6},
               **stops},
    )  # fmt: skip
    resolution = Resolution(tolerance=tolerance)
    return simulate(
        bouncing, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, resolution=resolution)
    )


@pytest.fixture(scope="module")
def exact() -> Solution:
    return run(1e-14)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_it_is_the_difference_to_a_run_of_more_bounces(tolerance: float, exact: Solution) -> None:
    """Place and rate of the block 10 ms after the rest, within a tenth, over seven decades.

    The formula takes one deceleration for all that is left. Both numbers fall with the cube of the
    rate that is left, from 2e-7 m and 1e-5 m/s to 3e-13 m and 1e-11 m/s. With the wrong sign, or
    without B B, none of the four is met; A is a few per cent here, and missed in one of them.
    """
    solution = run(tolerance)
    rest = next(event for event in solution.events if event.kind is EventKind.REST)
    lying = next(segment for segment in solution.segments if segment.closed)
    assert rest.v_before[0] > 1e-4
    assert len(solution.events) < len(exact.events)
    found = left_out(solution.system, rest, rest.t - lying.t_start)
    t = rest.t + 0.01
    lying = replace(lying, t_end=t, panels=lying.panels[:1])
    panels = PanelMaps(solution.system, solution.events)
    later = LinearMaps(part_of(solution.system, "floor"), panels).flight(lying).matrix @ found
    states = [item.trajectory.evaluate(np.array([t])) for item in (solution, exact)]
    q, v = (np.diff([getattr(state, name)[0] for state in states], axis=0)[0] for name in "qv")
    assert later[[1, 3]] == pytest.approx([q[1], v[1]], rel=0.1)


def test_it_is_stated_where_the_other_body_strikes() -> None:
    """The block meets a stop of its own 3 ms after the rest: within twice what both runs state.

    At a tolerance of 1e-6 the next event was 2.3e-6 s off, and 1.9e-7 s were stated.
    """
    shelf = {"joint": "x", "side": "lower", "at_mm": -17.6, "restitution": 0.3}
    fine = run(1e-14, shelf=shelf)
    (right, *_) = (event.P_N["shelf"] for event in fine.events if "shelf" in event.stops)
    for tolerance in TOLERANCES:
        coarse = run(tolerance, shelf=shelf)
        assert within_errors(coarse, fine) == []
        number = next(i for i, event in enumerate(coarse.events) if "shelf" in event.stops)
        off = abs(coarse.events[number].P_N["shelf"] / right - 1.0)
        assert 0.5 * off <= coarse.errors[number].impulse <= 4.0 * off
