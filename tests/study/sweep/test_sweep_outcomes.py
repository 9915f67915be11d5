"""What a sweep says of its rows: reasons, engines, faults of the program, and its exit status."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sweep_studies import TABLE, plan, study

from nipper_pin import SimulationError
from nipper_pin.cli import main
from nipper_pin.study.sweep import chunks, read_sweep, run, run_sweep
from nipper_pin.study.sweep.chunks import DefectError, run_chunk
from nipper_pin.study.sweep.plan import Chunk

RADII = '[parameters."drives.pendulum.crank_radius_mm"]\nvalues = [{}]\n'


def test_a_sweep_without_any_result_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 1, and the reason of three of its four rows; they stay, and say so again."""
    arguments = ["sweep", study(tmp_path, RADII.format("-5.0, -6.0, -7.0, 10000.0")),
                 "--out", str(tmp_path / "out"), "--workers", "1"]  # fmt: skip
    for _ in range(2):
        assert main(arguments) == 1
        said = capsys.readouterr().err
        assert "none of 4 scenarios has a result, 3 of them because: " in said
        assert "crank_radius_mm = -5" in said
        assert said.count("\n") == 1
    assert read_sweep(tmp_path / "out").stored == 4


def test_rows_without_a_result_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The summary and its JSON say what a count of the rows themselves says."""
    arguments = ["sweep", study(tmp_path, RADII.format("63.0, -6.0, 64.0, 10000.0, -7.0")),
                 "--out", str(tmp_path / "out")]  # fmt: skip
    assert main(arguments) == 0
    said = capsys.readouterr().out
    assert "3 without a result, 2 because: " in said
    assert "2 by the direct engine: the reduced engine pays from 32 cases on" in said
    assert main([*arguments, "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    rows = read_sweep(tmp_path / "out").table.to_pylist()
    for name, counts in (("outcome", document["outcomes"]), ("engine", document["engines"])):
        values = [row[name] for row in rows]
        assert counts == {value: values.count(value) for value in set(values)}
    assert document["without_result"] == sum(np.isnan(row["duration_s"]) for row in rows) == 3


def test_runs_of_too_many_collisions_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of two speeds; the empty values of their rows are not left to be found."""
    speeds = "[case]\nmax_collisions = {}\n[parameters.speed_rpm]\nvalues = [450.0, 650.0]\n"
    for most, told in ((3, True), (300, False)):
        file = study(tmp_path, speeds.format(most))
        assert main(["sweep", file, "--out", str(tmp_path / str(most)), "--workers", "1"]) == 0
        said = capsys.readouterr().out
        assert ("2 ended at their largest number of collisions" in said) == told
        durations = [
            row["duration_s"] for row in read_sweep(tmp_path / str(most)).table.to_pylist()
        ]
        assert all(np.isnan(durations)) == told


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


def in_this_process(
    text: bytes, tasks: Iterable[tuple[Chunk, Any]], _workers: int
) -> Iterator[tuple[Chunk, bytes | DefectError]]:
    for chunk, rows in tasks:
        try:
            yield chunk, run_chunk(text, chunk.start, rows)
        except DefectError as defect:
            yield chunk, defect


SPEEDS = """
chunk = 1
[parameters.speed_rpm]
values = [450.0, 550.0, 650.0]
"""


@pytest.mark.parametrize(
    "error", [ValueError("a shape"), ZeroDivisionError("division"), KeyError("name")]
)
def test_a_fault_of_the_program_is_shown(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: Exception,
) -> None:
    """No row says that it is an outcome; others are kept, and come first when it is mended."""
    path, out = study(tmp_path, SPEEDS), tmp_path / "out"
    monkeypatch.setattr("nipper_pin.study.sweep.run.on_this_machine", in_this_process)
    with monkeypatch.context() as broken:
        faulty(broken, error, 550.0)
        assert main(["sweep", path, "--out", str(out)]) == 1
    said = capsys.readouterr().err
    assert f"scenario 1: a fault of the program, please report it: {type(error).__name__}" in said
    assert "test_sweep_outcomes.py, line" in said
    assert "1 of 3 chunks are not stored" in said
    assert said.count("\n") == 1
    assert read_sweep(out).table["scenario"].to_pylist() == [0, 2]
    assert main(["sweep", path, "--out", str(out)]) == 0
    assert "2 were there, 1 computed" in " ".join(capsys.readouterr().out.split())


def test_an_error_of_the_package_is_an_outcome(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = plan(tmp_path, SPEEDS)
    monkeypatch.setattr("nipper_pin.study.sweep.run.on_this_machine", in_this_process)
    faulty(monkeypatch, SimulationError("a dead centre"), 550.0)
    run_sweep(found, tmp_path / "out")
    rows = read_sweep(tmp_path / "out").table.to_pylist()
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
    out = tmp_path / "out"
    assert main(["sweep", study(tmp_path, text), "--out", str(out), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["premise_holds"] == {"false": 1, "true": 1}
    rows = read_sweep(out).table.to_pylist()
    assert [(row["premise_holds"], row["engine"]) for row in rows] == [
        (False, "turn"), (True, "direct"),
    ]  # fmt: skip
    assert rows[0]["rebound_amplitude_1"] == pytest.approx(12.61e-3, rel=1e-3)
    assert main(["sweep", study(tmp_path, text), "--out", str(out)]) == 0
    assert "1 do not arrive in the initial phase (premise_holds is false); 1 of them" in (
        capsys.readouterr().out
    )


def test_the_summary_counts_what_is_on_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Scenarios, mechanisms and chunks from the files alone; the time from a clock of 2.5 s."""
    text = RADII.format("63.0, 64.0, 65.0") + SPEEDS.replace("chunk = 1", "")
    path, out = study(tmp_path, "chunk = 3\n" + text), tmp_path / "out"
    ticks = iter([10.0, 12.5])
    monkeypatch.setattr("nipper_pin.study.sweep.run.on_this_machine", in_this_process)
    run_sweep(plan(tmp_path, "chunk = 3\n" + text), out, chunks=(1, 1))
    monkeypatch.setattr(run, "time", SimpleNamespace(perf_counter=lambda: next(ticks)))
    monkeypatch.setenv("COLUMNS", "1000")
    assert main(["sweep", path, "--out", str(out), "--workers", "1"]) == 0
    rows = read_sweep(out).table.to_pylist()
    machines = {row["drives.pendulum.crank_radius_mm"] for row in rows}
    assert capsys.readouterr().out.splitlines()[0] == (
        f"{len(rows)} scenarios of {len(machines)} mechanisms in {out}: 3 were there, "
        f"{len(rows) - 3} computed in 2.5 s"
    )
