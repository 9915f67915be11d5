"""Dense motion and forces: limits at events, exact constraints, closed stops, no answer outside."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nipper_pin import (
    Case,
    DriveMode,
    EventKind,
    InputError,
    Mechanism,
    Solution,
    Window,
    load,
    simulate,
)
from nipper_pin.hybrid import Segment


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


@pytest.mark.parametrize("speed", [450.0, 650.0])
def test_sets_along_a_cycle_are_complementary(e62: Mechanism, speed: float) -> None:
    """Along a whole cycle closed stops push and open gaps are positive, at 2000 times of each.

    An index set that lags one event behind breaks one of the two at once. The bounds are the
    round-off of forces of 300 N and of gaps of 4 mm and 0.4 rad.
    """
    solution = simulate(e62, Case(speed_rpm=speed, window=Window.CYCLE))
    first, last = solution.trajectory.span
    times = np.linspace(first, last, 2000)[1:-1]
    q = solution.trajectory.evaluate(times).q
    reactions = solution.trajectory.reactions(times)
    for stop in e62.stops:
        assert q[:, stop.index].min() >= -1e-15
        assert reactions.stops[stop.name].min() >= -1e-9
        # Never both: a gap and a force at the same time.
        assert np.minimum(q[:, stop.index], reactions.stops[stop.name]).max() <= 1e-15
        assert reactions.stops[stop.name].max() > 1.0
        assert q[:, stop.index].max() > 1e-3


def test_at_release_the_force_is_zero_and_the_gap_opens(e62: Mechanism) -> None:
    """Where the steeve leaves its stop its force has just fallen to zero.

    The force is found to the round-off of its largest value, 300 N; just after, the gap grows.
    """
    solution = simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))
    release = next(event for event in solution.events if event.kind is EventKind.RELEASE)
    assert release.stops == ("steeve",)
    force = solution.trajectory.reactions(release.t, left=True).stops["steeve"][0]
    assert abs(force) <= 1e-9
    before = solution.trajectory.reactions(release.t - 1e-5, left=True).stops["steeve"][0]
    assert before > 0.0
    steeve = e62.stop("steeve").index
    later = solution.trajectory.evaluate(release.t + np.array([1e-4, 2e-4])).q[:, steeve]
    assert 0.0 < later[0] < later[1]


def integrated(solution: Solution, segment: Segment) -> tuple[np.ndarray, np.ndarray]:
    """q and v at the end of a segment by SciPy's DOP853 on the equations of motion."""
    system, nv = solution.system, solution.system.body.nv
    phase = system.constraint_set(segment.closed)

    def right_side(t: float, y: np.ndarray) -> np.ndarray:
        driven = system.shaft.driven(np.array([t]))
        a = system.accelerations(driven, y[None, :nv], y[None, nv:], phase)
        return np.concatenate([y[nv:], a[0]])

    first = segment.panels[0]
    start = np.concatenate([first.q[0], first.v[0]])
    span = (segment.t_start, segment.t_end)
    end = solve_ivp(right_side, span, start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return end[:nv], end[nv:]


def test_integration_of_a_kinematic_phase_is_the_same_motion(e62: Mechanism) -> None:
    """Equations of motion end where kinematics does (1e-7, 1e-6 in rates).

    They drift off the closures where kinematics cannot, by their tolerance times the growth over a
    phase; a wrong phase, force or end would be off by the stroke itself.
    """
    solution = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))
    kinematic = [segment for segment in solution.segments if segment.kinematic]
    assert len(kinematic) >= 3
    for segment in kinematic:
        q, v = integrated(solution, segment)
        end = solution.trajectory.evaluate(segment.t_end, left=True)
        begin = solution.trajectory.evaluate(segment.t_start)
        assert np.abs(end.q - begin.q).max() > 0.1
        assert q == pytest.approx(end.q[0], abs=1e-7)
        assert v == pytest.approx(end.v[0], abs=1e-6)
