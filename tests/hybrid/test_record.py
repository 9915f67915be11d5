"""The JSON document that scripts of others rely on; test_judged.py judges its tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from nipper_pin import Case, Solution, Window, load, record, simulate

FOUR_BAR = Path(__file__).parents[1] / "verification" / "models" / "four_bar"


def document_of(solution: Solution) -> Any:
    """The document, as someone who reads the file gets it."""
    return json.loads(json.dumps(record(solution), allow_nan=False))


@pytest.mark.parametrize("window", Window)
def test_what_was_simulated_with_what_work(window: Window) -> None:
    """Model, speed, window, the values behind the command line's shortcuts, residuals, work."""
    overrides = {"stops.jaw.restitution": 0.3, "springs.steeve.stiffness_N_per_m": 10_000.0}
    solution = simulate(load("e62", overrides), Case(speed_rpm=650.0, window=window))
    document = document_of(solution)
    # The keys carry their unit, so they are the last steps of the shortcuts' paths.
    wanted = {
        "model": "e62", "speed_rpm": 650.0, "window": window.value, "drive": "held",
        "rest_rate": None, "restitution": 0.3, "stiffness_N_per_m": 10_000.0,
        "preload_length_mm": 11.0,
    }  # fmt: skip
    assert document["case"].items() >= wanted.items()
    assert set(solution.mechanism.shortcuts) == {"restitution", "stiffness", "preload"}
    checks, work = document["checks"], document["work"]
    assert 0.0 <= checks["closure_m"] <= 1e-12
    assert checks.keys() >= {"closure_rate_m_s"}
    assert 0.0 <= checks["energy_balance"] <= 1e-9
    assert work["evaluations"] == solution.evaluations > 0
    assert work["wall_s"] > 0.0


def test_an_unfinished_run_has_nulls_and_no_nan() -> None:
    """Where the window ends early the missing values are null, and JSON without NaN still works."""
    document = document_of(simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=2)))
    assert document["collisions"][-1]["rebound_time_s"] is None
    assert document["collisions"][-1]["rebound_amplitude"] is None
    assert document["transition"]["duration_s"] is None
    assert document["transition"]["first_two_share"] is None
    assert document["transition"]["collisions"] == len(document["collisions"])


def test_a_run_without_collisions_counts_from_its_start() -> None:
    """A four-bar has no stops: no collisions, no transition, one phase from zero to the end."""
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    document = document_of(simulate(load(FOUR_BAR), case))
    assert document["collisions"] == []
    assert len(document["phases"]) == 1
    assert document["phases"][0]["start_s"] == 0.0
    assert document["phases"][0]["end_s"] == pytest.approx(1.0, rel=1e-15)
    assert document["transition"]["duration_s"] is None
