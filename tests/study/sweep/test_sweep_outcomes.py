"""What a sweep says of its rows: reasons, engines, extremes, faults, its time and its status."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from msgspec.structs import replace
from programs import study_text
from snapshots import Words
from sweep_studies import GEOMETRY, TABLE, plan, stored, study

from nipper_pin import InputError, SimulationError, read_sweep
from nipper_pin.cli import main
from nipper_pin.study.sweep import chunks, sweep
from nipper_pin.study.sweep.estimate import Estimate, estimate
from nipper_pin.study.sweep.results.extremes import Extremes

GRID = study_text("sweep_of_a_grid.toml")
RADII = '[parameters."drives.pendulum.crank_radius_mm"]\nvalues = [{}]\n'


# --- rows ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def grid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grid")
    return stored(folder / "out", plan(folder, GRID))


@pytest.mark.parametrize(("most", "step"), [(None, 1), (36, 1), (35, 5), (9, 5), (4, 11), (1, 37)])
def test_rows_that_are_read(grid: Path, most: int | None, step: int) -> None:
    """Every k-th of all, where k has no factor in common with the sizes of the grids, 3 and 4."""
    sweep = read_sweep(grid, most)
    assert sweep.table["scenario"].to_pylist() == [*range(0, 36, step)]
    assert (sweep.scenarios, sweep.stored, sweep.title) == (36, 36, "test")
    assert sweep.quantities == ("duration_s", "rebound_amplitude_2")
    assert [axis["name"] for axis in sweep.axes] == ["speed_rpm", "preload", "restitution"]
    page, shown = sweep._repr_html_(), min(len(sweep.table), 12)
    assert "36 of 36 stored" in page
    assert (f"and {len(sweep.table) - shown} more" in page) is (len(sweep.table) > shown)
    assert page.count("<tr>") == 2 + 1 + shown


def test_a_folder_without_rows(tmp_path: Path, grid: Path) -> None:
    (tmp_path / "chunks").mkdir()
    (tmp_path / "plan.json").write_bytes((grid / "plan.json").read_bytes())
    with pytest.raises(InputError, match="nothing is computed yet"):
        read_sweep(tmp_path)


# --- what is said of them ------------------------------------------------------------------------


def test_what_a_report_says(tmp_path: Path, words: Words) -> None:
    """Why the direct engine served, of which turns rows are, and what has no result and why.

    Reasons that differ in their numbers alone count as one. Nothing is left to compute. A radius
    below zero and one beyond the guide are marked, and do not cost the rows beside them.
    """
    text = RADII.format("63.0, -6.0, 10000.0, -7.0")
    found = plan(tmp_path, text + "[parameters.speed_rpm]\nvalues = [450.0, 1200.0]\n")
    report = sweep(found, stored(tmp_path / "out", found))
    assert (report.scenarios, report.found, report.computed, report.workers) == (8, 8, 0, 0)
    words("\n".join(report.sentences()) + "\n")
    rows = read_sweep(tmp_path / "out").table.to_pylist()
    assert {row["engine"] for row in rows if not row["message"]} == {"direct"}
    assert [row["outcome"] for row in rows] == ["at_rest"] * 2 + ["no_model"] * 6
    for row in rows[2:]:
        assert "crank_radius_mm" in row["message"]
        assert (row["engine"], row["collisions"]) == ("none", 0)
        assert np.isnan(row["duration_s"])
    record = report.record()
    assert list(record["direct"].values()) == [1, 1]
    for key, name in (("outcomes", "outcome"), ("engines", "engine")):
        values = [row[name] for row in rows]
        assert record[key] == {value: values.count(value) for value in set(values)}
    assert record["without_result"] == 6


def test_turns_of_the_reduced_engine_are_named_and_counted(tmp_path: Path) -> None:
    """They are whole turns, and none of the direct engine."""
    speeds = "[parameters.speed_rpm]\nlow = 1150.0\nhigh = 1250.0\npoints = 40\n"
    found = plan(tmp_path, speeds)
    report = sweep(found, stored(tmp_path / "out", found))
    assert report.record()["engines"] == {"reduced_turn": 40}
    assert report.sentences() == [
        "40 do not arrive in the initial phase (premise_holds is false); 40 of them were computed "
        "by whole turns"
    ]


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
    report = sweep(found, stored(tmp_path / "out", found))
    said = any("2 ended at their largest number of collisions" in x for x in report.sentences())
    assert said is told
    durations = read_sweep(tmp_path / "out").table["duration_s"].to_numpy()
    assert np.isnan(durations).all() == told


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


# --- the smallest and the largest row ------------------------------------------------------------


@pytest.mark.parametrize(
    ("quantity", "values", "low", "high"),
    [
        # Missing ones; of equal ones the first is told.
        ("duration_s", [math.nan, 2.0, None, 1.0, 1.0, 2.0], (3, 1.0), (1, 2.0)),
        # From the start of turns on, at 24: a rest at 0.5 is later than one at 39.5.
        ("rest_index", [39.5, 0.5, 36.25], (2, 36.25), (1, 0.5)),
        ("collisions", [7, 3, 9], (1, 3.0), (2, 9.0)),
        ("premise_holds", [None, True, False], (2, 0.0), (1, 1.0)),
    ],
)  # fmt: skip
def test_extremes(
    quantity: str, values: list[Any], low: tuple[int, float], high: tuple[int, float],
    tmp_path: Path,
) -> None:  # fmt: skip
    """With the numbers of their rows, whichever chunk is first; one without values is nothing."""
    axes = "".join(f"[parameters.{name}]\nvalues = [1.0]\n" for name in ("speed_rpm", "preload"))
    job = replace(plan(tmp_path, axes).job, quantities=(quantity, "another"))
    half = len(values) // 2
    for parts in (range(half), range(half, len(values))), (range(half, len(values)), range(half)):
        found = Extremes(job)
        none = pa.table({"scenario": [9], quantity: [None], "speed_rpm": [1.0], "preload": [1.0]})
        found.add(none)
        assert (found.record()["smallest"], found.sentences()) == (None, [])
        for rows in parts:
            found.add(pa.table({
                "scenario": list(rows), quantity: [values[n] for n in rows],
                "speed_rpm": [2.0 * n for n in rows], "preload": [3.0 * n for n in rows],
            }))  # fmt: skip
        assert found.record() == {"quantity": quantity, **{
            word: {"scenario": n, "value": value,
                   "numbers": {"speed_rpm": 2.0 * n, "preload": 3.0 * n}}
            for word, (n, value) in (("smallest", low), ("largest", high))
        }}  # fmt: skip


# --- faults of the program -----------------------------------------------------------------------


def faulty(monkeypatch: pytest.MonkeyPatch, error: Exception, speed: float) -> None:
    """Transitions that raise an error wherever this speed is among them."""
    right = chunks.table_of

    def table(mechanism: Any, cases: Any, settings: Any) -> Any:
        if speed in cases.speed_rpm:
            raise error
        return right(mechanism, cases, settings)

    monkeypatch.setattr(chunks, "table_of", table)


def test_faults_of_the_program_and_errors_of_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fault is no outcome: it names the scenario and where it happened; an error is one."""
    found = plan(tmp_path, "chunk = 1\n[parameters.speed_rpm]\nvalues = [450.0, 550.0]\n")
    with monkeypatch.context() as broken:
        faulty(broken, ValueError("a shape"), 550.0)
        with pytest.raises(SimulationError) as caught:
            stored(tmp_path / "out", found)
    assert read_sweep(tmp_path / "out").table["scenario"].to_pylist() == [0]
    said = caught.value.message
    assert said.startswith("scenario 1: a fault of the program, please report it: ValueError")
    assert "test_sweep_outcomes.py, line" in said
    faulty(monkeypatch, SimulationError("a dead centre"), 550.0)
    rows = read_sweep(stored(tmp_path / "out", found)).table.to_pylist()
    assert [row["outcome"] for row in rows] == ["at_rest", "failed"]
    assert rows[1]["message"] == "a dead centre"


