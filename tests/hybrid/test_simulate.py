"""The phase manager: how series end, how runs end, turns that repeat, and several threads."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import nipper_pin as nip
from nipper_pin.hybrid import advance
from nipper_pin.mechanism.skeleton import write_skeleton

BOUNCING_MASS = Path(__file__).parents[1] / "verification" / "models" / "bouncing_mass"


@pytest.mark.parametrize("rest_rate", [1.0, 0.02, 1e-4])
def test_a_threshold_ends_the_series_at_the_first_slower_rebound(
    e62: nip.Mechanism, rest_rate: float
) -> None:
    """The last rebound is slower than the threshold and the one before is not.

    The rest comes with that collision, not at the limit; its state is at rest.
    """
    solution = nip.simulate(e62, nip.Case(speed_rpm=650.0, rest_rate=rest_rate))
    rebounds = [item.separation_rate for item in solution.collisions]
    assert rebounds[-1] < rest_rate <= rebounds[-2]
    rest = solution.events[-1]
    assert rest.kind is nip.EventKind.REST
    assert rest.t == solution.collisions[-1].t
    assert rest.v_after[e62.stop("jaw").index] == 0.0
    assert solution.outcome is nip.Outcome.AT_REST


def test_a_transition_is_continued_as_a_whole_turn_goes_on(e62: nip.Mechanism) -> None:
    """Behind the rest the jaw stays shut, and drives alone move the machine, until it opens."""
    run = nip.simulate(e62, nip.Case(speed_rpm=650.0))
    turn = nip.simulate(e62, nip.Case(speed_rpm=650.0, window="cycle"))
    touch = next(hit.t for hit in turn.collisions if hit.stop == "jaw")
    further = run.continued(run.shaft.period)
    opening = next(
        event for event in turn.events if "jaw" in event.closed_before - event.closed_after
    )
    assert further.events == run.events
    assert further.segments[-1].t_end == pytest.approx(opening.t - touch, rel=1e-9)
    t = np.linspace(run.events[-1].t, further.segments[-1].t_end, 7)[:-1]
    # At the rest itself, whose fields are those of the collision before it, too.
    assert np.abs(run.events[-1].q - turn.trajectory.evaluate(touch + t[0]).q).max() > 1e-6
    for motion, times in (
        (further.trajectory.evaluate(t), t), (run.motion_at(run.events[-1]), t[:1]),
    ):  # fmt: skip
        wanted = turn.trajectory.evaluate(touch + times)
        most = float(np.abs(wanted.v).max())
        np.testing.assert_allclose(motion.q, wanted.q, rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(motion.v, wanted.v, rtol=0.0, atol=1e-10 * most)


def test_threshold_and_limit_agree_up_to_the_threshold(e62: nip.Mechanism) -> None:
    """Until the threshold acts both runs are the same bits; then the limit lies later.

    What the threshold cuts off is the rest of the series, 2 w / (a (1 - e)) with w the last
    rebound rate.
    """
    limit = nip.simulate(e62, nip.Case(speed_rpm=650.0))
    threshold = nip.simulate(e62, nip.Case(speed_rpm=650.0, rest_rate=0.02))
    count = len(threshold.collisions)
    assert [c.t for c in threshold.collisions] == [c.t for c in limit.collisions[:count]]
    cut = limit.events[-1].t - threshold.events[-1].t
    last = limit.collisions[count - 1]
    # First rebound left out and its geometric series: the ratio of flights is e to 1 % here.
    assert last.rebound_time is not None
    assert cut == pytest.approx(last.rebound_time / (1.0 - 0.2), rel=0.01)


def test_without_restitution_the_first_collision_is_the_rest() -> None:
    """With e = 0 the jaw stays closed: one collision, rest at the same time, phase 2.

    With e = 1e-12 rest comes 2 e w / a later to first order: w = 16.8 rad/s and a near 1200 rad/s^2
    make 3e-14 s; no flight can be resolved there and none is needed.
    """
    mechanism = nip.load("e62", {"stops.jaw.restitution": 0.0})
    solution = nip.simulate(mechanism, nip.Case(speed_rpm=650.0))
    assert [event.kind for event in solution.events] == [
        nip.EventKind.COLLISION,
        nip.EventKind.REST,
    ]
    collision = solution.collisions[0]
    assert collision.separation_rate == 0.0
    assert (collision.rebound_amplitude, collision.rebound_time) == (0.0, 0.0)
    assert solution.transitions[0].duration == 0.0
    assert solution.events[-1].closed_after == frozenset({"jaw"})
    # All of the jaw's energy is lost: M_eff w^2 / 2 = P w / 2.
    impulse = collision.event.P_N["jaw"]
    assert collision.energy_lost == pytest.approx(
        -0.5 * impulse * collision.approach_rate, rel=1e-14
    )
    next_to_none = nip.load("e62", {"stops.jaw.restitution": 1e-12})
    solution = nip.simulate(next_to_none, nip.Case(speed_rpm=650.0))
    assert solution.outcome is nip.Outcome.AT_REST
    assert len(solution.collisions) <= 2
    assert 0.0 < solution.events[-1].t < 1e-13
    assert solution.events[-1].closed_after == frozenset({"jaw"})


def test_without_losses_there_is_no_rest_and_the_run_says_so() -> None:
    """With e = 1 at both stops the run ends after a turn; its outcome is a sentence about rest.

    Every collision reflects the rate exactly and loses nothing.
    """
    mechanism = nip.load("e62", {"stops.jaw.restitution": 1.0, "stops.steeve.restitution": 1.0})
    solution = nip.simulate(mechanism, nip.Case(speed_rpm=450.0))
    assert solution.outcome is nip.Outcome.NO_REST
    assert "did not come to rest" in solution.outcome.value
    assert solution.transitions == ()
    for item in solution.collisions:
        assert item.separation_rate == -item.approach_rate
        assert item.energy_lost == pytest.approx(0.0, abs=1e-15)
    assert solution.checks.energy_balance <= 1e-9


def test_the_largest_number_of_collisions_is_kept_in_every_turn(e62: nip.Mechanism) -> None:
    """A turn at 650 r/min has 21 collisions: 21 are enough for three turns, 20 are not for one."""
    for most in (1, 2, 5):
        short = nip.simulate(e62, nip.Case(speed_rpm=650.0, max_collisions=most))
        assert len(short.collisions) == most
        assert short.outcome is nip.Outcome.TOO_MANY_COLLISIONS
    assert "max_collisions" in short.outcome.value
    case = {"speed_rpm": 650.0, "window": nip.Window.CYCLE, "cycles": 3, "reuse_cycles": False}
    a_turn = len(nip.simulate(e62, nip.Case(**case)).collisions) // 3
    assert (
        nip.simulate(e62, nip.Case(**case, max_collisions=a_turn + 1)).outcome
        is nip.Outcome.COMPLETED
    )
    short = nip.simulate(e62, nip.Case(**case, max_collisions=a_turn - 1))
    assert short.outcome is nip.Outcome.TOO_MANY_COLLISIONS
    assert len(short.collisions) == a_turn - 1


def _copies_of_one_turn(copied: nip.Solution) -> None:
    """Sources lie in what was computed, equal themselves there, and whole periods apart."""
    period, ours = copied.shaft.period, {event.number: event for event in copied.events}
    moved = [event for event in copied.events if event.source != event.number]
    assert moved
    for event in copied.events:
        original = ours[event.source]
        assert original.source == original.number
        turns = (event.t - original.t) / period
        assert turns == pytest.approx(round(turns), abs=1e-12)
        assert (event.kind, event.stops) == (original.kind, original.stops)
        assert event.P_N == original.P_N
    for place, segment in enumerate(copied.segments):
        original = copied.segments[segment.source]
        assert copied.segments[original.source] is original
        assert (place == segment.source) == (segment is original)
        assert all(a.a is b.a for a, b in zip(segment.panels, original.panels, strict=True))


@pytest.mark.parametrize("speed", [450.0, 650.0])
def test_copied_turns_equal_computed_ones(e62: nip.Mechanism, speed: float) -> None:
    """Three turns with copies and three computed ones have the same events to 1e-11 s.

    Both start from exact kinematics; the bound is the round-off of the times, some 1e-16 s, and of
    a series of bounces, which amplifies it little.
    """
    case = {"speed_rpm": speed, "window": nip.Window.CYCLE, "cycles": 3}
    copied = nip.simulate(e62, nip.Case(**case, reuse_cycles=True))
    computed = nip.simulate(e62, nip.Case(**case, reuse_cycles=False))
    assert copied.repeated_from is not None
    assert computed.repeated_from is None
    assert copied.evaluations < 0.7 * computed.evaluations
    assert len(copied.events) == len(computed.events)
    _copies_of_one_turn(copied)
    for ours, theirs in zip(copied.events, computed.events, strict=True):
        assert (ours.number, ours.kind, ours.stops) == (theirs.number, theirs.kind, theirs.stops)
        assert ours.closed_after == theirs.closed_after
        assert ours.t == pytest.approx(theirs.t, abs=1e-11)
        np.testing.assert_allclose(ours.q, theirs.q, rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(ours.v_after, theirs.v_after, rtol=0.0, atol=1e-8)
    for ours, theirs in zip(copied.collisions, computed.collisions, strict=True):
        assert ours.index == pytest.approx(theirs.index, abs=1e-9)
        # Those that a run leaves out included: they are followed once for all copies of a turn.
        for name in ("rebound_time", "rebound_amplitude"):
            told, true = getattr(ours, name), getattr(theirs, name)
            assert (told is None) == (true is None)
            assert (told or 0.0) == pytest.approx(true or 0.0, rel=1e-4, abs=1e-11)
    times = np.linspace(0.0, copied.trajectory.span[1], 100)
    one, two = (item.trajectory.evaluate(times).q for item in (copied, computed))
    np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-10)


def test_turns_of_a_crank_are_copied_too(tmp_path: Path) -> None:
    """The crank of a press winds on by 2 pi a turn; five turns cost no more than one.

    Copies that did not wind on, or wound the wrong joint, would be 2 pi away from computed turns.
    """
    press = nip.load(write_skeleton(tmp_path / "press"))
    case = {"speed_rpm": 120.0, "window": nip.Window.CYCLE}
    one = nip.simulate(press, nip.Case(**case))
    copied = nip.simulate(press, nip.Case(**case, cycles=5))
    computed = nip.simulate(press, nip.Case(**case, cycles=5, reuse_cycles=False))
    assert copied.repeated_from == 1
    assert copied.evaluations == one.evaluations
    _copies_of_one_turn(copied)
    assert len(copied.events) == len(computed.events) == 5 * len(one.events)
    for ours, theirs in zip(copied.events, computed.events, strict=True):
        assert ours.t == pytest.approx(theirs.t, abs=1e-13)
        np.testing.assert_allclose(ours.q, theirs.q, rtol=0.0, atol=1e-12)
    times = np.linspace(0.0, copied.trajectory.span[1], 333)
    ours, theirs = copied.trajectory.evaluate(times), computed.trajectory.evaluate(times)
    np.testing.assert_allclose(ours.q, theirs.q, rtol=0.0, atol=1e-12)
    crank = press.joints[0].index
    assert ours.q[-1, crank] - ours.q[0, crank] == pytest.approx(10.0 * np.pi, abs=1e-12)


@pytest.mark.parametrize("bound", ["nothing", "spring", "stop"])
def test_what_is_bound_to_a_winding_hinge_does_not_repeat(bound: str, tmp_path: Path) -> None:
    """A pin that winds up a spring, or turns towards a stop, is not where it was a turn before.

    The spring is weak and the stop is far away: but for them the turns would be the same.
    """
    folder = write_skeleton(tmp_path / "press")
    tables = {
        "nothing": "",
        "spring": "[springs.coil]\njoint = 'crank_pin'\nstiffness_N_m_per_rad = 1e-3\n"
        "preload_deg = 0.0\n",
        "stop": "[stops.far]\njoint = 'crank_pin'\nat_deg = -1e5\nrestitution = 0.2\n",
    }
    with (folder / "press.toml").open("a") as file:
        file.write(tables[bound])
    case = nip.Case(speed_rpm=120.0, window=nip.Window.CYCLE, cycles=3)
    repeated = nip.simulate(nip.load(folder), case).repeated_from
    assert repeated == (1 if bound == "nothing" else None)


def test_progress_is_reported_after_every_turn(e62: nip.Mechanism) -> None:
    """The callback counts the turns done, and ends with all of them."""
    seen: list[tuple[int, int]] = []
    case = nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE, cycles=3, reuse_cycles=False)
    nip.simulate(e62, case, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(1, 3), (2, 3), (3, 3)]
    seen.clear()
    case = nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE, cycles=50)
    nip.simulate(e62, case, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (50, 50)
    assert len(seen) < 50


def test_a_phase_of_too_many_panels_is_refused(
    e62: nip.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The longest phase passes a limit of as many panels as it has and not one of one less.

    Without the limit both would pass; what is refused names the time that was reached.
    """
    resolution = nip.Resolution(panels_per_turn=400)
    case = nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE, resolution=resolution)
    most = max(len(part.panels) for part in nip.simulate(e62, case).segments)
    monkeypatch.setattr(advance, "_MOST_PANELS", most)
    nip.simulate(e62, case)
    monkeypatch.setattr(advance, "_MOST_PANELS", most - 1)
    with pytest.raises(nip.ConvergenceError, match=f"more than {most - 1} panels") as caught:
        nip.simulate(e62, case)
    assert caught.value.evidence["t"] > 0.0


