"""Found by the stress campaign (case 853 of seed 161): a balance that ended before the motion.

"energy that is left over [J]: 0.72, at most 0.316": the limit of a series of bounces lay behind the
end of the window, and the state of its last bounce was taken for that of the end.

Case 2271 of seed 181: "energy that is left over [J]: 0.498, at most 1.54e-07": a collision at the
very end of the last turn, a copied one, was taken to have happened a turn before.
"""

from __future__ import annotations

import pytest
from driven_machines import LAWS, follower
from small_machines import SLED, link, machine, slide

from nipper_pin import Case, EventKind, Resolution, Window, load, simulate
from nipper_pin.hybrid.result.energy_balance import energy_balance

GRAVITY, RESTITUTION, TURN_S = 9.81, 0.8, 1.0


def test_the_energy_balance_goes_on_to_the_end_of_the_window() -> None:
    """A ball bounces on a lift, and would be at rest a millisecond after the window.

    Rest after t_1 (1 + e) / (1 - e), t_1 being the time of the fall, which no event tells: the ball
    bounces at t_1 (1 + 2 (e + ... + e^n)) for as long as the window lasts.
    """
    rest = TURN_S + 1e-3
    fall = rest * (1.0 - RESTITUTION) / (1.0 + RESTITUTION)
    parts = [
        link("base"), slide("lift", "frame", "base", axis=(0.0, 1.0)),
        link("ball"), slide("z", "base", "ball", axis=(0.0, 1.0)),
    ]  # fmt: skip
    floor = {
        "joint": "z", "side": "lower", "at_mm": -0.5e3 * GRAVITY * fall**2,
        "restitution": RESTITUTION,
    }  # fmt: skip
    drive = {"joint": "lift", "law": "screw", "lead_mm_per_turn": 500.0, **SLED}
    lift = machine(parts, 2, gravity=GRAVITY, drives={"lift": drive}, stops={"floor": floor})
    case = Case(speed_rpm=60.0 / TURN_S, window=Window.CYCLE, start_index=0.0,
                resolution=Resolution(tolerance=1e-5))  # fmt: skip
    solution = simulate(lift, case)
    times, flight = [fall], 2.0 * RESTITUTION * fall
    while times[-1] + flight < TURN_S:
        times.append(times[-1] + flight)
        flight *= RESTITUTION
    assert [event.kind for event in solution.events] == [EventKind.COLLISION] * len(times)
    assert [event.t for event in solution.events] == pytest.approx(times, rel=1e-9)
    assert solution.segments[-1].t_end == pytest.approx(TURN_S, rel=1e-12)
    assert solution.energy.relative < 1e-12


def test_a_copied_collision_at_the_end_belongs_to_the_balance() -> None:
    """Three turns, of which the last is a copy, end with one of its collisions.

    Whichever it is, what it loses is part of the balance: up to a third of a joule of 8.6.
    """
    solution = simulate(load("e62"), Case(speed_rpm=450.0, window=Window.CYCLE, cycles=3))
    assert solution.repeated_from is not None
    assert solution.repeated_from < 3
    collisions = [
        event
        for event in solution.events
        if event.kind is EventKind.COLLISION and event.t > 2.0 * solution.shaft.period
    ]
    assert len(collisions) >= 5
    for hit in collisions:
        segments = [item for item in solution.segments if item.t_end <= hit.t]
        assert segments[-1].t_end == hit.t
        balance = energy_balance(solution.system, segments, solution.events[: hit.number])
        assert balance.relative < 1e-9


def test_no_rest_lies_beyond_the_end_of_copied_turns() -> None:
    """A turn that ends between the last bounce and the rest has that in the turn that follows."""
    mechanism = follower(LAWS["cycloidal, dwells"])
    speed = 300.0
    whole = simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE, cycles=2))
    rest = next(event for event in whole.events if event.kind is EventKind.REST)
    last = [event.t for event in whole.events if event.t < rest.t][-1]
    angle = float(whole.shaft.angle(0.5 * (last + rest.t)))
    index = mechanism.cylinder.index_from_angle(angle)
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=4, start_index=index)
    solution = simulate(mechanism, case)
    end = solution.trajectory.span[1]
    assert end == pytest.approx(4.0 * solution.shaft.period)
    assert len(solution.events) > 4
    assert max(event.t for event in solution.events) <= end * (1.0 + 1e-12)
