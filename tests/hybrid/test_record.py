"""The JSON document that other people's scripts rely on, key by key."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import pytest

from nipper_pin import Case, Solution, Window, load, record, simulate

FOUR_BAR = Path(__file__).parents[1] / "verification" / "models" / "four_bar"
COLLISION_KEYS = {
    "number",
    "stop",
    "time_s",
    "cylinder_angle_rad",
    "approach_rate",
    "separation_rate",
    "impulse_N_s",
    "energy_lost_J",
    "rebound_amplitude",
    "rebound_time_s",
}


@pytest.fixture(scope="module", params=list(Window))
def solution(request: pytest.FixtureRequest) -> Solution:
    """Both windows at 650 r/min with changed restitution and stiffness."""
    overrides = {"stops.jaw.restitution": 0.3, "springs.steeve.stiffness_N_per_m": 10_000.0}
    return simulate(load("e62", overrides), Case(speed_rpm=650.0, window=request.param))


@pytest.fixture(scope="module")
def document(solution: Solution) -> dict[str, Any]:
    """The document, as someone who reads the file gets it."""
    return json.loads(json.dumps(record(solution), allow_nan=False))


def test_top_level_keys(document: dict[str, Any]) -> None:
    """All parts of the contract are there."""
    assert {"case", "collisions", "phases", "transition", "checks", "work"} <= document.keys()


def test_case_says_what_was_simulated(document: dict[str, Any], solution: Solution) -> None:
    """Model, speed, window, and the values behind the command line's shortcuts."""
    case = document["case"]
    assert case["model"] == "e62"
    assert case["speed_rpm"] == 650.0
    assert case["window"] == solution.case.window.value
    assert case["drive"] == "held"
    assert case["rest_rate"] is None
    # The keys carry their unit, so they are the last steps of the shortcuts' paths.
    assert set(solution.mechanism.shortcuts) == {"restitution", "stiffness", "preload"}
    assert case["restitution"] == 0.3
    assert case["stiffness_N_per_m"] == 10_000.0
    assert case["preload_length_mm"] == 11.0


def test_collisions_hold_the_contract(document: dict[str, Any], solution: Solution) -> None:
    """Every collision has all keys, its numbers are those of the table, signs as stated."""
    assert len(document["collisions"]) == len(solution.collisions) >= 7
    first = solution.collisions[0]
    for number, (row, item) in enumerate(
        zip(document["collisions"], solution.collisions, strict=True), start=1
    ):
        assert row.keys() >= COLLISION_KEYS
        assert row["number"] == number
        assert row["stop"] in {"jaw", "steeve"}
        assert row["time_s"] == item.t - first.t
        assert row["cylinder_angle_rad"] == item.cylinder_angle
        assert row["approach_rate"] == item.approach_rate < 0.0
        assert row["separation_rate"] == item.separation_rate > 0.0
        assert row["impulse_N_s"] == item.impulse > 0.0
        assert row["energy_lost_J"] == item.energy_lost > 0.0
        assert row["rebound_amplitude"] == item.rebound_amplitude
        assert row["rebound_time_s"] == item.rebound_time
    assert document["collisions"][0]["time_s"] == 0.0


def test_impulse_is_the_one_at_the_lips(document: dict[str, Any], solution: Solution) -> None:
    """Impulse times lever is the impulse about the jaw's joint; the lever is 89.5 mm, not 1 m."""
    lever = solution.mechanism.stop("jaw").lever
    assert 0.05 < lever < 0.15
    jaw = [item for item in solution.collisions if item.stop == "jaw"]
    rows = [row for row in document["collisions"] if row["stop"] == "jaw"]
    for row, item in zip(rows, jaw, strict=True):
        assert row["impulse_N_s"] * lever == pytest.approx(item.event.P_N["jaw"], rel=1e-15)


def test_phases_follow_each_other(document: dict[str, Any], solution: Solution) -> None:
    """Phases have number, start and end, count from the first collision and leave no gap."""
    phases = document["phases"]
    assert phases
    for row in phases:
        assert {"phase", "start_s", "end_s"} <= row.keys()
        assert row["phase"] in {1, 2, 3}
        assert row["end_s"] > row["start_s"]
    for before, after in itertools.pairwise(phases):
        assert before["end_s"] == after["start_s"]
        assert before["phase"] != after["phase"]
    origin = solution.collisions[0].t
    assert phases[0]["start_s"] == -origin
    if solution.case.window is Window.CYCLE:
        whole = phases[-1]["end_s"] - phases[0]["start_s"]
        assert whole == pytest.approx(60.0 / 650.0, rel=1e-14)


def test_transition_is_the_series_of_the_jaw(document: dict[str, Any]) -> None:
    """Duration, collisions and the share of the first two rebounds."""
    transition = document["transition"]
    jaw = [row for row in document["collisions"] if row["stop"] == "jaw"]
    assert transition["collisions"] == len(jaw)
    duration = transition["duration_s"]
    assert duration > jaw[-1]["time_s"] - jaw[0]["time_s"] > 0.0
    share = (jaw[0]["rebound_time_s"] + jaw[1]["rebound_time_s"]) / duration
    assert transition["first_two_share"] == pytest.approx(share, rel=1e-12)


def test_checks_and_work(document: dict[str, Any], solution: Solution) -> None:
    """Residuals and the work done are plain numbers."""
    checks = document["checks"]
    assert checks.keys() >= {"closure_m", "closure_rate_m_s", "energy_balance"}
    assert 0.0 <= checks["closure_m"] <= 1e-12
    assert 0.0 <= checks["energy_balance"] <= 1e-9
    assert document["work"]["evaluations"] == solution.evaluations > 0
    assert document["work"]["wall_s"] > 0.0


def test_an_unfinished_run_has_nulls_and_no_nan() -> None:
    """Where the window ends early the missing values are null, and JSON without NaN still works."""
    solution = simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=2))
    document = json.loads(json.dumps(record(solution), allow_nan=False))
    assert document["collisions"][-1]["rebound_time_s"] is None
    assert document["collisions"][-1]["rebound_amplitude"] is None
    assert document["transition"]["duration_s"] is None
    assert document["transition"]["first_two_share"] is None
    assert document["transition"]["collisions"] == len(document["collisions"])


def test_a_run_without_collisions_counts_from_its_start() -> None:
    """A four-bar has no stops: no collisions, no transition, one phase from zero to the end."""
    solution = simulate(load(FOUR_BAR), Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    document = json.loads(json.dumps(record(solution), allow_nan=False))
    assert document["collisions"] == []
    assert len(document["phases"]) == 1
    assert document["phases"][0]["start_s"] == 0.0
    assert document["phases"][0]["end_s"] == pytest.approx(1.0, rel=1e-15)
    assert document["transition"]["duration_s"] is None