def test_start_index_shifts_the_window_only(e62: nip.Mechanism) -> None:
    """A turn that starts at another index of phase 1 has its collisions at the same indices.

    Phase 1 is kinematic, so nothing remembers the start.
    """
    indices = []
    for start in (20.0, 24.0, 26.5):
        case = nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE, start_index=start)
        indices.append([item.index for item in nip.simulate(e62, case).collisions])
    for other in indices[1:]:
        assert other == pytest.approx(indices[0], abs=1e-10)


@pytest.mark.parametrize(("e", "speed"), [(0.95, 600.0), (0.9361778318503078, 635.1646837662381)])
def test_a_collision_on_the_limit_of_the_window_ends_the_run(e: float, speed: float) -> None:
    """A jaw that bounces without rest, caught by the steeve, closes again after exactly one turn.

    That collision falls on the limit of the window, to the last bit or a few: whichever side it
    comes to lie, the run ends there and says that there was no rest.
    """
    overrides = {
        "stops.jaw.restitution": e,
        "stops.steeve.restitution": 0.0,
        "springs.steeve.stiffness_N_per_m": 10731.35407652929,
    }
    solution = nip.simulate(nip.load("e62", overrides), nip.Case(speed_rpm=speed))
    assert solution.outcome is nip.Outcome.NO_REST
    period = solution.shaft.period
    assert solution.trajectory.span[1] == pytest.approx(period, rel=1e-14)
    jaw = solution.mechanism.stop("jaw").index
    gap = solution.trajectory.evaluate(solution.trajectory.span[1], left=True).q[0, jaw]
    assert gap == pytest.approx(0.0, abs=1e-12)
    assert solution.checks.energy_balance <= 1e-9


