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
    NipperError,
    load,
    load_case,
    load_solution,
    save,
    save_case,
    simulate,
)


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("stored")


@pytest.fixture(scope="module")
def archive(home: Path) -> dict[str, np.ndarray]:
    """Arrays of a small stored run, its document among them."""
    path = save(simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=2)), home / "run.npz")
    with np.load(path, allow_pickle=False) as stored:
        return {name: stored[name] for name in stored.files}


@pytest.fixture(scope="module")
def stored_case(home: Path) -> dict[str, Any]:
    path = save_case(load("e62"), Case(speed_rpm=650.0), home / "case.json")
    document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return document


def _edited(document: Any, data: st.DataObject) -> Any:
    """The document with one thing in it replaced or removed."""
    path = data.draw(st.sampled_from(list(places(document))))
    return changed(document, path, data.draw(VALUES) if data.draw(st.booleans()) else GONE)


def _packed(document: Any, arrays: dict[str, np.ndarray]) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, document=np.array(json.dumps(document)), **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def _read_and_asked(content: bytes) -> None:
    """Load a solution and ask it for everything that is computed only when it is asked for."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        path.write_bytes(content)
        solution = one_line(load_solution, path)
        if isinstance(solution, InputError):
            return
        try:
            assert solution.collisions is not None
            assert solution.phases is not None
            assert solution.transitions is not None
        except NipperError:
            return


@given(st.data())
def test_an_edited_run(archive: dict[str, np.ndarray], data: st.DataObject) -> None:
    arrays = {name: value for name, value in archive.items() if name != "document"}
    _read_and_asked(_packed(_edited(json.loads(str(archive["document"])), data), arrays))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("events", 0, "P_N", "jaw"), None),
        (("events", 1, "P_N"), {"a": 1}),
        (("events", 0, "t"), "soon"),
        (("events", 1, "stops"), []),
        (("events", 0, "number"), [[1, 2], [3]]),
        (("segments", 0, "t_end"), {}),
        (("shaft", "start_angle_rad"), {}),
        (("shaft", "speed_rad_s"), ""),
        (("case", "speed_rpm"), 10**400),
        (("case", "cycles"), True),
    ],
)
def test_wrong_types_are_refused_when_they_are_read(
    archive: dict[str, np.ndarray], home: Path, path: tuple[Any, ...], value: object
) -> None:
    """Found by the test above: such runs were read, and failed with a traceback when asked."""
    document = changed(json.loads(str(archive["document"])), path, value)
    arrays = {name: item for name, item in archive.items() if name != "document"}
    file = home / "wrong.npz"
    file.write_bytes(_packed(document, arrays))
    with pytest.raises(InputError):
        load_solution(file)


@given(st.data())
def test_a_run_with_other_arrays(archive: dict[str, np.ndarray], data: st.DataObject) -> None:
    """Arrays of another shape, another type, or not there."""
    arrays = {name: value for name, value in archive.items() if name != "document"}
    name = data.draw(st.sampled_from(sorted(arrays)))
    change = data.draw(st.sampled_from(["gone", "flat", "short", "text", "whole", "nan", "empty"]))
    value = arrays.pop(name)
    other = {
        "flat": value.ravel(),
        "short": value[..., :-1],
        "text": value.astype("U8"),
        "whole": np.zeros(value.shape, dtype=np.int32),
        "nan": np.full_like(value, np.nan),
        "empty": np.empty(0),
    }
    if change != "gone":
        arrays[name] = other[change]
    _read_and_asked(_packed(json.loads(str(archive["document"])), arrays))


@given(st.floats(0.0, 1.0), st.binary(max_size=20))
def test_a_run_that_was_cut_off(archive: dict[str, np.ndarray], part: float, junk: bytes) -> None:
    arrays = {name: value for name, value in archive.items() if name != "document"}
    content = _packed(json.loads(str(archive["document"])), arrays)
    _read_and_asked(content[: int(part * len(content))] + junk)


@given(st.data())
def test_an_edited_case(stored_case: dict[str, Any], data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.json"
        path.write_text(json.dumps(_edited(stored_case, data)), encoding="utf-8")
        one_line(load_case, path)


@pytest.mark.parametrize("command", ["--case", "--solution"])
def test_a_damaged_file_on_the_command_line(tmp_path: Path, command: str) -> None:
    """Status 2, one sentence, and the file is left as it was."""
    path = tmp_path / "damaged"
    verb = "simulate" if command == "--case" else "view"
    for content in (
        b"",
        b"{}",
        b"PK\x03\x04",
        b"\x93NUMPY\x01\x00",
        b"[1, 2",
        b"\xff\xfe",
        b"null",
    ):
        path.write_bytes(content)
        html = ["--html", str(tmp_path / "page.html")] if verb == "view" else []
        assert assert_clear([verb, command, str(path), *html], 2) == 2
        assert files(tmp_path) == {"damaged": content}


def test_deep_and_long_documents(tmp_path: Path) -> None:
    """Nesting beyond any recursion limit, numbers of many digits, names of many letters."""
    path = tmp_path / "case.json"
    for text in ("[" * 100_000, '{"a":' * 50_000, "9" * 10_000, '"' + "a" * 100_000 + '"'):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError):
            load_case(path)
