"""Every key of the published study's record, and of its parts, from studies that are made up."""

from __future__ import annotations

import math
from dataclasses import asdict
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_studies import STUDIES

from benchmarks.paper import (
    counts,
    ratios,
)  # fmt: skip
from benchmarks.paper.counts import Counts
from benchmarks.paper.drives import DriveComparison, DriveEffect
from benchmarks.paper.fixed_step import FixedStep, Rule, _rule
from benchmarks.paper.phases import PhaseOne, Release
from benchmarks.paper.ratios import Ratio
from benchmarks.paper.shares import MAP_RESTITUTIONS, DurationMap, Shares
from nipper_pin.errors import InputError


def test_record_of_a_study() -> None:
    found = STUDIES.speed.record()
    assert found == [
        {"speed": 450.0, "rebound_amplitude_1": 2.0, "rebound_amplitude_2": 4.0,
         "rebound_time_s_1": 20.0, "rebound_time_s_2": 50.0, "duration_s": 100.0,
         "first_two_share": 0.9, "premise_holds": False},
        {"speed": 650.0, "rebound_amplitude_1": 3.0, "rebound_amplitude_2": 7.0,
         "rebound_time_s_1": 19.0, "rebound_time_s_2": 51.0, "duration_s": 110.0,
         "first_two_share": 0.91, "premise_holds": None},
    ]  # fmt: skip
    assert [item.name for item in STUDIES] == ["speed", "restitution", "stiffness"]


def test_ratios_of_studies() -> None:
    """The last case by the first, less one; shares as they are; deviations and their number."""
    found = ratios.ratio_values(STUDIES)
    assert found == pytest.approx({
        "speed.first_rebound_amplitude_increase": 0.5,
        "speed.second_rebound_amplitude_increase": 0.75,
        "speed.first_two_share_450": 0.9, "speed.first_two_share_650": 0.91,
        "restitution.first_rebound_amplitude_increase": 0.5,
        "restitution.second_rebound_amplitude_increase": 0.75,
        "restitution.transition_time_increase": 0.1,
        "stiffness.first_rebound_amplitude_change": 0.5,
        "stiffness.second_rebound_amplitude_change": 0.75,
        "stiffness.first_rebound_time_change": -0.05,
        "stiffness.second_rebound_time_change": 0.02,
    })  # fmt: skip
    told: Any = SimpleNamespace(ratios={"speed.first_two_share_650": 0.875,
                                        "stiffness.first_rebound_time_change": -0.04})  # fmt: skip
    one, two = ratios.ratios(STUDIES, told)
    assert one.record() == {
        "name": "speed.first_two_share_650", "published": 0.875, "ours": 0.91,
        "relative_deviation": pytest.approx(0.04),
    }  # fmt: skip
    assert (two.ours, two.relative_deviation) == pytest.approx((-0.05, 0.25))
    items = [Ratio("x", 1.0, ours) for ours in (1.039, 0.961, 1.05, 0.89)]
    assert ratios.agreement(items) == {"of": 4, "within_4_percent": 2, "within_10_percent": 3}
    with pytest.raises(InputError, match="no study gives a, b; known: speed") as caught:
        ratios.ratios(STUDIES, SimpleNamespace(ratios={"b": 1.0, "a": 1.0}))  # type: ignore[arg-type]
    assert caught.value.evidence == {"unknown": ["a", "b"]}


def made_up_counts() -> Counts:
    thresholds = np.logspace(-5.0, 1.0, 601)
    numbers = np.arange(601)[:, None] + np.array([[0, 1000]])
    increase = np.where(np.arange(601) < 550, 0.001 * np.arange(601), np.nan)
    return Counts(
        thresholds=thresholds, restitution=numbers, stiffness=numbers + 1, speed=numbers + 2,
        matches={"one": ((0.1, 0.2),), "two": ((0.3, 0.6), (0.7, 0.9))},
        time_increase=increase, largest_increase=2.5,
    )  # fmt: skip


