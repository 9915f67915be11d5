"""Dense motion and forces: limits at events, exact constraints, closed stops, no answer outside."""

from __future__ import annotations

import math

import numpy as np
import pytest
from runs_shown import run_of
from scipy.integrate import solve_ivp
from small_machines import SLED, link, machine, slide

from nipper_pin import (
    Case,
    DriveMode,
    EventKind,
    InputError,
    Mechanism,
    Resolution,
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


# Gravity, place of the shelf, nodes and panels.
COARSE = Resolution(adaptive=False, flight_nodes=40, panels_per_turn=2)
CRESTS = [(0.2, -1000.0, Resolution()), (0.4, -1000.0, COARSE), (9.81, 5.0, Resolution())]


@pytest.mark.parametrize(("gravity", "shelf", "resolution"), CRESTS)
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_highest_place_of_a_rebound_of_many_crests(
    sense: float, gravity: float, shelf: float, resolution: Resolution
) -> None:
    """A ball above a table that shakes: the parabola less two waves, on a fine grid.

    Its stop, off zero, is a lower or an upper one; another ball bounces beside and cuts its flights
    into pieces, of panels with one crest or with several; or a shelf catches it, where drives alone
    tell the gap. A grid of 1e5 places misses a crest by the square of half its spacing.
    """
    waves = {4: 3e-3, 7: 1e-3}
    cosine = [1e3 * waves.get(n, 0.0) for n in range(1, 8)]
    gap = {"at_mm": 30.0 * sense, "rate_mm_per_s": -80.0 * sense}
    shaken = machine(
        [link("table"), slide("lift", "frame", "table", (0.0, 1.0)),
         link("ball"), slide("gap", "table", "ball", (0.0, sense)),
         link("shelf", 1e-3), slide("height", "frame", "shelf", (0.0, 1.0)),
         link("carriage", 1e-3), slide("across", "shelf", "carriage"),
         link("beside"), slide("z", "frame", "beside", (0.0, 1.0))], 3, gravity=gravity,
        drives={"lift": {"joint": "lift", "law": "fourier", "cosine_mm": cosine, **SLED}},
        stops={"table": {"joint": "gap", "restitution": 0.9, "at_mm": 7.0 * sense,
                         "side": "lower" if sense > 0.0 else "upper"},
               "shelf": {"joint": "height", "restitution": 0.0, "at_mm": shelf},
               "floor": {"joint": "z", "restitution": 0.8}},
        closures={"tie": {"frame_a": "carriage", "frame_b": "ball"}},
        initial={"gap": gap, "z": {"at_mm": 30.0}},
    )  # fmt: skip
    turns = 2 if shelf > 0.0 else 8
    case = Case(speed_rpm=60.0, window="cycle", cycles=turns, start_index=0.0,
                resolution=resolution)  # fmt: skip
    solution = simulate(shaken, case)
    hits = (hit for hit in solution.collisions if hit.stop == "table")
    rebounds = [hit for hit in hits if (hit.rebound_time or 0.0) > 0.02]
    assert len(rebounds) > 2
    assert any("shelf" in event.stops for event in solution.events) == (shelf > 0.0)

    def table(t: np.ndarray, order: int) -> np.ndarray:
        """Place of the table, above that at the start, or its rate."""
        found = sum(
            size * (n * math.tau) ** order * np.cos(n * math.tau * t + 0.5 * math.pi * order)
            for n, size in waves.items()
        )
        return np.asarray(found - (order == 0) * sum(waves.values()))

    for hit in rebounds:
        t = np.linspace(0.0, hit.rebound_time or 0.0, 100_001)
        start = table(np.array(hit.t), 0) + 7e-3
        flown = start + (table(np.array(hit.t), 1) + hit.separation_rate) * t - 0.5 * gravity * t**2
        gaps = np.maximum(flown, 1e-3 * shelf) - table(hit.t + t, 0) - 7e-3
        assert hit.rebound_amplitude == pytest.approx(gaps.max(), rel=1e-8)


def test_what_pulls_between_two_points_gives_no_impulse(e62: Mechanism) -> None:
    """Forces are finite: joints take what they take in the machine without these springs."""
    run = run_of("elements")
    assert len(run.mechanism.struts) == 2
    (event, *_), bare = run.events, simulate(e62, speed_rpm=650.0).trajectory
    found, alone = run.trajectory.impulses(event), bare.impulses(event)
    assert found.contacts == alone.contacts
    for kind in ("joints", "closures"):
        mine, other = getattr(found, kind), getattr(alone, kind)
        assert mine.keys() == other.keys()
        assert all(np.array_equal(mine[name], other[name]) for name in mine)
    assert max(np.abs(wrench).max() for wrench in found.joints.values()) > 0.1