@pytest.mark.parametrize("start_index", [-40.0, -40.0 - 1e-12, -40.0 + 1e-12, -60.0])
def test_a_drive_that_winds_on_is_not_copied(start_index: float) -> None:
    """A table that rises with every turn meets its mass in the second one, with or without reuse.

    The first turn is pure kinematics from end to end with the same stop closed, but the drive does
    not come back with the cylinder, so it may not stand for the second. A start 40 indices before
    the touch puts the collision on the limit between the turns, on either side of it.
    """
    mechanism = nip.load(BOUNCING_MASS, {"drives.table.lead_mm_per_turn": 60.0})
    case = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE, cycles=2, start_index=start_index)
    solution = nip.simulate(mechanism, case)
    # One turn takes a second.
    assert solution.collisions[0].t == pytest.approx(-start_index / 40.0, rel=1e-13)
    assert solution.events[-1].kind is nip.EventKind.REST


def test_slow_inertial_shafts_shorten_the_panels(e62: nip.Mechanism) -> None:
    """A panel of a slow turn is long against the period of the elastic shafts.

    Its iteration ran away, Pinocchio returned NaN, and the run ended with "the closures lose rank"
    at index 24, where nothing is singular.
    """
    case = nip.Case(speed_rpm=90.0, window=nip.Window.CYCLE, drive=nip.DriveMode.INERTIAL)
    solution = nip.simulate(e62, case)
    assert solution.outcome is nip.Outcome.COMPLETED
    assert solution.checks.energy_balance < 1e-9


