"""Events at the border of two turns and at the end of a window: found by the stress campaign."""

from __future__ import annotations

import pytest
from driven_machines import LAWS, follower
from small_machines import SLED, link, machine, nipper, slide, turn

from nipper_pin import Case, EventKind, Window, load, simulate
from nipper_pin.hybrid import initial_state
from nipper_pin.hybrid.result.energy_balance import energy_balance
from nipper_pin.hybrid.run.windows import repeats


@pytest.mark.parametrize("speed", [152.3901570123213, 150.0, 450.0, 311.7])
def test_copied_turns_have_the_collision_at_their_border(speed: float) -> None:
    """A cycle that starts where the lips meet has a collision at the end of every turn.

    Round-off gives it to one turn or the next; a turn without it was copied as if the next one did
    not have it either, at the first of the speeds: the motion passed through the stop.
    """
    numbers = 0.29362489155001664, 0.2250648137360814, 8810.991182060488, 15.039236573693987
    mechanism = nipper(*numbers)
    index = mechanism.cylinder.index_from_angle(mechanism.cylinder.angle_at_touch_rad)
    copied, computed = (
        turn(mechanism, speed, cycles=3, start_index=index, reuse_cycles=reuse).events
        for reuse in (True, False)
    )
    inside = [(event.kind, event.stops) for event in computed]
    # The very last collision may lie just behind the end of the run in one of the two.
    assert abs(len(copied) - len(computed)) <= 1
    for event, other, expected in zip(copied, computed, inside, strict=False):
        assert (event.kind, event.stops) == expected
        assert event.t == pytest.approx(other.t, rel=1e-9)


def test_a_turn_that_ends_in_another_assembly_is_not_copied() -> None:
    """A thrown jaw ends the turn in its other assembly with all rates as at its start.

    The drives stand still there; the next turn was taken for a copy.
    """
    mechanism = load("e62")
    case = Case(speed_rpm=450.0, window=Window.CYCLE, cycles=1)
    solution = simulate(mechanism, case)
    segments = solution.segments
    start = initial_state(solution.system, case.start_index)
    end = start._replace(t=solution.shaft.period)
    assert repeats(solution.system, [], segments, start, end) is not None
    jaw = mechanism.stop("jaw").index
    thrown = end.q.copy()
    thrown[jaw] += 1e-6
    assert repeats(solution.system, [], segments, start, end._replace(q=thrown)) is None


GRAVITY, RESTITUTION, TURN_S = 9.81, 0.8, 1.0


def test_the_energy_balance_goes_on_to_the_end_of_the_window() -> None:
    """A ball bounces on a lift, and would be at rest a millisecond after the window.

    Rest after t_1 (1 + e) / (1 - e), t_1 being the time of the fall, which no event tells: the ball
    bounces at t_1 (1 + 2 (e + ... + e^n)) for as long as the window lasts. The state of its last
    bounce was taken for that of the end.
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
    solution = turn(lift, 60.0 / TURN_S, 1e-5)
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

    Whichever it is, what it loses is part of the balance, up to a third of a joule of 8.6; it was
    taken to have happened a turn before.
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
    solution = turn(mechanism, speed, cycles=4, start_index=index)
    end = solution.trajectory.span[1]
    assert end == pytest.approx(4.0 * solution.shaft.period)
    assert len(solution.events) > 4
    assert max(event.t for event in solution.events) <= end * (1.0 + 1e-12)
