"""Saved runs and cases, cut off, edited or from elsewhere: refused, or read as what they are.

An exception that is not an error of the package comes through and fails the test.
"""

from __future__ import annotations

import io
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documents import GONE, VALUES, changed, places
from hypothesis import given
from hypothesis import strategies as st
from refusals import assert_clear, files, one_line

from nipper_pin import (
    Case,
    InputError,
    load,
    load_case,
    load_solution,
    save,
    save_case,
    simulate,
)

Run = tuple[Any, dict[str, np.ndarray]]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Document and arrays of a small stored run."""
    solution = simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=2))
    with np.load(save(solution, tmp_path_factory.mktemp("run") / "run.npz")) as stored:
        arrays = {name: stored[name] for name in stored.files}
    return json.loads(str(arrays.pop("document"))), arrays


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Document of a stored case."""
    path = tmp_path_factory.mktemp("case") / "case.json"
    return json.loads(save_case(load("e62"), Case(speed_rpm=650.0), path).read_text("utf-8"))


def _edited(document: Any, data: st.DataObject) -> Any:
    """The document with one thing in it replaced or removed."""
    path = data.draw(st.sampled_from(list(places(document))))
    return changed(document, path, data.draw(VALUES) if data.draw(st.booleans()) else GONE)


def _packed(document: Any, arrays: dict[str, np.ndarray]) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, document=np.array(json.dumps(document)), **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def _read_and_asked(content: bytes) -> None:
    """Load a solution and ask it for what is computed only when it is asked for."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        path.write_bytes(content)
        solution = one_line(load_solution, path)
        if not isinstance(solution, InputError):
            one_line(lambda: [solution.collisions, solution.phases, solution.transitions])


@given(data=st.data())
def test_an_edited_run(run: Run, data: st.DataObject) -> None:
    document, arrays = run
    _read_and_asked(_packed(_edited(document, data), arrays))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("events", 0, "P_N", "jaw"), None), (("events", 1, "P_N"), {"a": 1}),
        (("events", 0, "t"), "soon"), (("events", 1, "stops"), []),
        (("events", 0, "number"), [[1, 2], [3]]), (("segments", 0, "t_end"), {}),
        (("shaft", "start_angle_rad"), {}), (("shaft", "speed_rad_s"), ""),
        (("case", "speed_rpm"), 10**400), (("case", "cycles"), True),
    ],
)  # fmt: skip
def test_wrong_types_are_refused_when_they_are_read(
    run: Run, tmp_path: Path, path: tuple[Any, ...], value: object
) -> None:
    """Found by the test above: such runs were read, and failed with a traceback when asked."""
    document, arrays = run
    file = tmp_path / "wrong.npz"
    file.write_bytes(_packed(changed(document, path, value), arrays))
    with pytest.raises(InputError):
        load_solution(file)


@given(data=st.data())
def test_a_run_with_other_arrays(run: Run, data: st.DataObject) -> None:
    """Arrays of another shape, another type, or not there."""
    document, arrays = run
    name = data.draw(st.sampled_from(sorted(arrays)))
    value = arrays[name]
    others = (
        None, value.ravel(), value[..., :-1], value.astype("U8"), np.empty(0),
        np.zeros(value.shape, dtype=np.int32), np.full_like(value, np.nan),
    )  # fmt: skip
    other = others[data.draw(st.integers(0, len(others) - 1))]
    rest = {key: item for key, item in arrays.items() if key != name}
    _read_and_asked(_packed(document, rest if other is None else {**rest, name: other}))


@given(part=st.floats(0.0, 1.0), junk=st.binary(max_size=20))
def test_a_run_that_was_cut_off(run: Run, part: float, junk: bytes) -> None:
    content = _packed(*run)
    _read_and_asked(content[: int(part * len(content))] + junk)


@given(data=st.data())
def test_an_edited_case(case: Any, data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.json"
        path.write_text(json.dumps(_edited(case, data)), encoding="utf-8")
        one_line(load_case, path)


@pytest.mark.parametrize("words", ["simulate --case", "view --html page.html --solution"])
def test_a_damaged_file_on_the_command_line(here: Path, words: str) -> None:
    """Status 2, one sentence, and the file is left as it was."""
    for content in (
        b"", b"{}", b"PK\x03\x04", b"\x93NUMPY\x01\x00", b"[1, 2", b"\xff\xfe", b"null",
    ):  # fmt: skip
        Path("damaged").write_bytes(content)
        assert assert_clear([*words.split(), "damaged"], 2) == 2
        assert files(here) == {"damaged": content}


def test_deep_and_long_documents(tmp_path: Path) -> None:
    """Nesting beyond any recursion limit, numbers of many digits, names of many letters."""
    path = tmp_path / "case.json"
    for text in ("[" * 100_000, '{"a":' * 50_000, "9" * 10_000, '"' + "a" * 100_000 + '"'):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError):
            load_case(path)
