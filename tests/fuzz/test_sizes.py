"""What is too large, too many or out of order is refused by name, before it takes much."""

from __future__ import annotations

import io
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import (
    Case,
    InputError,
    ModelError,
    load,
    load_case,
    load_solution,
    save,
    simulate,
    texts,
)
from nipper_pin.errors import NipperError
from nipper_pin.hybrid.files import archive
from nipper_pin.mechanism import elements, find_model, from_sources
from nipper_pin.mechanism.build import contact, stops
from nipper_pin.mechanism.drives import Table
from nipper_pin.mechanism.elements import Characteristic
from nipper_pin.mechanism.files import describe, urdf
from nipper_pin.study.identify.problem import measured
from nipper_pin.study.sweep import plan, read_plan

HERE = Path(__file__).parent
PARTS, CORPUS = HERE / "bases" / "parts", HERE / "corpus"
SWEEP = (HERE / "bases" / "sweep.toml").read_text(encoding="utf-8")


def parts(text: str | None = None, **changed: object) -> None:
    document = tomllib.loads((PARTS / "parts.toml").read_text(encoding="utf-8"))
    tree = (PARTS / "parts.urdf").read_text(encoding="utf-8") if text is None else text
    from_sources("parts", tree, {**document, **changed}, PARTS)


def test_texts_have_a_largest_size(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_bytes(b"ab\r\nc\rd\n")
    assert texts.read_text(file, 8) == "ab\nc\nd\n"
    with pytest.raises(InputError, match=r"a.txt: larger than 6.67572e-06 MiB") as caught:
        texts.read_text(file, 7)
    assert caught.value.evidence == {"file": str(file), "most": 7}
    file.write_bytes(b"\xff")
    with pytest.raises(UnicodeDecodeError):
        texts.read_text(file, 8)


@pytest.mark.parametrize(
    ("limit", "read"),
    [
        ("MOST_TEXT", lambda folder: load(folder / "e62")),
        ("MOST_TEXT", lambda folder: read_plan(str(folder / "sweep.toml"))),
        ("MOST_JSON", lambda folder: load_case(folder / "case.json")),
        ("MOST_TABLE", lambda folder: measured.read_measured(folder / "rebounds.csv")),
    ],
)
def test_every_reader_has_the_limit(
    limit: str, read: Callable[[Path], Any], tmp_path: Path
) -> None:
    """One byte more than is read is enough."""
    home = tmp_path / "e62"
    home.mkdir()
    for suffix in ("urdf", "toml"):
        text = (find_model("e62") / f"e62.{suffix}").read_text(encoding="utf-8")
        (home / f"e62.{suffix}").write_text(text, encoding="utf-8")
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    (tmp_path / "case.json").write_bytes((CORPUS / "case" / "bouncing_ball.json").read_bytes())
    (tmp_path / "rebounds.csv").write_bytes((HERE / "bases" / "rebounds.csv").read_bytes())
    read(tmp_path)
    for file in (*home.iterdir(), *(item for item in tmp_path.iterdir() if item.is_file())):
        file.write_bytes(file.read_bytes() + b"\n" * getattr(texts, limit))
    with pytest.raises(InputError, match=r"larger than .* MiB"):
        read(tmp_path)


@pytest.mark.parametrize(("most", "key"), [
    ("_MOST_LINKS", "links = 25"), ("_MOST_MOVING", "joints that move = 18"),
    ("_MOST_SHAPES", "collision shapes = 3"),
])  # fmt: skip
def test_trees_have_a_largest_size(most: str, key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    count = int(key.rpartition(" ")[2])
    monkeypatch.setattr(urdf, most, count)
    parts()
    monkeypatch.setattr(urdf, most, count - 1)
    with pytest.raises(ModelError, match=f"{key} cannot be used: at most {count - 1}"):
        parts()


def test_sections_have_a_most_of_entries(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(describe, "_MOST_ENTRIES", 7)
    parts()
    monkeypatch.setattr(describe, "_MOST_ENTRIES", 6)
    with pytest.raises(ModelError, match="drives = '7 entries' cannot be used: at most 6"):
        parts()
    monkeypatch.setattr(describe, "_MOST_ENTRIES", 7)
    monkeypatch.setattr(describe, "_MOST_PHASES", 1)
    with pytest.raises(ModelError, match="phases = '2 entries' cannot be used: at most 1"):
        parts()


def test_contacts_have_a_most_of_shapes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stops, "_MOST_CONTACTS", 1)
    monkeypatch.setattr(contact, "_MOST_PAIRS", 1)
    parts()
    monkeypatch.setattr(contact, "_MOST_PAIRS", 0)
    with pytest.raises(ModelError, match="'1 and 1 shapes' cannot be used: at most 0 pairs"):
        parts()
    monkeypatch.setattr(stops, "_MOST_CONTACTS", 0)
    with pytest.raises(ModelError, match="'1 contacts' cannot be used: at most 0 stops"):
        parts()


@pytest.mark.parametrize("value", [1.1e15, -1.1e15, 10**16, 1e308])
def test_numbers_have_a_largest_size(value: float) -> None:
    with pytest.raises(ModelError, match=r"gravity_m_s2 = .*at most 1e\+15"):
        parts(gravity_m_s2=value)
    text = (PARTS / "parts.urdf").read_text(encoding="utf-8")
    with pytest.raises(ModelError, match=r"joint h1 origin xyz.*of at most 1e\+15"):
        parts(text.replace('xyz="1 0 1"', f'xyz="{value:g} 0 1"'))


def test_joints_of_other_elements_are_left_alone() -> None:
    """Programs keep notes of their own in a URDF, with joints of fewer numbers."""
    text = (PARTS / "parts.urdf").read_text(encoding="utf-8")
    note = '<gazebo><joint name="x" type="revolute"><axis xyz="1"/></joint></gazebo></robot>'
    parts(text.replace("</robot>", note))


def test_tables_have_a_most_of_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(elements, "MOST_ROWS", 3)
    Characteristic(coordinate=(0.0, 1.0, 2.0), force=(0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="at most 3 rows; found 4"):
        Characteristic(coordinate=(0.0, 1.0, 2.0, 3.0), force=(0.0,) * 4)
    monkeypatch.setattr("nipper_pin.mechanism.drives.table.MOST_ROWS", 7)
    turn = tuple(np.linspace(0.0, 2.0 * np.pi, 8).tolist())
    with pytest.raises(InputError, match="at most 7 rows; found 8"):
        Table(cylinder_angle_rad=turn, coordinate=(0.0,) * 8)


def test_rows_that_make_no_curve_are_refused() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 8)
    near = turn.copy()
    near[2] = near[1] + 1e-13
    with pytest.raises(InputError, match="rows 2 and 3 of the drive table are too near"):
        Table(cylinder_angle_rad=tuple(near.tolist()), coordinate=(0.0,) * 8)
    with pytest.raises(InputError, match=r"row 4 .* of at most 1e\+15"):
        Table(cylinder_angle_rad=tuple(turn.tolist()), coordinate=(0.0,) * 3 + (1e16,) + (0.0,) * 4)


@pytest.mark.parametrize("key", ["rise_deg", "return_deg"])
def test_cams_that_rise_in_no_time_are_refused(key: str) -> None:
    text = (PARTS / "parts.toml").read_text(encoding="utf-8")
    lift = tomllib.loads(text)["drives"]["lift"]
    parts(drives={"lift": {**lift, key: 1.0}}, degrees_of_freedom=15)
    with pytest.raises(ModelError, match=r"rise and return take at least 5\.7e-08 deg each"):
        parts(drives={"lift": {**lift, key: 5e-324}})


def test_measurements_have_a_largest_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "m.csv"
    file.write_text("speed_rpm,quantity,value,sigma\n" + "450,rebound_time_s_1,1,1\n" * 3)
    monkeypatch.setattr(measured, "_MOST_LINES", 3)
    assert len(measured.read_measured(file)) == 3
    monkeypatch.setattr(measured, "_MOST_LINES", 2)
    with pytest.raises(InputError, match="more measurements than the 2 that are read"):
        measured.read_measured(file)


def test_sweeps_have_a_largest_number_of_chunks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(SWEEP.replace("chunk = 4", "chunk = 1"), encoding="utf-8")
    monkeypatch.setattr(plan, "_MOST_CHUNKS", 4)
    assert len(read_plan(str(file)).chunks()) == 4
    monkeypatch.setattr(plan, "_MOST_CHUNKS", 3)
    with pytest.raises(InputError, match="4 chunks of the scenarios, and at most 3 are stored"):
        read_plan(str(file)).chunks()


def run(document: dict[str, Any] | None = None, **arrays: Any) -> bytes:
    """A saved run with another document or more arrays."""
    with np.load(CORPUS / "npz" / "bouncing_ball.npz") as stored:
        found = {name: stored[name] for name in stored.files}
    whole = {**json.loads(str(found.pop("document"))), **(document or {})}
    stream = io.BytesIO()
    np.savez(stream, document=np.array(json.dumps(whole)), **found, **arrays)
    return stream.getvalue()


def test_runs_have_a_most_of_arrays_and_letters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "run.npz"
    file.write_bytes(run())
    load_solution(file)
    monkeypatch.setattr(archive, "MOST_ARRAYS", 3)
    with pytest.raises(InputError, match=r"holds \d+ arrays; at most 3 are read"):
        load_solution(file)
    monkeypatch.undo()
    monkeypatch.setattr(archive, "MOST_TEXT", 1000)
    with pytest.raises(InputError, match=r"document.npy is longer than 1e\+03 bytes"):
        load_solution(file)


@pytest.mark.parametrize("change", ["number", "t", "t_end", "large"])
def test_runs_out_of_order_are_refused(change: str, tmp_path: Path) -> None:
    """Found by the fuzzer: errors of events divided by a time that went backwards."""
    file = tmp_path / "run.npz"
    with np.load(CORPUS / "npz" / "bouncing_ball.npz") as stored:
        document = json.loads(str(stored["document"]))
    if change == "t_end":
        document["segments"][0]["t_end"] = 1e3
    elif change == "large":
        document["events"][0]["energy_lost"] = 1e31
    else:
        document["events"][1][change] = -1e3 if change == "t" else 7
    file.write_bytes(run(document))
    with pytest.raises(InputError, match=r"not in order|<= 1e\+30"):
        load_solution(file)


def test_copies_of_a_turn_may_overlap_by_round_off(tmp_path: Path) -> None:
    """Turns that are copies begin at a sum of turns, which is rounded."""
    file = tmp_path / "run.npz"
    with np.load(CORPUS / "npz" / "bouncing_ball.npz") as stored:
        document = json.loads(str(stored["document"]))
    first, second = document["segments"][:2]
    assert first["t_end"] == second["t_start"] > 0.0
    first["t_end"] *= 1.0 + 4e-16
    assert first["t_end"] > second["t_start"]
    file.write_bytes(run(document))
    assert load_solution(file).segments[0].t_end == first["t_end"]
    first["t_end"] *= 1.0 + 1e-12
    file.write_bytes(run(document))
    with pytest.raises(InputError, match="not in order"):
        load_solution(file)
    copies = Case(speed_rpm=650.0, window="cycle", cycles=60)
    assert load_solution(save(simulate(load("e62"), copies), file)).segments


def bomb(column: Any) -> bytes:
    """A chunk of one column."""
    pa = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    sink = pa.BufferOutputStream()
    pq.write_table(pa.table({"message": column}), sink, store_schema=False, compression="zstd")
    return bytes(sink.getvalue())


def test_chunks_that_repeat_a_word_are_measured_before_they_are_written_out() -> None:
    """A million words of a thousand letters take some bytes in the file."""
    pa = pytest.importorskip("pyarrow")
    from nipper_pin.study.sweep.results.chunk_file import read

    words = pa.DictionaryArray.from_arrays(np.zeros(1_000_000, dtype=np.int32), ["x" * 1000])
    content = bomb(words)
    assert len(content) < 2 * 10**5
    with pytest.raises(InputError, match=r"text would take 1e\+09 bytes; at most 2.68e\+08"):
        read(content)
    assert read(bomb(pa.array(["x" * 1000] * 10))).num_rows == 10


def test_pages_that_say_they_grow_more_than_they_do_are_refused() -> None:
    pa = pytest.importorskip("pyarrow")
    from nipper_pin.study.sweep.results.chunk_file import read

    content = bomb(pa.array([f"{k:0999}" for k in range(3000)]))
    assert read(content).num_rows == 3000
    # The first page begins behind the mark: field 1 is its kind, field 2 what it grows to.
    assert content[:7] == b"PAR1\x15\x04\x15"
    end = next(place for place in range(7, 12) if content[place] < 0x80) + 1
    larger = content[:7] + b"\xfe" + b"\xff" * (end - 9) + b"\x7f" + content[end:]
    assert len(larger) == len(content)
    parts = (larger, content[4:], content[:-1], content[:-8] + b"\xff\xff\0\0PAR1", b"", b"PAR1")
    for part in parts:
        with pytest.raises(InputError, match="damaged, or no chunk of a sweep"):
            read(part)


def test_messages_are_short_lines_whatever_they_quote() -> None:
    error = NipperError("a\nb\x1b[2J\u202e" + "x" * 10**6 + " write y")
    assert error.message.startswith("a\\nb\\x1b[2J\\u202exx")
    assert error.message.endswith("xx write y")
    assert len(error.message) < 5000
    assert str(error) == error.message


LONG = ["x" * 300, "x/" * 1200, "a\0b"]


@pytest.mark.parametrize("name", LONG)
def test_files_of_a_model_have_paths(name: str) -> None:
    text = (PARTS / "parts.urdf").read_text(encoding="utf-8")
    for mesh in ("meshes/tetrahedron.stl", "package://parts/meshes/tetrahedron.obj"):
        if "\0" not in name:
            with pytest.raises(ModelError, match="stays inside it"):
                parts(text.replace(mesh, name))
    with pytest.raises(ModelError, match="a CSV file in the model folder"):
        parts(springs={"rows": {"joint": "s2", "file": name}})
    with pytest.raises(InputError, match="no path of a file"):
        measured.read_measured(name)


@pytest.mark.parametrize("name", LONG)
def test_names_that_no_file_can_have_are_unknown_models(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no model"):
        load(name)
    file = tmp_path / "sweep.toml"
    file.write_text(SWEEP.replace('"e62"', json.dumps(name)), encoding="utf-8")
    with pytest.raises(InputError):
        read_plan(str(file))