def test_record_of_counts() -> None:
    """At nine thresholds, two a decade from 1e-4 to 1: places 100 to 500 by steps of 50."""
    places = list(range(100, 501, 50))
    record = made_up_counts().record()
    assert record["threshold_rad_s"] == pytest.approx([10.0 ** (-5 + p / 100) for p in places])
    assert record["by_restitution"] == [[p, p + 1000] for p in places]
    assert record["by_stiffness"] == [[p + 1, p + 1001] for p in places]
    assert record["by_speed"] == [[p + 2, p + 1002] for p in places]
    assert (record["one"], record["two"]) == ([[0.1, 0.2]], [[0.3, 0.6], [0.7, 0.9]])
    assert record["transition_time_increase"] == pytest.approx([0.001 * p for p in places])
    assert record["largest_increase_of_collisions"] == 2.5
    assert len(record) == 8
    short = Counts(**{**made_up_counts().__dict__, "time_increase": np.full(601, np.nan)})
    assert short.record()["transition_time_increase"] == [None] * 9


def test_counts_of_studies() -> None:
    """Two rates a case: 9 and 1 of the first, 10 and 2 of the last; times 0, 5, 7 and 0, 6, 9."""
    given: Any = SimpleNamespace(count_increase=0.5)
    found = counts.collision_counts(STUDIES, given)
    assert found.thresholds[[0, -1]] == pytest.approx([1e-5, 10.0])
    assert len(found.thresholds) == 601
    for place, threshold in ((0, 1e-5), (520, 10.0**0.2), (599, 10.0**0.99), (560, 10.0**0.6)):
        few, many = (1 + (threshold <= 9.0) + (threshold <= 1.0),
                     1 + (threshold <= 10.0) + (threshold <= 2.0))  # fmt: skip
        assert found.restitution[place].tolist() == [few, many]
        last = ((0.0, 5.0, 7.0)[few - 1], (0.0, 6.0, 9.0)[many - 1])
        if last[0]:
            assert found.time_increase[place] == pytest.approx(last[1] / last[0] - 1.0)
        else:
            assert np.isnan(found.time_increase[place])
    # Three and three below 1, two and three to 2, two and two to 9, one and two to 10.
    assert found.matches == {
        "collisions_grow_as_published": ((1.0, 2.0),), "rebounds_grow_as_published": (),
        "collisions_grow_to_the_published_multiple": (),
        "unchanged_by_stiffness": ((1e-5, 1.0), (2.0, 9.0)),
        "rebounds_as_published_and_unchanged_by_stiffness": (),
    }  # fmt: skip
    assert found.largest_increase == 1.0
    twice = counts.collision_counts(STUDIES, SimpleNamespace(count_increase=2.0))  # type: ignore[arg-type]
    assert twice.matches["collisions_grow_to_the_published_multiple"] == ((9.0, 10.0),)
    assert twice.matches["rebounds_grow_as_published"] == ()
    both = counts.collision_counts(STUDIES, SimpleNamespace(count_increase=1.0))  # type: ignore[arg-type]
    assert both.matches["rebounds_grow_as_published"] == ((1.0, 2.0),)
    none = counts.collision_counts(STUDIES, SimpleNamespace(count_increase=None))  # type: ignore[arg-type]
    assert [key for key, where in none.matches.items() if where] == ["unchanged_by_stiffness"]