# --- the time that is expected -------------------------------------------------------------------


def test_dry_run_says_how_long(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """No row is written; a chunk is timed whole, and all chunks take their share of its time."""
    path = study(tmp_path, GEOMETRY)
    arguments = ["sweep", path, "--dry-run", "--workers", "1", "--json", "plan"]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    assert main([*arguments, "--chunks", "6-7"]) == 0
    document = json.loads((tmp_path / "plan").read_text(encoding="utf-8"))
    assert (document["scenarios"], document["chunks"]) == (6, 2)
    found = document["estimate"]
    assert (found["engines"], found["workers"]) == ({"direct": 2}, 1)
    assert found["seconds"] == pytest.approx(1.5 + 6 * found["scenario_s"], rel=1e-12)
    assert found["scenario_s"] > 0.0
    assert {item.name for item in tmp_path.iterdir()} == {Path(path).name, "plan"}
    size, time, written, following = capsys.readouterr().out.splitlines()
    assert written == "written: plan"
    assert size == "6 of 30 scenarios of 15 mechanisms in 2 of 8 chunks"
    words = (
        r"about \S+ (s|min|h) on 1 processors here: \S+ ms a scenario \(timed: 2 by the .* direct\)"
    )
    assert re.fullmatch(words, time)
    assert following == f"Next: nipper-pin sweep {path}"


@pytest.mark.slow
def test_of_a_billion_a_chunk_near_the_start_is_timed(tmp_path: Path) -> None:
    """A sequence is drawn up to the chunk; as many as possible are timed in some seconds."""
    found = estimate(plan(tmp_path, TABLE.replace("600", "1_000_000_000")), 3)
    assert max(found.engines, key=lambda name: found.engines[name]) == "reduced"
    assert found.workers == 3
    assert found.seconds == pytest.approx(1.5 + 1e9 * found.scenario_s / 3, rel=1e-12)


def test_times_have_the_unit_that_suits_them() -> None:
    units = {1.6: "2 s", 180.0: "180 s", 181.0: "3 min", 10_801.0: "3 h", 360_000.0: "100 h"}
    for seconds, words in units.items():
        found = Estimate(
            seconds=seconds, workers=3, scenario_s=2.5e-5, engines={"reduced": 1024, "direct": 8}
        )
        assert found.sentence() == (
            f"about {words} on 3 processors here: 0.025 ms a scenario (timed: 1,024 by the engine "
            "reduced, 8 by the engine direct)"
        )
