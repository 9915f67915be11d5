"""The film of a run: its pace, its frames, and gaps that are drawn larger."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from runs_shown import run_of, turn
from small_machines import SHAFT, hinge, link, machine, slide

from nipper_pin import (
    Case,
    InputError,
    SingularConfigurationError,
    Solution,
    Window,
    load,
    simulate,
)
from nipper_pin.view.scene import Film, Look, film, solids
from nipper_pin.view.scene.pace import _profile, pace
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.scene.rebounds import rebound_flights
from nipper_pin.view.scene.tracks import animation

MODELS = Path(__file__).parents[1] / "verification" / "models"


@pytest.fixture(scope="module")
def large(cycle: Solution) -> Film:
    return film(cycle, Look(exaggerate=50.0))


# Pace.


def test_time_is_stretched_around_events_and_nowhere_else(cycle: Solution) -> None:
    """The two clocks, differenced: 1000 within 1 % of a turn of any event, 50 far from all.

    Playback grows by the integral of the stretch, so that from frame to frame its rate lies between
    the stretches of both, except for round-off in differences of nearby times.
    """
    found = pace(cycle, 1000.0)
    events = np.array([event.t for event in cycle.events])
    assert set(events) <= set(found.machine)
    assert found.machine[0] == 0.0
    assert found.machine[-1] == cycle.segments[-1].t_end
    assert (np.diff(found.machine) > 0.0).all()
    away = np.abs(found.machine[:, None] - events).min(axis=1) / cycle.shaft.period
    np.testing.assert_allclose(found.stretch[away < 0.0099], 1000.0, rtol=1e-9)
    np.testing.assert_allclose(found.stretch[away > 0.055], 50.0, rtol=1e-9)
    rate = np.diff(found.playback) / np.diff(found.machine)
    low, high = (f(found.stretch[1:], found.stretch[:-1]) for f in (np.minimum, np.maximum))
    assert (rate > low * (1.0 - 1e-6)).all()
    assert (rate < high * (1.0 + 1e-6)).all()


def test_slow_motion_of_groups_of_events() -> None:
    """Slow from 1 % of a turn before the first to as long after the last, with flanks of 1 %.

    Events less than 7 % of a turn apart are one group; in a flank every hundredth of it changes
    the speed by the same ratio.
    """
    period, slow = 0.5, 800.0
    events = period * np.array([0.30, 0.36, 0.60, 0.68])
    knots, stretch = _profile(events, period, period, slow)
    for share, wanted in (
        (0.0, 50.0), (0.279, 50.0), (0.285, 200.0), (0.291, slow), (0.33, slow), (0.369, slow),
        (0.375, 200.0), (0.381, 50.0), (0.57, 50.0), (0.585, 200.0), (0.60, slow), (0.609, slow),
        (0.64, 50.0), (0.671, slow), (0.695, 200.0), (0.8, 50.0), (1.0, 50.0),
    ):  # fmt: skip
        assert np.interp(share * period, knots, stretch) == pytest.approx(wanted, rel=1e-9), share
    assert (knots[0], knots[-1]) == (0.0, period)


def test_frames_of_a_film(cycle: Solution) -> None:
    """Thirty a second besides events, at most six thousand; never faster than 1 : 50."""
    events = len({item.t for item in cycle.events})
    for slow in (20.0, 1000.0):
        found = pace(cycle, slow)
        steps = np.diff(found.playback)
        assert steps.max() <= 1.0 / 30.0 + 1e-9
        assert abs(len(found.machine) - 30.0 * found.playback[-1]) < events + 3
        assert found.stretch.min() == pytest.approx(min(slow, 50.0), rel=1e-12)
        assert found.stretch.max() == pytest.approx(slow, rel=1e-12)
    assert 5998 <= len(pace(cycle, 1e5).machine) <= 6000 + events
    plain = pace(cycle, 20.0)
    np.testing.assert_allclose(plain.playback, 20.0 * plain.machine, rtol=1e-12)
    np.testing.assert_allclose(plain.playback_at(cycle.events[3].t), 20.0 * cycle.events[3].t)


def test_of_many_turns_the_first_two_are_shown(many_turns: Solution) -> None:
    shown = film(many_turns, Look())
    assert shown.pace.machine[-1] == pytest.approx(2.0 * many_turns.shaft.period, rel=1e-12)
    document = readings(shown)
    assert document["phases"][-1]["start"] < document["duration"]
    assert document["collisions"][-1]["at"] < document["duration"]
    for clip in animation(shown, solids(many_turns.mechanism))["animations"]:
        for found in clip["clip"]["tracks"]:
            t = np.frombuffer(found["times"].data, dtype="<f4")
            # All tracks end together, or the film would come apart when it starts again.
            assert t[-1] == pytest.approx(document["duration"], rel=1e-6)
            assert (np.diff(t) >= 0.0).all()


# Gaps that are drawn larger.


def test_an_exaggerated_gap_keeps_the_loops_closed(cycle: Solution, large: Film) -> None:
    """Only the loops' other coordinates follow; frames of the cut joints meet to round-off."""
    mechanism = cycle.mechanism
    model, data = mechanism.model, mechanism.model.createData()
    jaw = mechanism.stop("jaw").index
    gap, t = large.q[:, jaw], large.pace.machine
    larger = np.ones(len(gap))
    for hit in cycle.collisions:
        if hit.stop == "jaw" and hit.rebound_time is not None:
            inside = (t >= hit.t) & (t <= hit.t + hit.rebound_time)
            larger[inside] = min(50.0, math.radians(6.0) / hit.rebound_amplitude)
    drawn = large.drawn[:, jaw]
    np.testing.assert_allclose(drawn, larger * gap, rtol=1e-12, atol=1e-16)
    # Rebounds reach the limit; closing and opening are drawn as they are, without a jump.
    first = next(hit for hit in cycle.collisions if hit.stop == "jaw")
    assert drawn[(t > first.t) & (t < first.t + first.rebound_time)].max() > math.radians(5.9)
    np.testing.assert_array_equal(drawn[t < first.t], gap[t < first.t])
    for drive in mechanism.drives:
        np.testing.assert_array_equal(large.drawn[:, drive.index], large.q[:, drive.index])
    for k in range(0, len(gap), 20):
        pin.framesForwardKinematics(model, data, large.drawn[k])
        for closure in mechanism.closures:
            a, b = (
                data.oMf[model.getFrameId(name)].translation
                for name in (closure.frame_a, closure.frame_b)
            )
            assert np.abs(a - b)[[0, 2]].max() < 1e-14
    assert film(cycle, Look()).drawn is not large.drawn


