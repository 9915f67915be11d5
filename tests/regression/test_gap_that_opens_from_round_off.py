"""A closed jaw on which the steeve stands just off its stop: its gap opens, and closes at once.

At a touch angle 0.003 degrees beside the extreme of the pendulum the jaw comes to rest with a gap
of the steeve of -4e-17 m that opens by 5e-12 m and closes again within 1 ms, before the first place
at which a coarse panel was looked at: the steeve went 1 mm through its stop, without a word.
"""

from __future__ import annotations

import pytest

from nipper_pin import Case, EventKind, Resolution, Window, load, simulate


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-10])
def test_the_gap_closes_where_it_does(tolerance: float) -> None:
    """The same events, and the same time as an 80-bit solution, to what is stated."""
    model = load(
        "e62",
        {
            "stops.jaw.restitution": 0.1989706720242519,
            "stops.steeve.restitution": 0.042420346058545305,
            "springs.steeve.stiffness_N_per_m": 4849.703423371149,
            "springs.steeve.preload_length_mm": 11.279290966650025,
            "cylinder.angle_at_touch_deg": 115.58298052068753,
        },
    )
    case = Case(
        speed_rpm=607.3992693621092,
        window=Window.CYCLE,
        resolution=Resolution(tolerance=tolerance),
    )
    solution = simulate(model, case)
    place = next(
        number
        for number, event in enumerate(solution.events)
        if event.kind is EventKind.COLLISION and event.closed_before == frozenset(["jaw"])
    )
    hit, error = solution.events[place], solution.errors[place]
    assert hit.stops == ("steeve",)
    assert abs(hit.t - 0.038650563990750886663) <= error.time < 1e-9
    assert solution.phases[-1].closed == frozenset(["steeve"])
    steeve = model.stop("steeve").index
    times = [solution.events[-1].t + part * 1e-3 for part in range(9)]
    assert (solution.trajectory.evaluate(times).q[:, steeve] >= -1e-12).all()
