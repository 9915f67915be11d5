"""Saved runs and cases beside other options: each changes the run, or is refused in a sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from programs import main

from nipper_pin import Case, load, save_case

BASE = {"--speed": "650", "--set": "preload=10.5", "--restitution": "0.2"}
# The last 3 are about whole turns; the cases of all others are transitions.
BESIDE = [
    ["--set", "springs.steeve.preload_length_mm=9.25"],
    ["--set", "preload=9.25"],
    ["--restitution", "0.1"],
    ["--stiffness", "11000"],
    ["--speed", "500"],
    ["--drive", "inertial"],
    ["--rest-rate", "0.1"],
    ["--tolerance", "1e-9"],
    ["--window", "cycle"],
    ["--cycles", "2"],
    ["--start-index", "20"],
    ["--no-reuse"],
]


def document(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["simulate", *arguments, "--json", "-"]) == 0, capsys.readouterr().err
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    del found["work"]["wall_s"]
    return found


def words(options: dict[str, str]) -> list[str]:
    return [word for pair in options.items() for word in pair]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A case of each window."""
    home = tmp_path_factory.mktemp("cases")
    e62 = load("e62", {"preload": 10.5, "restitution": 0.2})
    return {
        window: str(save_case(e62, Case(speed_rpm=650.0, window=window), home / f"{window}.json"))
        for window in ("transition", "cycle")
    }


@pytest.mark.parametrize("option", BESIDE, ids=" ".join)
def test_an_option_beside_a_case_changes_its_run(
    option: list[str], saved: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """What comes out is what the same options give without the file, and not the saved run."""
    window = "cycle" if BESIDE.index(option) >= len(BESIDE) - 3 else "transition"
    others = {"--window": window, **BASE}
    others.pop(option[0], None)
    case = saved[window]
    beside = document(["--case", case, *option], capsys)
    assert beside == document([*words(others), *option], capsys)
    assert beside != document(["--case", case], capsys)


def test_a_case_can_be_taken_back_to_the_limit_and_to_copies(
    tmp_path: Path, e62: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a case holds can be unset, too."""
    file = save_case(
        e62,
        Case(speed_rpm=450.0, window="cycle", cycles=2, rest_rate=0.5, reuse_cycles=False),
        tmp_path / "case.json",
    )
    back = document(["--case", str(file), "--rest-rate", "limit", "--reuse"], capsys)
    assert back == document(["--window", "cycle", "--cycles", "2"], capsys)
