"""Rows of a sweep, what is said of them, and how they are read: of chunks computed here."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from snapshots import Words
from sweep_studies import plan, stored

from nipper_pin import InputError, load, transition_table
from nipper_pin.study.sweep import run_sweep
from nipper_pin.study.sweep.chunks import run_chunk
from nipper_pin.study.sweep.job import versions
from nipper_pin.study.sweep.results.chunk_file import read
from nipper_pin.study.sweep.results.record import plan_record
from nipper_pin.study.sweep.results.table import read_sweep

GRID = """
chunk = 9
quantities = ["duration_s", "rebound_amplitude_2"]
[parameters.speed_rpm]
values = [450.0, 550.0, 650.0]
[parameters.preload]
values = [10.0, 11.0, 12.0]
[parameters.restitution]
values = [0.1, 0.15, 0.2, 0.25]
"""
RADII = '[parameters."drives.pendulum.crank_radius_mm"]\nvalues = [63.0, -6.0, 10000.0, -7.0]\n'


def test_rows_are_those_of_a_table(tmp_path: Path) -> None:
    """To round-off: tables are sampled anew of a machine that went through its text, in 1e-13.

    In SI units; and the file says what it is of, and in which units.
    """
    found = plan(tmp_path, GRID.replace("chunk = 9", "chunk = 36"))
    ((chunk, rows),) = list(found.rows(found.chunks()))
    table = read(run_chunk(found.job.text(), chunk.start, rows))
    wanted = transition_table(
        load("e62"), speed_rpm=rows[:, 0], preload_length_mm=rows[:, 1], restitution=rows[:, 2]
    )
    assert set(wanted.engine) == {"reduced"}
    assert table["scenario"].to_pylist() == list(range(36))
    for name in ("engine", "outcome", "collisions", "premise_holds"):
        assert table[name].to_pylist() == getattr(wanted, name).tolist()
    assert table["message"].to_pylist() == [*wanted.message]
    second = wanted.rebound_amplitude[:, 1]
    for name, values in (("duration_s", wanted.duration), ("rebound_amplitude_2", second)):
        np.testing.assert_allclose(table[name].to_numpy(), values, rtol=1e-12)
    about = json.loads(table.schema.metadata[b"nipper_pin"])
    assert about == {
        "model": "e62", "versions": versions(), "plan": found.job.identity,
        "study": found.job.study, "direct": {},
    }  # fmt: skip
    units = {item.name: item.metadata for item in table.schema}
    assert units["duration_s"] == {b"unit": b"s"}
    assert units["preload"] == {b"unit": b"mm"}
    assert units["engine"] is units["collisions"] is None


def test_what_a_report_says(tmp_path: Path, words: Words) -> None:
    """Why the direct engine served, of which turns rows are, and what has no result and why.

    Reasons that differ in their numbers alone count as one. Nothing is left to compute.
    """
    found = plan(tmp_path, RADII + "[parameters.speed_rpm]\nvalues = [450.0, 1200.0]\n")
    report = run_sweep(found, stored(tmp_path / "out", found))
    assert (report.scenarios, report.found, report.computed, report.workers) == (8, 8, 0, 0)
    words("\n".join(report.sentences()) + "\n")
    rows = read_sweep(tmp_path / "out").table.to_pylist()
    assert {row["engine"] for row in rows if not row["message"]} == {"direct"}
    record = report.record()
    assert list(record["direct"].values()) == [1, 1]
    for key, name in (("outcomes", "outcome"), ("engines", "engine")):
        values = [row[name] for row in rows]
        assert record[key] == {value: values.count(value) for value in set(values)}
    assert record["without_result"] == sum(np.isnan(row["duration_s"]) for row in rows) == 6


def test_turns_of_the_reduced_engine_are_named_and_counted(tmp_path: Path) -> None:
    """They are whole turns, and none of the direct engine."""
    speeds = "[parameters.speed_rpm]\nlow = 1150.0\nhigh = 1250.0\npoints = 40\n"
    found = plan(tmp_path, speeds)
    report = run_sweep(found, stored(tmp_path / "out", found))
    assert report.record()["engines"] == {"reduced_turn": 40}
    assert report.sentences() == [
        "40 do not arrive in the initial phase (premise_holds is false); 40 of them were computed "
        "by whole turns"
    ]


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
    assert repr(sweep) == (
        f"<SweepTable of {load('e62').title}: {len(sweep.table)} scenarios over speed_rpm, "
        "preload, restitution>"
    )
    assert sweep.to_frame("pyarrow") is sweep.table
    frame = sweep.to_frame("pandas")
    assert list(frame) == sweep.table.column_names
    assert frame["scenario"].tolist() == sweep.table["scenario"].to_pylist()
    page, shown = sweep._repr_html_(), min(len(sweep.table), 12)
    assert "36 of 36 stored" in page
    assert (f"and {len(sweep.table) - shown} more" in page) is (len(sweep.table) > shown)
    assert page.count("<tr>") == 2 + 1 + shown


def test_a_folder_without_rows(tmp_path: Path) -> None:
    (tmp_path / "chunks").mkdir()
    record = json.dumps(plan_record(plan(tmp_path, GRID)))
    (tmp_path / "plan.json").write_text(record, encoding="utf-8")
    with pytest.raises(InputError, match="nothing is computed yet"):
        read_sweep(tmp_path)
