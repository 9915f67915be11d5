"""What a sweep leaves on disk: no damage is read as numbers, and every file says what it is."""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from programs import study_text
from sweep_studies import chunk_files, plan, stored

import nipper_pin as nip
from nipper_pin import InputError, load, read_sweep
from nipper_pin.cli import main
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.study.sweep import read_plan, sweep

SMALL = study_text("sweep_of_files.toml")


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("swept")
    stored(folder / "out", plan(folder, SMALL))
    return folder


@pytest.fixture
def copy(swept: Path, tmp_path: Path) -> Path:
    shutil.copytree(swept, tmp_path / "copy")
    return tmp_path / "copy"


def chunk(folder: Path, number: int = 0) -> Path:
    return folder / "out" / "chunks" / f"{number:07d}.parquet"


# --- damage ------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [199, pytest.param(61, marks=pytest.mark.campaign)])
def test_no_flipped_bit_changes_a_row(copy: Path, step: int) -> None:
    """A bit of a chunk, turned, is an error, or one of those that no row depends on.

    Pages have checksums; a name or a place of the footer that is another one is missed.
    """
    file, out = chunk(copy), copy / "out"
    for number in range(1, 6):
        chunk(copy, number).unlink()
    whole, rows = file.read_bytes(), read_sweep(out).table
    refused, damaged = 0, bytearray(whole)
    for bit in range(0, 8 * len(whole), step):
        damaged[bit // 8] ^= 1 << bit % 8
        file.write_bytes(damaged)
        try:
            assert read_sweep(out).table.equals(rows)
        except InputError:
            refused += 1
        damaged[bit // 8] ^= 1 << bit % 8
    assert damaged == whole
    assert refused > 4 * len(whole) // step
    half = len(whole) // 2
    for part in (whole[1:], whole[:half] + whole[half + 1 :], whole + b"\0"):
        file.write_bytes(part)
        with pytest.raises(InputError, match="damaged"):
            read_sweep(out)


def written(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    return bytes(sink.getvalue())


def with_another_number(whole: bytes) -> bytes:
    """A chunk of which a bit in the pages of a column of numbers is turned."""
    columns = pq.read_metadata(pa.BufferReader(whole)).row_group(0)
    column = next(
        columns.column(place)
        for place in range(columns.num_columns)
        if columns.column(place).path_in_schema == "duration_s"
    )
    damaged = bytearray(whole)
    damaged[column.data_page_offset + column.total_compressed_size - 4] ^= 1
    return bytes(damaged)


def test_damaged_chunks_are_named_and_computed_anew(
    copy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A turned bit, and whole files that are not what belongs in their place.

    A file of another plan or place, one that lost a row, and rows in another order. Of the first
    three reading names the file and what to do: their rows would be wrong, those of another
    machine, or stand in a table twice. Doing it mends all; the right chunk is not written again,
    and what a killed process left is not taken for one. Pages carry checksums, so whoever reads
    chunks by pyarrow alone can have their numbers checked.
    """
    (tmp_path / "other").mkdir()
    other = plan(tmp_path / "other", SMALL.replace(", 11.5, 12.0, 12.5]", "]"))
    stored(tmp_path / "other" / "out", other)
    out, file, whole = str(copy / "out"), chunk(copy, 1), chunk_files(copy / "out")
    (file.parent / ".0000009.parquet.1.partial").write_bytes(b"half of it")
    kept = chunk(copy).stat().st_mtime_ns
    doctored = {
        1: (with_another_number(file.read_bytes()), "damaged"),
        2: (chunk(tmp_path / "other", 2).read_bytes(), "holds scenarios of another plan"),
        3: (chunk(copy).read_bytes(), "holds scenarios of another chunk"),
        4: (written(pq.read_table(chunk(copy, 4)).slice(0, 1)), ""),
        5: (written(pq.read_table(chunk(copy, 5)).take([1, 0])), ""),
    }  # fmt: skip
    for number, (content, named) in doctored.items():
        right = chunk(copy, number).read_bytes()
        chunk(copy, number).write_bytes(content)
        if named:
            assert main(["plot", out]) == 2
            said = capsys.readouterr().err
            assert f".parquet: {named}" in said
            assert "; run the sweep again" in said
            assert said.count("\n") == 1
            chunk(copy, number).write_bytes(right)
    for number, (content, _) in doctored.items():
        chunk(copy, number).write_bytes(content)
    assert pq.read_metadata(file).num_rows == 2
    with pytest.raises(OSError, match=r"(?i)crc"):
        pq.read_table(file, page_checksum_verification=True)
    assert main(["sweep", str(copy / "study.toml"), "--out", out, "--workers", "1"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "2 were there, 10 computed" in said
    assert "damaged, and computed anew: " + ", ".join(list(whole)[1:]) in said
    assert {name: chunk_files(copy / "out")[name] for name in whole} == whole
    assert chunk(copy).stat().st_mtime_ns == kept
    assert read_sweep(out).stored == 12


def test_records_of_another_format(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of each key that is read again, and of the whole."""
    file = copy / "out" / "plan.json"
    whole = json.loads(file.read_text(encoding="utf-8"))
    damaged = "not the plan of a sweep, or a damaged one"
    keys = ("hash", "identity", "title", "model", "scenarios", "axes", "samples", "quantities",
            "description")  # fmt: skip
    texts = {json.dumps({**whole, key: 1.5}): damaged for key in keys}
    texts |= dict.fromkeys(("[]", "{", "{}"), damaged)
    texts[json.dumps({**whole, "format": 3})] = "format 3, and this version reads 2; sweep again"
    for text, said in texts.items():
        file.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=said) as caught:
            read_sweep(copy / "out")
        assert caught.value.evidence == {"file": str(file)}
    assert main(["plot", str(copy / "out")]) == 2
    assert capsys.readouterr().err == f"nipper-pin: {caught.value.message}\n"


def test_chunks_without_a_plan(copy: Path) -> None:
    """Without chunks the plan is written; with chunks and no plan nothing is."""
    found, out = read_plan(str(copy / "study.toml")), copy / "out"
    (out / "plan.json").unlink()
    with pytest.raises(InputError, match=r"holds chunks and no plan\.json") as caught:
        sweep(found, out, workers=1)
    assert caught.value.evidence == {"folder": str(out)}
    assert not (out / "plan.json").exists()
    for path in (out / "chunks").iterdir():
        path.unlink()
    stored(out, found)
    assert json.loads((out / "plan.json").read_text(encoding="utf-8"))["hash"] == found.hash


# --- what files say of themselves --------------------------------------------------------------


def test_every_chunk_says_what_it_is_of(swept: Path) -> None:
    """Units, model, versions and the study, in the file itself and wherever it is copied to."""
    schema = pq.read_schema(chunk(swept))
    units = {field.name: (field.metadata or {}).get(b"unit") for field in schema}
    assert {name: unit for name, unit in units.items() if unit is not None} == {
        "restitution": b"1", "preload": b"mm", "duration_s": b"s", "rebound_amplitude_1": b"rad",
        "impulse_N_s_1": b"N s", "first_two_share": b"1",
    }  # fmt: skip
    about = json.loads(schema.metadata[b"nipper_pin"])
    assert about["model"] == "e62"
    assert about["versions"]["numpy"] == np.__version__
    assert set(about["versions"]) == {"nipper-pin", "pin", "numpy", "scipy", "numba"}
    assert about["study"] == (swept / "study.toml").read_text(encoding="utf-8")
    stored = json.loads((swept / "out" / "plan.json").read_text(encoding="utf-8"))
    assert stored["study"] == about["study"]
    # A row computed from its metadata alone: value and unit give the preload of the machine.
    row = pq.read_table(chunk(swept)).to_pylist()[0]
    spring = load("e62", {"springs.steeve.preload_length_mm": row["preload"]}).springs[0]
    assert spring.preload == pytest.approx(1e-3 * row["preload"], rel=1e-15)


# --- more points -------------------------------------------------------------------------------

POINTS = study_text("sweep_of_points.toml")


@pytest.mark.slow
def test_more_points_of_a_sequence_keep_the_first_ones(tmp_path: Path) -> None:
    """5, then 9, then 12 points: files of the first ones stay, rows are those of 12 at once.

    Rows are compared as a set: a point keeps its number, and new ones get numbers behind all.
    """
    out, whole = tmp_path / "out", plan(tmp_path, POINTS.replace("count = 5", "count = 12"))
    stored(out, plan(tmp_path, POINTS))
    first = chunk_files(out)
    for count, found in ((9, 10), (12, 18)):
        more = plan(tmp_path, POINTS.replace("count = 5", f"count = {count}"))
        report = sweep(more, out, workers=1)
        assert (report.found, report.scenarios) == (found, 2 * count)
    assert {name: chunk_files(out)[name] for name in first} == first
    both = [read_sweep(folder).table for folder in (out, stored(tmp_path / "whole", whole))]
    assert both[0]["scenario"].to_pylist() == list(range(24))
    columns = ("restitution", "links.top_nipper.mass_kg")
    keys = [sorted(zip(*(t[name].to_pylist() for name in columns), strict=True)) for t in both]
    assert keys[0] == keys[1]
    durations = [np.sort(table["duration_s"].to_numpy()) for table in both]
    np.testing.assert_allclose(durations[0], durations[1], rtol=1e-8)


STUDY = """format = 1
title = "two drives of a hammer"
model = '{model}'
quantities = ["duration_s", "rebound_amplitude_1", "approach_rate_1", "impulse_N_s_1"]
[parameters.speed_rpm]
values = [60.0, 120.0]
[parameters.restitution]
values = [0.0, 0.3]
"""


@pytest.mark.parametrize(("model", "unit", "factor", "path"), [
    ("e62", ("rad", "deg"), math.degrees(1.0), "stops.jaw.restitution"),
    (GALLERY["drop_hammer"], ("m", "mm"), 1e3, "stops.height.restitution"),
])  # fmt: skip
def test_heads_of_a_table_say_their_units(
    model: str, unit: tuple[str, str], factor: float, path: str, tmp_path: Path
) -> None:
    """All rows in order, numbers to the last digit, nothing where there is none."""
    study, folder = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(STUDY.format(model=model), encoding="utf-8")
    rows = {}
    for units in ("SI", "mm"):
        file = tmp_path / f"{units}.csv"
        words = ["sweep", study, "--out", folder, "--workers", 1, "--csv", file, "--units", units]
        assert main([str(word) for word in words]) == 0
        with file.open(encoding="utf-8", newline="") as stream:
            rows[units] = list(csv.DictReader(stream))
    stored, shown = nip.read_sweep(folder), nip.read_sweep(folder).to_frame("pyarrow", "mm")
    for kind, name in enumerate(unit):
        own = rows[("SI", "mm")[kind]]
        assert [float(row["speed_rpm"]) for row in own] == [60.0, 60.0, 120.0, 120.0]
        assert [float(row[path]) for row in own] == [0.0, 0.3, 0.0, 0.3]
        scale = factor if kind else 1.0
        heads = {"rebound_amplitude_1": name, "approach_rate_1": f"{name}_s"}
        heads = {key: f"{key}_{end}" for key, end in heads.items()}
        heads |= {key: key for key in ("duration_s", "impulse_N_s_1") if key in own[0]}
        assert {*heads.values()} <= {*own[0]}
        for key, head in heads.items():
            times = scale if head != key else 1.0
            wanted = np.array(stored.table[key].to_pylist(), dtype=float) * times
            found = [float(row[head] or math.nan) for row in own]
            np.testing.assert_array_equal(found, wanted)
            if kind:
                np.testing.assert_array_equal(np.array(shown[head].to_pylist(), float), wanted)
    with pytest.raises(nip.UnknownNameError, match="inch"):
        stored.to_frame(units="inch")
