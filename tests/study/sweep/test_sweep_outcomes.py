"""What a sweep says of its rows: reasons, engines, faults of the program, and its exit status."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sweep_studies import TABLE, plan, stored, study

from nipper_pin import SimulationError
from nipper_pin.cli import main
from nipper_pin.study.sweep import chunks, read_sweep, run_sweep
from nipper_pin.study.sweep.chunks import DefectError, run_chunk
from nipper_pin.study.sweep.results.chunk_file import read

RADII = '[parameters."drives.pendulum.crank_radius_mm"]\nvalues = [{}]\n'


def test_a_sweep_without_any_result_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 1, and the reason of three of its four rows; they stay, and say so again."""
    text = RADII.format("-5.0, -6.0, -7.0, 10000.0")
    out = stored(tmp_path / "out", plan(tmp_path, text))
    for _ in range(2):
        assert main(["sweep", study(tmp_path, text), "--out", str(out), "--workers", "1"]) == 1
        said = capsys.readouterr().err
        assert "none of 4 scenarios has a result, 3 of them because: " in said
        assert "crank_radius_mm = -5" in said
        assert said.count("\n") == 1
    assert read_sweep(out).stored == 4


@pytest.mark.parametrize(("most", "told"), [(3, True), (300, False)])
def test_runs_of_too_many_collisions_are_told(tmp_path: Path, most: int, told: bool) -> None:
    """Of two speeds; the empty values of their rows are not left to be found."""
    speeds = "[parameters.speed_rpm]\nvalues = [450.0, 650.0]\n"
    found = plan(tmp_path, f"[case]\nmax_collisions = {most}\n{speeds}")
    report = run_sweep(found, stored(tmp_path / "out", found))
    said = any("2 ended at their largest number of collisions" in x for x in report.sentences())
    assert said is told
    durations = read_sweep(tmp_path / "out").table["duration_s"].to_numpy()
    assert np.isnan(durations).all() == told


@pytest.mark.slow
def test_rows_that_the_reduced_engine_leaves_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Some rebounds this high leave the range that the tables cover."""
    text = TABLE.replace("high = 0.25", "high = 0.7").replace("count = 600", "count = 64")
    arguments = ["sweep", study(tmp_path, text), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main(arguments) == 0
    said = capsys.readouterr().out
    rows = read_sweep(tmp_path / "out").table.to_pylist()
    left = [row["message"] for row in rows if row["engine"] == "direct"]
    assert 0 < len(left) < 64
    for reason in set(left):
        assert reason.startswith("the reduced engine: ")
        assert f"{left.count(reason)} by the direct engine: {reason}" in said


# --- faults of the program ---------------------------------------------------------------------


def faulty(monkeypatch: pytest.MonkeyPatch, error: Exception, speed: float) -> None:
    """Transitions that raise an error wherever this speed is among them."""
    right = chunks.table_of

    def table(mechanism: Any, cases: Any, **settings: Any) -> Any:
        if speed in cases.speed_rpm:
            raise error
        return right(mechanism, cases, **settings)

    monkeypatch.setattr(chunks, "table_of", table)


SPEEDS = """
chunk = 1
[parameters.speed_rpm]
values = [450.0, 550.0, 650.0]
"""


def test_a_fault_of_the_program_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No row says that it is an outcome; the error names the scenario and where it happened."""
    found = plan(tmp_path, SPEEDS)
    text = found.job.text()
    for error in (ValueError("a shape"), ZeroDivisionError("division"), KeyError("name")):
        with monkeypatch.context() as broken:
            faulty(broken, error, 550.0)
            parts = list(found.rows(found.chunks()))
            for chunk, rows in (parts[0], parts[2]):
                assert read(run_chunk(text, chunk.start, rows)).num_rows == 1
            with pytest.raises(DefectError) as caught:
                run_chunk(text, parts[1][0].start, parts[1][1])
        said = caught.value.message
        assert said.startswith(
            f"scenario 1: a fault of the program, please report it: {type(error).__name__}"
        )
        assert "test_sweep_outcomes.py, line" in said


def test_an_error_of_the_package_is_an_outcome(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = plan(tmp_path, SPEEDS)
    faulty(monkeypatch, SimulationError("a dead centre"), 550.0)
    rows = read_sweep(stored(tmp_path / "out", found)).table.to_pylist()
    assert [row["outcome"] for row in rows] == ["at_rest", "failed", "at_rest"]
    assert rows[1]["message"] == "a dead centre"


def test_rows_say_whether_the_premise_holds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first machine leaves its stop before the touch: its row is that of the whole turn."""
    text = """
    quantities = ["rebound_amplitude_1", "approach_rate_1"]
    [case]
    speed_rpm = 681.27
    [set]
    restitution = 0.18674
    stiffness = 7065.98
    [parameters.preload]
    values = [9.25486, 13.0]
    """
    out = stored(tmp_path / "out", plan(tmp_path, text))
    assert main(["sweep", study(tmp_path, text), "--out", str(out), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["premise_holds"] == {"false": 1, "true": 1}
    rows = read_sweep(out).table.to_pylist()
    assert [(row["premise_holds"], row["engine"]) for row in rows] == [
        (False, "turn"), (True, "direct"),
    ]  # fmt: skip
    assert rows[0]["rebound_amplitude_1"] == pytest.approx(12.61e-3, rel=1e-3)


def test_the_summary_counts_what_is_on_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Scenarios, mechanisms and chunks from the files alone."""
    text = RADII.format("63.0, 64.0, 65.0") + SPEEDS.replace("chunk = 1", "")
    path, out = study(tmp_path, "chunk = 3\n" + text), tmp_path / "out"
    stored(out, plan(tmp_path, "chunk = 3\n" + text))
    (out / "chunks" / "0000001.parquet").unlink()
    monkeypatch.setenv("COLUMNS", "1000")
    assert main(["sweep", path, "--out", str(out), "--workers", "1"]) == 0
    rows = read_sweep(out).table.to_pylist()
    machines = {row["drives.pendulum.crank_radius_mm"] for row in rows}
    assert capsys.readouterr().out.startswith(
        f"{len(rows)} scenarios of {len(machines)} mechanisms in {out}: 6 were there, "
        f"{len(rows) - 6} computed in "
    )
