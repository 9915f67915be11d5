"""What is too large, too many or out of order is refused by name, before it takes much."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import packed, stored_run
from snapshots import Words

from nipper_pin import (
    Case,
    InputError,
    ModelError,
    NipperError,
    load,
    load_case,
    load_solution,
    save,
    simulate,
    texts,
)
from nipper_pin.mechanism import Characteristic, find_model, from_sources
from nipper_pin.mechanism.drives import Table
from nipper_pin.study.identify import read_measured
from nipper_pin.study.sweep import read_plan
from nipper_pin.view.scene.meshes import read_mesh

HERE = Path(__file__).parent
PARTS, CORPUS = HERE / "bases" / "parts", HERE / "corpus"
SWEEP = (HERE / "bases" / "sweep.toml").read_text(encoding="utf-8")
RUN = CORPUS / "npz" / "bouncing_ball.npz"
MESHES = [PARTS / "meshes" / f"tetrahedron.{kind}" for kind in ("stl", "obj")]


def parts(text: str | None = None, **changed: object) -> None:
    document = tomllib.loads((PARTS / "parts.toml").read_text(encoding="utf-8"))
    tree = (PARTS / "parts.urdf").read_text(encoding="utf-8") if text is None else text
    from_sources("parts", tree, {**document, **changed}, PARTS)


def touching_meshes(_: Path) -> None:
    """Both meshes in shapes that touch."""
    text = (PARTS / "parts.urdf").read_text(encoding="utf-8")
    link, mesh = '<link name="lh8">', '<mesh filename="meshes/tetrahedron.obj"/>'
    parts(text.replace(link, f"{link}<collision><geometry>{mesh}</geometry></collision>"))


def rows(count: int) -> tuple[float, ...]:
    return tuple(np.linspace(0.0, 2.0 * np.pi, count).tolist())


def measured(folder: Path) -> None:
    file = folder / "m.csv"
    file.write_text("speed_rpm,quantity,value,sigma\n" + "450,rebound_time_s_1,1,1\n" * 3)
    assert len(read_measured(file)) == 3


def chunks(folder: Path) -> None:
    file = folder / "sweep.toml"
    file.write_text(SWEEP.replace("chunk = 4", "chunk = 1"), encoding="utf-8")
    assert len(read_plan(str(file)).chunks()) == 4


BOTH = sum(mesh.stat().st_size for mesh in MESHES)
# Where a limit stands, as many as there are, and what reads them.
LIMITS: list[tuple[str, int, Callable[[Path], object]]] = [
    ("mechanism.files.urdf._MOST_LINKS", 25, lambda _: parts()),
    ("mechanism.files.urdf._MOST_MOVING", 18, lambda _: parts()),
    ("mechanism.files.urdf._MOST_SHAPES", 3, lambda _: parts()),
    ("mechanism.files.describe._MOST_ENTRIES", 7, lambda _: parts()),
    ("mechanism.files.describe._MOST_PHASES", 2, lambda _: parts()),
    ("mechanism.build.contact._MOST_PAIRS", 1, lambda _: parts()),
    ("mechanism.build.stops._MOST_CONTACTS", 1, lambda _: parts()),
    # Meshes that touch are counted together, those that are drawn one by one.
    ("mechanism.files.urdf_shapes.MOST_MESH", BOTH, touching_meshes),
    ("mechanism.files.urdf_shapes.MOST_MESH", MESHES[1].stat().st_size,
     lambda _: read_mesh(MESHES[1])),
    ("mechanism.elements.MOST_ROWS", 4,
     lambda _: Characteristic(coordinate=rows(4), force=(0.0,) * 4)),
    ("mechanism.elements.MOST_ROWS", 8,
     lambda _: Table(cylinder_angle_rad=rows(8), coordinate=(0.0,) * 8)),
    ("study.identify.problem.measured._MOST_LINES", 3, measured),
    ("study.sweep.plan._MOST_CHUNKS", 4, chunks),
    ("hybrid.files.archive.MOST_ARRAYS", 9, lambda _: load_solution(RUN)),
    ("hybrid.files.archive.MOST_TEXT", 25972, lambda _: load_solution(RUN)),
]  # fmt: skip


def test_one_more_than_the_most_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: Words
) -> None:
    text = ""
    for name, count, use in LIMITS:
        with monkeypatch.context() as limited:
            limited.setattr(f"nipper_pin.{name}", count)
            use(tmp_path)
            limited.setattr(f"nipper_pin.{name}", count - 1)
            with pytest.raises(InputError) as caught:
                use(tmp_path)
        text += f"{name} = {count - 1}\n    {caught.value.message}\n"
    words(text.replace(str(CORPUS), "CORPUS"))


@pytest.mark.parametrize(
    ("limit", "name", "read"),
    [
        ("MOST_TEXT", "e62/e62.toml", lambda path: load(path.parent)),
        ("MOST_TEXT", "e62/e62.urdf", lambda path: load(path.parent)),
        ("MOST_TEXT", "sweep.toml", lambda path: read_plan(str(path))),
        ("MOST_JSON", "case.json", load_case),
        ("MOST_TABLE", "rebounds.csv", read_measured),
    ],
)
def test_every_reader_has_the_limit(
    limit: str, name: str, read: Callable[[Path], Any], tmp_path: Path
) -> None:
    """One byte more than is read is enough."""
    (tmp_path / "e62").mkdir()
    bases = [*find_model("e62").glob("e62.*"), HERE / "bases" / "sweep.toml",
             HERE / "bases" / "rebounds.csv", CORPUS / "case" / "bouncing_ball.json"]  # fmt: skip
    for base in bases:
        called = {"e62": f"e62/{base.name}", "bouncing_ball": "case.json"}.get(base.stem, base.name)
        (tmp_path / called).write_bytes(base.read_bytes())
    file = tmp_path / name
    read(file)
    file.write_bytes(file.read_bytes().ljust(getattr(texts, limit) + 1, b"\n"))
    with pytest.raises(InputError, match=r"larger than .* MiB") as caught:
        read(file)
    assert caught.value.evidence == {"file": str(file), "most": getattr(texts, limit)}


@pytest.mark.parametrize(
    ("table", "place", "key", "value"),
    [("events", 1, "number", 7), ("events", 1, "t", -1e3), ("segments", 0, "t_end", 1e3),
     ("events", 0, "energy_lost", 1e31)],
)  # fmt: skip
def test_runs_out_of_order_are_refused(
    table: str, place: int, key: str, value: float, tmp_path: Path
) -> None:
    """Found by the fuzzer: errors of events divided by a time that went backwards."""
    file = tmp_path / "run.npz"
    document, arrays = stored_run(RUN)
    document[table][place][key] = value
    file.write_bytes(packed(document, arrays))
    with pytest.raises(InputError, match=r"not in order|<= 1e\+30"):
        load_solution(file)


def test_copies_of_a_turn_may_overlap_by_round_off(tmp_path: Path) -> None:
    """Turns that are copies begin at a sum of turns, which is rounded."""
    file = tmp_path / "run.npz"
    document, arrays = stored_run(RUN)
    first, second = document["segments"][:2]
    assert first["t_end"] == second["t_start"] > 0.0
    first["t_end"] *= 1.0 + 4e-16
    assert first["t_end"] > second["t_start"]
    file.write_bytes(packed(document, arrays))
    assert load_solution(file).segments[0].t_end == first["t_end"]
    first["t_end"] *= 1.0 + 1e-12
    file.write_bytes(packed(document, arrays))
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


@pytest.mark.parametrize("name", ["x" * 300, "x/" * 1200, "a\0b"])
def test_names_that_no_file_can_have(name: str, tmp_path: Path) -> None:
    """Of a mesh, a table, measurements, a model, and the model of a sweep."""
    text = (PARTS / "parts.urdf").read_text(encoding="utf-8")
    for mesh in ("meshes/tetrahedron.stl", "package://parts/meshes/tetrahedron.obj"):
        if "\0" not in name:
            with pytest.raises(ModelError, match="stays inside it"):
                parts(text.replace(mesh, name))
    with pytest.raises(ModelError, match="a CSV file in the model folder"):
        parts(springs={"rows": {"joint": "s2", "file": name}})
    with pytest.raises(InputError, match="no path of a file"):
        read_measured(name)
    with pytest.raises(InputError, match="there is no model"):
        load(name)
    file = tmp_path / "sweep.toml"
    file.write_text(SWEEP.replace('"e62"', json.dumps(name)), encoding="utf-8")
    with pytest.raises(InputError):
        read_plan(str(file))