def test_records_of_the_other_parts() -> None:
    effect = DriveEffect(0.1, 450.0, 1.0, 2.0, 3.0, 4.0, 5.0)
    found = DriveComparison({"a": 2.0}, (effect,), (Ratio("x", 2.0, 3.0),)).record()
    assert found == {
        "reflected_inertias_kg_m2": {"a": 2.0}, "effects": [asdict(effect)],
        "ratios": [{"name": "x", "published": 2.0, "ours": 3.0, "relative_deviation": 0.5}],
    }  # fmt: skip
    rule = Rule("forward", np.array([2.0, 1.0]), np.eye(2), 1.5, np.array([3.0, 4.0]))
    assert FixedStep(450.0, 7, 8, 9e-9, (rule,)).record() == {
        "speed_rpm": 450.0, "steps_taken": 7, "our_evaluations": 8, "our_error_s": 9e-9,
        "quantities": ["rebound_time_s_1", "rebound_time_s_2", "rebound_amplitude_1",
                       "duration_s"],
        "rules": [{"name": "forward", "steps_s": [2.0, 1.0], "order": 1.5,
                   "relative_errors": [[1.0, 0.0], [0.0, 1.0]],
                   "extrapolated_errors": [3.0, 4.0]}],
    }  # fmt: skip
    share = Shares(np.array([1.0, 2.0]), np.array([0.1, 0.25, 0.26]),
                   np.array([[0.9, 0.5, 0.0], [np.nan, 0.7, 0.0]]),
                   np.array([0.99, 0.9, 1.0]), {"x": 2.0})  # fmt: skip
    assert share.record() == {
        "largest_difference_up_to_0.25": pytest.approx(0.4),
        "ratios_of_a_constant_force": {"x": 2.0},
    }  # fmt: skip
    times = np.arange(2.0 * 61 * 61).reshape(2, 61, 61)
    times[0, 10, 20] = np.nan
    grid = DurationMap(np.array([7e3, 9e3]), 10.0 * np.arange(61.0), times)
    record = grid.record()
    assert record["speed_rpm"] == [0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0]
    assert record["restitution"] == pytest.approx([0.02, 0.07, 0.12, 0.17, 0.22, 0.27, 0.32])
    assert (record["stiffness"], len(record)) == ([7e3, 9e3], 4)
    assert record["duration_s"][0][1][2] is None
    assert record["duration_s"][1][3][4] == times[1, 30, 40]
    assert grid.index_units[1, 3, 4] == pytest.approx(times[1, 3, 4] * 40.0 / 60.0 * 40.0)
    assert len(MAP_RESTITUTIONS) == 61


def test_orders_of_fixed_steps() -> None:
    """Errors that go with the step, or its square: slopes of the last column's logarithms."""
    steps = np.array([4e-6, 2e-6, 1e-6])
    exact = np.array([2.0, 5.0])
    off = np.stack([0.1 * steps, -3.0 * steps**2], axis=1)
    found = _rule("forward", steps, exact * (1.0 + off), exact)
    assert (found.name, found.order) == ("forward", pytest.approx(2.0, abs=1e-3))
    assert found.relative_errors == pytest.approx(off, rel=1e-3)
    # Two steps extrapolate what goes with the step to zero, and a square to half with its sign.
    assert found.extrapolated_errors[0] == pytest.approx(0.0, abs=1e-15)
    assert found.extrapolated_errors[1] == pytest.approx(-3.0 * (2.0 * 1e-12 - 4e-12), rel=1e-2)


def test_phase_one_of_a_straight_line() -> None:
    """F = p B + W + omega^2 J: the first place to let go, and none without a pull."""
    release = Release(650.0, 28.0, 4e-6, 1e-3)
    made = PhaseOne(
        stop="steeve", preload=0.01, preloads=np.array([0.01, 0.02]),
        speeds_rpm=np.array([300.0, 600.0]), index=np.array([1.0, 2.0, 3.0]),
        per_preload=np.array([1e3, 2e3, 1e3]), weight=np.array([1.0, -1.0, 5.0]),
        per_speed2=np.array([-0.01, -0.02, 0.5]), releases=(release,),
    )  # fmt: skip
    omega = 2.0 * math.pi * 300.0 / 60.0
    assert made.force(0.02, 300.0) == pytest.approx(
        [21.0 - 0.01 * omega**2, 39.0 - 0.02 * omega**2, 25.0 + 0.5 * omega**2]
    )
    # (10 + 1) / 0.01 and (20 - 1) / 0.02: the second is the lower one.
    limit = math.sqrt(950.0) * 60.0 / (2.0 * math.pi)
    assert made.threshold_rpm(0.01) == pytest.approx(limit)
    assert made.threshold_rpm(-1.0) == 0.0
    assert made.smallest_forces() == pytest.approx(np.array(
        [[min(made.force(p, n)) for n in (300.0, 600.0)] for p in (0.01, 0.02)]
    ))  # fmt: skip
    other = math.sqrt(1950.0) * 60.0 / (2.0 * math.pi)
    assert made.record() == {
        "stop": "steeve", "preload": 0.01, "threshold_rpm": pytest.approx(limit),
        "thresholds": [{"preload": 0.01, "speed_rpm": pytest.approx(limit)},
                       {"preload": 0.02, "speed_rpm": pytest.approx(other)}],
        "turns": [asdict(release)],
    }  # fmt: skip
