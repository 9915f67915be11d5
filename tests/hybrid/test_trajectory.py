"""Dense motion: limits at events, exact constraints in between, and no answer outside."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin import Case, DriveMode, EventKind, InputError, Solution, Window, load, simulate


@pytest.fixture(scope="module", params=["held", "inertial"])
def cycle(request: pytest.FixtureRequest) -> Solution:
    """One turn at 650 r/min."""
    case = Case(speed_rpm=650.0, window=Window.CYCLE, drive=DriveMode(request.param))
    return simulate(load("e62"), case)


def test_limits_at_collisions_and_releases(cycle: Solution) -> None:
    """The left limit is the state before, the right one the state after; q is the same.

    The event's state is the end of its panel and the start of the next one, so only the round-off
    of a dense evaluation lies between: 1e-12 of rates of 20 rad/s. At most events the rates jump
    by far more, so exchanged limits cannot pass. A rest takes over at the last collision computed:
    from there on its right limit holds.
    """
    jumps = 0
    rests = {event.number: event for event in cycle.events if event.kind is EventKind.REST}
    for event in cycle.events:
        if event.number in rests:
            continue
        after = rests.get(event.number + 1, event).v_after
        left = cycle.trajectory.evaluate(event.t, left=True)
        right = cycle.trajectory.evaluate(event.t)
        np.testing.assert_allclose(left.q[0], event.q, rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(right.q[0], event.q, rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(left.v[0], event.v_before, rtol=0.0, atol=2e-11)
        np.testing.assert_allclose(right.v[0], after, rtol=0.0, atol=2e-11)
        jumps += bool(np.abs(after - event.v_before).max() > 1e-3)
    assert jumps >= 10


def test_between_events_both_limits_are_the_same(cycle: Solution) -> None:
    """Away from events the side does not matter, bit by bit; and one time gives what many give."""
    first, last = cycle.trajectory.span
    times = np.linspace(first, last, 101)[1:-1]
    right, left = cycle.trajectory.evaluate(times), cycle.trajectory.evaluate(times, left=True)
    np.testing.assert_array_equal(right.q, left.q)
    np.testing.assert_array_equal(right.v, left.v)
    shuffled = np.random.default_rng(1).permutation(len(times))
    again = cycle.trajectory.evaluate(times[shuffled])
    np.testing.assert_allclose(again.q, right.q[shuffled], rtol=0.0, atol=1e-14)
    alone = cycle.trajectory.evaluate(float(times[40]))
    np.testing.assert_allclose(alone.q[0], right.q[40], rtol=0.0, atol=1e-14)


def test_rates_and_accelerations_are_derivatives(cycle: Solution) -> None:
    """Central differences over 2e-6 s of q give v, and of v the accelerations beside the forces.

    Their error is h^2/6 of the third derivative, 4e-13 / 6 times 1e7 rad/s^3, and the round-off
    eps / h = 1e-10: together below 1e-5 of rates of 20 rad/s. Fourth derivatives of shafts and
    jaw are up to 1e9 rad/s^4.
    """
    step = 1e-6
    first, last = cycle.trajectory.span
    times = np.linspace(first, last, 203)[1:-1]
    events = np.array([event.t for event in cycle.events])
    times = times[np.abs(times[:, None] - events).min(axis=1) > 2.0 * step]
    ahead, behind = (cycle.trajectory.evaluate(times + d) for d in (step, -step))
    v, a = cycle.trajectory.evaluate(times).v, cycle.trajectory.reactions(times).a
    np.testing.assert_allclose((ahead.q - behind.q) / (2.0 * step), v, rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(
        (ahead.v - behind.v) / (2.0 * step), a, rtol=0.0, atol=1e-6 * np.abs(a).max()
    )


def test_closures_and_prescribed_motion_are_met_everywhere(cycle: Solution) -> None:
    """At any time the loops are closed to 1e-14 m, also where no node of a panel lies.

    Newton's method ends at 16 eps of the reach, 4e-15 m; interpolation alone would leave 1e-12 m.
    """
    first, last = cycle.trajectory.span
    times = np.random.default_rng(2).uniform(first, last, 500)
    motion = cycle.trajectory.evaluate(times)
    g, jacobian = cycle.system.body.closures(motion.q)
    assert np.abs(g).max() <= 1e-14
    assert np.abs(np.einsum("nij,nj->ni", jacobian, motion.v)).max() <= 1e-13
    if cycle.system.held:
        q, v, _ = cycle.shaft.driven(times)
        np.testing.assert_array_equal(motion.q[:, cycle.system.driven], q)
        np.testing.assert_array_equal(motion.v[:, cycle.system.driven], v)


@pytest.mark.parametrize("side", [True, False])
def test_times_outside_are_refused(cycle: Solution, side: bool) -> None:
    """Before the start, after the end and not-a-number are input errors that name the span."""
    first, last = cycle.trajectory.span
    for time in (first - 1e-9, last + 1e-9, np.nan, np.inf):
        for evaluate in (cycle.trajectory.evaluate, cycle.trajectory.reactions):
            with pytest.raises(InputError, match="lies outside the solution") as caught:
                evaluate(np.array([0.5 * last, time]), left=side)
            assert caught.value.evidence["span"] == (first, last)


def test_both_ends_belong_to_the_solution(cycle: Solution) -> None:
    """First and last time can be asked for from either side, and one unit of round-off beyond."""
    ends = np.array([*cycle.trajectory.span, np.nextafter(cycle.trajectory.span[1], np.inf)])
    for side in (True, False):
        assert np.isfinite(cycle.trajectory.evaluate(ends, left=side).q).all()
