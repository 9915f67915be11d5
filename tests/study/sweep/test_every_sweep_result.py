"""Every column of a sweep, every count of its summary, and the words of its report."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from sweep_studies import FULL, plan

from nipper_pin import InputError, SimulationError, load
from nipper_pin.study.sweep import chunks as chunks_module
from nipper_pin.study.sweep.chunks import _Columns
from nipper_pin.study.sweep.job import versions
from nipper_pin.study.sweep.report import SweepReport
from nipper_pin.study.sweep.results.chunk_file import read
from nipper_pin.study.sweep.results.record import plan_record
from nipper_pin.study.sweep.results.table import read_sweep
from nipper_pin.study.sweep.results.tally import SUMMARY, Tally


def results(*engines: str, why: str, messages: tuple[str, ...]) -> Any:
    n = len(engines)
    return SimpleNamespace(
        engine=np.array(engines), outcome=np.array(["at_rest"] * n), message=messages,
        collisions=np.arange(4, 4 + n), premise_holds=np.array([True, False, None][:n], object),
        duration=np.arange(n) + 0.5, rebound_amplitude=np.arange(2.0 * n).reshape(n, 2), why=why,
        __len__=lambda: n,
    )  # fmt: skip


def test_turns_of_the_reduced_engine_are_named_and_counted(tmp_path: Path) -> None:
    """They are whole turns, and none of the direct engine."""
    found = plan(tmp_path, FULL)
    columns = _Columns(found.job, 0, np.zeros((3, 3)))
    columns.keep(slice(0, 3), results("turn", "reduced_turn", "reduced_turn", why="reduced: x",
                                      messages=("a turn",) * 3))  # fmt: skip
    columns.premise[:] = False
    tally = Tally()
    tally.add(read(columns.parquet()))
    assert dict(tally.engines) == {"turn": 1, "reduced_turn": 2}
    assert sum(tally.direct.values()) == 1
    report = SweepReport(folder=tmp_path, scenarios=3, found=0, computed=3, chunks=1, damaged=(),
                         workers=1, wall_s=1.0, tally=tally, extremes=NOTHING)  # fmt: skip
    told = report.sentences()
    assert told[-1] == (
        "3 do not arrive in the initial phase (premise_holds is false); 3 of them were computed by "
        "whole turns"
    )


# Stands in for the smallest and the largest row.
NOTHING: Any = SimpleNamespace(record=lambda: "those of the rows")


def test_rows_of_a_chunk_as_a_file(tmp_path: Path) -> None:
    """Columns, what the file says of itself, and why the direct engine served."""
    found = plan(tmp_path, FULL.replace("rebound_amplitude_1", "rebound_amplitude_2"))
    rows = np.arange(15.0).reshape(5, 3)
    columns = _Columns(found.job, 40, rows)
    left = "the reduced engine: too low"
    columns.keep(slice(0, 3), results("reduced", "turn", "direct", why="reduced: 32 of one; 2 that",
                                      messages=("", "a turn", left)))  # fmt: skip
    columns.keep(slice(3, 4), results("direct", why="direct: few; more", messages=("",)))
    columns.fail(slice(4, 5), "no_model", "none such")
    table = read(columns.parquet())
    assert table.to_pydict() == {
        "scenario": [40, 41, 42, 43, 44],
        **{axis.name: rows[:, n].tolist() for n, axis in enumerate(found.axes)},
        "engine": ["reduced", "turn", "direct", "direct", "none"],
        "outcome": ["at_rest"] * 4 + ["no_model"],
        "message": ["", "a turn", left, "", "none such"],
        "collisions": [4, 5, 6, 4, 0], "premise_holds": [True, False, None, True, None],
        "duration_s": [0.5, 1.5, 2.5, 0.5, pytest.approx(math.nan, nan_ok=True)],
        "rebound_amplitude_2": [1.0, 3.0, 5.0, 1.0, pytest.approx(math.nan, nan_ok=True)],
    }  # fmt: skip
    about = json.loads(table.schema.metadata[b"nipper_pin"])
    assert about == {
        "model": "e62", "versions": versions(), "plan": found.job.identity,
        "study": found.job.study,
        "direct": {"few": 1, "the reduced engine: too low": 1,
                   "whole turns, since the premise of a transition does not hold": 1},
    }  # fmt: skip
    units = {item.name: item.metadata for item in table.schema}
    assert units["duration_s"] == {b"unit": b"s"}
    assert units["preload"] == {b"unit": b"mm"}
    assert units["engine"] is units["collisions"] is None
    damaged = bytearray(columns.parquet())
    pages = pq.read_metadata(pa.BufferReader(bytes(damaged))).row_group(0).column(1)
    damaged[pages.data_page_offset + pages.total_compressed_size - 4] ^= 1
    with pytest.raises(OSError, match=r"(?i)crc"):
        pq.read_table(pa.BufferReader(bytes(damaged)), page_checksum_verification=True)
    columns.keep(slice(0, 1), results("direct", why="reduced: 32", messages=("else",)))
    assert columns.direct["the reduced engine did not solve them"] == 1
    assert [*chunks_module._runs(np.array([[1.0, 2], [1, 2], [1, 3], [4, 3], [4, 3]]))] == [
        (0, 2), (2, 3), (3, 5),
    ]  # fmt: skip


def tallied() -> Tally:
    """Two chunks, three rows without a result, of two reasons that differ in numbers alone."""
    tally = Tally()
    for direct, outcomes, messages in (
        ({"few": 2}, ["at_rest", "failed", "no_model"], ["", "at 1.5e-3 mm", "gone"]),
        ({"few": 1, "low": 3, "turn": 1, "hot": 2}, ["failed", "at_rest", "at_rest"],
         ["at -7 mm", "", "x"]),
    ):  # fmt: skip
        table = pa.table(
            {"scenario": [0, 1, 2], "engine": ["reduced", "none", "turn"], "outcome": outcomes,
             "message": messages, "premise_holds": pa.array([True, None, False])}
        )  # fmt: skip
        text = json.dumps({"direct": direct})
        tally.add(table.select(SUMMARY).replace_schema_metadata({"nipper_pin": text}))
    return tally


def test_the_summary_of_rows() -> None:
    tally = tallied()
    assert tally.rows == 6
    assert tally.record() == {
        "outcomes": {"at_rest": 3, "failed": 2, "no_model": 1},
        "engines": {"reduced": 2, "none": 2, "turn": 2},
        "direct": {"few": 3, "low": 3, "turn": 1, "hot": 2},
        "premise_holds": {"true": 2, "null": 2, "false": 2}, "without_result": 3,
    }  # fmt: skip
    # The first one of those that count together is told.
    assert tally.most_frequent == ("at 1.5e-3 mm", 2)


def test_the_report() -> None:
    tally = tallied()
    report = SweepReport(folder=Path("here"), scenarios=6, found=1, computed=5, chunks=2,
                         damaged=("a", "b"), workers=3, wall_s=2.5, tally=tally,
                         extremes=NOTHING)  # fmt: skip
    assert report.record() == {
        "folder": "here", "scenarios": 6, "found": 1, "computed": 5, "chunks": 2, "wall_s": 2.5,
        "damaged": ["a", "b"], "workers": 3, **tally.record(), "extremes": "those of the rows",
    }  # fmt: skip
    assert report.sentences() == [
        "damaged, and computed anew: a, b",
        "3 by the direct engine: few",
        "3 by the direct engine: low",
        "2 by the direct engine: hot",
        "2 do not arrive in the initial phase (premise_holds is false); 2 of them were computed by "
        "whole turns",
        "3 without a result, 2 because: at 1.5e-3 mm",
    ]
    report.check()
    with pytest.raises(SimulationError, match="none of 3 scenarios has a result, 2 of them") as no:
        replace(report, scenarios=3).check()
    assert no.value.evidence == {"scenarios": 3, "reason": "at 1.5e-3 mm"}
    empty = Tally()
    empty.premise, empty.direct = Counter(), Counter()
    assert replace(report, tally=empty, damaged=()).sentences() == []


@pytest.mark.parametrize(("most", "step"), [(None, 1), (36, 1), (35, 5), (9, 5), (4, 11), (1, 37)])
def test_rows_that_are_read(tmp_path: Path, most: int | None, step: int) -> None:
    """Every k-th of all, where k has no factor in common with the sizes of the grids, 3 and 2."""
    found = plan(tmp_path, FULL)
    out = tmp_path / "out"
    (out / "chunks").mkdir(parents=True)
    (out / "plan.json").write_text(json.dumps(plan_record(found)), encoding="utf-8")
    with pytest.raises(InputError, match="nothing is computed yet"):
        read_sweep(out)
    rows = np.concatenate([part for _, part in found.rows(found.chunks())])
    for number, chunk in enumerate(found.chunks()):
        columns = _Columns(found.job, chunk.start, rows[chunk.start : chunk.stop])
        (out / "chunks" / f"{number:07d}.parquet").write_bytes(columns.parquet())
    sweep = read_sweep(out, most)
    assert sweep.table["scenario"].to_pylist() == [*range(0, 36, step)]
    assert (sweep.scenarios, sweep.stored, sweep.title) == (36, 36, "test")
    assert sweep.quantities == found.job.quantities
    assert [axis["name"] for axis in sweep.axes] == [axis.name for axis in found.axes]
    assert sweep.model == load("e62").title
    assert repr(sweep) == (
        f"<SweepTable of {sweep.model}: {len(sweep.table)} scenarios over restitution, preload, "
        "links.top_nipper.mass_kg>"
    )
    assert sweep.to_frame("pyarrow") is sweep.table
    frame = sweep.to_frame("pandas")
    assert list(frame) == sweep.table.column_names
    assert frame["scenario"].tolist() == sweep.table["scenario"].to_pylist()
    page, shown = sweep._repr_html_(), min(len(sweep.table), 12)
    assert "36 of 36 stored" in page
    assert (f"and {len(sweep.table) - shown} more" in page) is (len(sweep.table) > shown)
    assert page.count("<tr>") == 2 + 1 + shown