def test_an_exaggerated_gap_opens_away_from_its_stop() -> None:
    """Drawn five times as large, the gap of an upper stop grows downwards from the stop's place."""
    parts = [
        link("crank", 1.0, 0.1), hinge("crank_axis", "frame", "crank", (1.0, 0.0)),
        link("hand"), slide("reach", "crank", "hand"),
    ]  # fmt: skip
    drives = {"crank": {"joint": "crank_axis", "law": "fourier", "sine_rad": [0.5], **SHAFT}}
    stop = {"joint": "reach", "restitution": 0.5, "side": "upper", "at_mm": 2.0}
    spring = {"joint": "reach", "stiffness_N_per_m": 9.0, "preload_length_mm": -4.0}
    mechanism = machine(parts, 2, drives=drives, stops={"end": stop}, springs={"s": spring})
    solution = simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    plain, large = film(solution, Look()), film(solution, Look(exaggerate=5.0))
    end = mechanism.stop("end")
    gap, drawn = end.gaps(plain.drawn), end.gaps(large.drawn)
    t, limit = plain.pace.machine, 0.03 * mechanism.reach_m
    for hit in solution.collisions[:2]:
        rebound = (t >= hit.t) & (t <= hit.t + hit.rebound_time)
        assert 0.0 < hit.rebound_amplitude < limit / 5.0
        assert drawn[rebound] == pytest.approx(5.0 * gap[rebound], rel=1e-9, abs=1e-15)
    assert drawn.min() >= -1e-15


def test_the_heights_drawn_larger_are_those_of_the_transition_stop() -> None:
    """Of two balls that fall from one height and are struck together, that of its own floor."""
    both = run_of("balls")
    e_N = both.mechanism.stop(both.mechanism.transition_stop).restitution
    assert rebound_flights(both)[0].highest == pytest.approx(e_N**2 * 0.1, rel=1e-12)


# What is refused.


@pytest.mark.parametrize("values", [{"slow": 1.0}, {"slow": 1e5}, {"exaggerate": 50.0}])
def test_looks_up_to_their_ends(values: dict[str, float]) -> None:
    assert Look(**values)
    with pytest.raises(InputError, match=r"cannot be used: 1 to (50|100000)$|: 1 to 1e\+05"):
        Look(**{key: 1.001 * value if value > 1.0 else 0.999 for key, value in values.items()})


def test_a_run_without_motion_says_so() -> None:
    still = simulate(load("e62", {"stops.jaw.restitution": 0.0}), Case(speed_rpm=450.0))
    with pytest.raises(InputError, match="no motion to show"):
        film(still, Look())


def test_a_gap_that_is_not_there_cannot_be_exaggerated() -> None:
    mechanism = load(MODELS / "four_bar")
    with pytest.raises(InputError, match="no transition stop"):
        film(turn(mechanism, 300.0), Look(exaggerate=2.0))


def test_loops_that_do_not_close_cannot_be_exaggerated(
    transition: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        message = "a dead centre"
        raise SingularConfigurationError(message)

    monkeypatch.setattr(sys.modules["nipper_pin.view.scene.film"], "close_positions", fails)
    words = r"gap of stop jaw cannot be drawn 12 times as large, .*\(a dead centre\); use a smaller"
    with pytest.raises(InputError, match=words) as caught:
        film(transition, Look(exaggerate=12.0))
    assert caught.value.evidence == {"exaggerate": 12.0}
