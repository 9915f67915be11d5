"""Found by the stress campaign (cases 902 and 978 of seed 3): an event at the border of two turns.

"phase logic: event 35 (collision): closed [], before ['steeve']". A cycle that starts where the
lips meet has a collision at the end of every turn, which round-off gives to one turn or to the
next; a turn without it was copied as if the next one did not have it either.
"""

import pytest

from nipper_pin import Case, Window, load, simulate
from nipper_pin.hybrid.run.periodicity import repeats
from nipper_pin.hybrid.run.start import initial_state

PARAMETERS = {
    "stops.jaw.restitution": 0.29362489155001664,
    "stops.steeve.restitution": 0.2250648137360814,
    "springs.steeve.stiffness_N_per_m": 8810.991182060488,
    "springs.steeve.preload_length_mm": 15.039236573693987,
}


@pytest.mark.parametrize("speed", [152.3901570123213, 150.0, 450.0, 311.7])
def test_copied_turns_have_the_collision_at_their_border(speed: float) -> None:
    """Copied and computed turns have the same events at the same times.

    At the first of the speeds the copied turn lacked a collision and the motion passed through the
    stop; whether it does at the others is a matter of round-off.
    """
    mechanism = load("e62", PARAMETERS)
    index = mechanism.cylinder.index_from_angle(mechanism.cylinder.angle_at_touch_rad)
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=3, start_index=index)
    copied = simulate(mechanism, case).events
    computed = simulate(
        mechanism,
        Case(speed_rpm=speed, window=Window.CYCLE, cycles=3, start_index=index, reuse_cycles=False),
    ).events
    inside = [(event.kind, event.stops) for event in computed]
    # The very last collision may lie just behind the end of the run in one of the two.
    assert abs(len(copied) - len(computed)) <= 1
    for event, other, expected in zip(copied, computed, inside, strict=False):
        assert (event.kind, event.stops) == expected
        assert event.t == pytest.approx(other.t, rel=1e-9)


def test_a_turn_that_ends_in_another_assembly_is_not_copied() -> None:
    """Found by the stress campaign (case 446 of seed 71): "jump at 0.117018472 s [rad or m]: 3.53".

    A heavy steeve threw the jaw over, so that the links ended the turn in their other assembly with
    all rates as at its start: the drives stand still there. The next turn was taken for a copy.
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
