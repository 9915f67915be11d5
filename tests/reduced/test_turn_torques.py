"""Largest torques of the drives, judged by the forces of the direct engine."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from nipper_pin import Case, EventKind, InputError, Mechanism, Solution, load, simulate
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.reduced.kernels.turn_layout import Charts, TurnWork
from nipper_pin.reduced.turns import TurnStatus, turn_torques
from nipper_pin.reduced.turns import peak_torques as module

# Forces of the direct engine between events, by their largest value.
DIRECT = 1e-9
PLACES = 60


def largest(run: Solution, drive: str, begin: float) -> float:
    """Largest torque from a time on: the peaks of a grid on every segment, refined."""
    most = 0.0
    rests = np.array([event.t for event in run.events if event.kind is EventKind.REST])
    for segment in run.segments:
        # A stretch at rest begins with the bounces that are not computed.
        inside = rests[(rests >= segment.t_start) & (rests < segment.t_end)]
        low, high = max(segment.t_start, begin, *inside), segment.t_end
        if high - low <= 1e-12 * run.shaft.period:
            continue
        t = np.linspace(low, high, PLACES + 1)
        first = run.trajectory.reactions(t[:-1]).drives[drive]
        last = run.trajectory.reactions(t[-1:], left=True).drives[drive]
        torque = np.abs([*first, *last])
        most = max(most, torque[0], torque[-1])
        for i in range(1, PLACES):
            if torque[i] >= max(torque[i - 1], torque[i + 1]) and torque[i] > 0.9 * most:

                def below(at: float) -> float:
                    return -abs(float(run.trajectory.reactions(at).drives[drive][0]))

                found = minimize_scalar(
                    below, bounds=(t[i - 1], t[i + 1]), method="bounded", options={"xatol": 1e-9}
                )
                most = max(most, -found.fun)
    return float(most)


def judged(mechanism: Mechanism, speed: float, turns: int) -> None:
    """The torques of the last turn, within the stated errors."""
    found = turn_torques(mechanism, speed_rpm=speed, turns=turns)
    assert found.status.tolist() == [TurnStatus.FOLLOWED]
    run = simulate(mechanism, Case(speed_rpm=speed, window="cycle", cycles=turns))
    for place, drive in enumerate(found.drives):
        true = largest(run, drive, (turns - 1) * run.shaft.period)
        value, error = found.largest[0, place], found.error[0, place]
        assert true > 0.0
        assert abs(value - true) <= error + DIRECT * true
        assert error <= 1e-7 * true


@pytest.mark.parametrize(("speed", "turns"), [(450.0, 1), (650.0, 1), (1200.0, 3)])
def test_torques_of_the_nipper(e62: Mechanism, speed: float, turns: int) -> None:
    """Both shafts; at 1,200 r/min the largest torque comes while the jaw bounces."""
    judged(e62, speed, turns)


@pytest.mark.parametrize("name", ["ratchet_feed", "door_closer", "jaw_crusher"])
def test_torques_of_machines_of_the_gallery(name: str) -> None:
    """Springs, a damper, stops on both sides."""
    mechanism = drawn_mechanism(GALLERY[name]())
    judged(mechanism, mechanism.cylinder.rated_speed_rpm, 1)


def test_numbers_of_a_case_change_the_torque(e62: Mechanism) -> None:
    """A stiffer spring and another preload, as if the mechanism had them."""
    changed = load(
        "e62",
        {"springs.steeve.stiffness_N_per_m": 13000.0, "springs.steeve.preload_length_mm": 22.0},
    )
    numbers = turn_torques(e62, speed_rpm=650.0, stiffness=13000.0, preload=0.022)
    own = turn_torques(changed, speed_rpm=650.0)
    np.testing.assert_allclose(numbers.largest, own.largest, rtol=1e-9)
    usual = turn_torques(e62, speed_rpm=650.0)
    assert np.abs(usual.largest / own.largest - 1.0).min() > 1e-3


def test_a_batch_is_its_cases_and_reports_the_last_turns(e62: Mechanism) -> None:
    """At 1,900 r/min two turns alternate, and so do their torques."""
    speeds = np.array([450.0, 1900.0])
    many = turn_torques(e62, speed_rpm=speeds, turns=60, last=3)
    assert many.largest.shape == many.error.shape == (2, 3, 2)
    for i, speed in enumerate(speeds):
        one = turn_torques(e62, speed_rpm=speed, turns=60, last=3)
        assert one.largest.tobytes() == many.largest[i].tobytes()
    # The turn at 450 r/min repeats at once: there is one.
    assert np.isnan(many.largest[0, 1:]).all()
    last, before, earlier = many.largest[1, :, 0]
    assert last == pytest.approx(earlier, rel=1e-8)
    assert abs(last - before) > 1e-7 * last


def test_cases_that_cannot_be_followed_have_no_torque(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Too many collisions, or more panels than there is room for, are told by the status."""
    few = turn_torques(e62, speed_rpm=650.0, max_collisions=3)
    roomy = module.scratch

    def tight(charts: Charts, most: int = 1, panels: int = 0) -> TurnWork:
        return roomy(charts, most, min(panels, 5))

    monkeypatch.setattr(module, "scratch", tight)
    full = turn_torques(e62, speed_rpm=650.0)
    whole = turn_torques(e62, speed_rpm=650.0, last=1)
    for found in (few, full):
        assert found.status[0] == TurnStatus.TOO_MANY_COLLISIONS
        assert np.isnan(found.largest).all()
    assert whole.largest.shape == (1, 1, 2)
    with pytest.raises(InputError, match="turns"):
        turn_torques(e62, speed_rpm=450.0, turns=0)


@pytest.mark.campaign
def test_torques_may_have_no_tables_as_wide_as_those_of_a_flight() -> None:
    """Such a case leaves the widest tables, and does not end the others."""
    mechanism = drawn_mechanism(GALLERY["stephenson_1"]())
    speeds = mechanism.cylinder.rated_speed_rpm * np.array([1.0, 12.0])
    found = turn_torques(mechanism, speed_rpm=speeds, restitution=0.9)
    assert found.status.tolist() == [TurnStatus.FOLLOWED, TurnStatus.LEFT_GAP]
    assert np.isnan(found.largest).tolist() == [[False], [True]]
