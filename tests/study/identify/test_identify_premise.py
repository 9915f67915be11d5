"""Measurements of a machine that does not arrive as a transition assumes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nipper_pin import Case, Window, load, simulate
from nipper_pin.cli import main

PRELOAD = "springs.steeve.preload_length_mm"
MACHINE = {
    PRELOAD: 9.25486,
    "springs.steeve.stiffness_N_per_m": 7065.98,
    "stops.jaw.restitution": 0.18674,
}
SPEED = 681.27


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    """Its first rebound in whole turns, from the usual start of a turn: 12.6 and not 7.1 mrad."""
    turn = simulate(load("e62", MACHINE), Case(speed_rpm=SPEED, window=Window.CYCLE))
    first = next(hit for hit in turn.collisions if hit.stop == "jaw")
    assumed = simulate(load("e62", MACHINE), Case(speed_rpm=SPEED)).collisions[0]
    assert first.rebound_amplitude is not None
    assert assumed.rebound_amplitude is not None
    assert first.rebound_amplitude > 1.5 * assumed.rebound_amplitude
    lines = ["speed_rpm,restitution,stiffness_N_per_m,quantity,value,sigma"]
    for quantity, value in (
        ("rebound_amplitude_1", first.rebound_amplitude),
        ("rebound_time_s_1", first.rebound_time),
    ):
        assert value is not None
        setting = f"{SPEED},{MACHINE['stops.jaw.restitution']},7065.98"
        lines.append(f"{setting},{quantity},{value!r},{0.01 * value!r}")
    (tmp_path / "camera.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    file = tmp_path / "problem.toml"
    file.write_text(
        'format = 1\ntitle = "fast"\nmodel = "e62"\nmeasured = "camera.csv"\n'
        f'[parameters."{PRELOAD}"]\nlow = 8.9\nhigh = 11.1\n',
        encoding="utf-8",
    )
    return file


@pytest.mark.slow
def test_the_true_transition_is_fitted(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The number comes back, and the answer says whose transition it was.

    Without noise the search ends where its step is below 1e-6 of the range of 2 mm. The assumed
    transition, of another approach rate, would need another preload for these values.
    """
    arguments = ["identify", str(problem), "--starts", "1", "--profiles", "0", "--workers", "1"]
    status = main([*arguments, "--json", str(tmp_path / "found.json")])
    report = " ".join(capsys.readouterr().out.split())
    document = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert status == 0
    assert document["parameters"][0]["identified"] == pytest.approx(MACHINE[PRELOAD], abs=1e-4)
    assert [item["premise_holds"] for item in document["targets"]] == [False, False]
    assert "681.27 r/min, restitution 0.18674, stiffness 7065.98: the transition of the " in report
    assert "steeve" in report