@pytest.mark.slow
def test_tables_of_many_turns_grow_with_their_number(e62: nip.Mechanism) -> None:
    """Every rebound searched all segments, so that 10,000 turns never ended.

    Copies of a turn share their arrays: the dynamics is evaluated for the tables of one turn, and
    no more for those of 2,000.
    """
    counts = []
    for cycles in (2, 2000):
        solution = nip.simulate(
            e62, nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE, cycles=cycles)
        )
        before = solution.system.body.evaluations
        assert len(solution.collisions) % cycles == 0
        assert len(solution.errors) == len(solution.events)
        counts.append(solution.system.body.evaluations - before)
    assert counts[0] == counts[1] > 0


def test_threads_share_a_mechanism() -> None:
    """Eight threads, three cases each of another speed, have the bits of runs alone.

    A shared `pin.Data` would mix them up.
    """
    mechanism = nip.load("e62")
    cases = [nip.Case(speed_rpm=450.0 + 25.0 * k) for k in range(8)]
    alone = [nip.simulate(mechanism, case).events for case in cases]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda case: nip.simulate(mechanism, case).events, cases * 3))
    for events, expected in zip(together, alone * 3, strict=True):
        assert len(events) == len(expected) > 2
        for one, other in zip(events, expected, strict=True):
            assert (one.t, one.kind, one.P_N) == (other.t, other.kind, other.P_N)
            assert np.array_equal(one.q, other.q)
            assert np.array_equal(one.v_after, other.v_after)
