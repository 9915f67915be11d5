"""Machine code that is kept on disk: which of it is forgotten."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from nipper_pin.reduced.kernels import compiled


def test_code_that_is_older_than_any_source_of_its_room_is_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the file in question alone; what is as old as the newest source stays."""
    monkeypatch.setattr(compiled, "_TOLERANCES", tmp_path)
    room, cache = tmp_path / "room", tmp_path / "cache"
    room.mkdir()
    cache.mkdir()
    for name, changed in (("a.py", 100), ("b.py", 200), ("note.txt", 900)):
        (room / name).write_text("", encoding="utf-8")
        os.utime(room / name, (changed, changed))
    kept = {
        "a.f-3.py312.nbi": (150, False), "a.f-3.py312.1.nbc": (199, False),
        "a.g-9.py312.nbi": (200, True), "a.h-9.py312.nbc": (300, True),
        "b.f-3.py312.nbi": (150, True), "a.f-3.py312.txt": (150, True),
    }  # fmt: skip
    for name, (changed, _) in kept.items():
        (cache / name).write_text("", encoding="utf-8")
        os.utime(cache / name, (changed, changed))
    monkeypatch.setattr(compiled, "_folders", {cache})
    compiled.forget_stale(str(room / "a.py"))
    assert {path.name for path in cache.iterdir()} == {
        name for name, (_, stays) in kept.items() if stays
    }


@pytest.mark.parametrize(("changed", "stays"), [(150, False), (100, True)])
def test_code_that_is_older_than_the_tolerances_is_forgotten(
    changed: int, stays: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their values are compiled into it, and they are no file of its room."""
    assert (compiled._TOLERANCES / "reduced.py").is_file()
    source, kept = tmp_path / "room/a.py", tmp_path / "cache/a.f-3.py312.nbi"
    constants = tmp_path / "tolerances/reduced.py"
    for file, time in ((source, 100), (kept, 100), (constants, changed)):
        file.parent.mkdir(exist_ok=True)
        file.touch()
        os.utime(file, (time, time))
    monkeypatch.setattr(compiled, "_folders", {kept.parent})
    monkeypatch.setattr(compiled, "_TOLERANCES", constants.parent)
    compiled.forget_stale(str(source))
    assert kept.exists() is stays


def test_compiled_functions_divide_by_zero_as_numpy_does(tmp_path: Path) -> None:
    """And their machine code lies in a folder that is known."""
    source = tmp_path / "quotient.py"
    source.write_text("def quotient(a, b):\n    return a / b\n", encoding="utf-8")
    names: dict[str, object] = {}
    exec(compile(source.read_text(encoding="utf-8"), str(source), "exec"), names)
    function = compiled.compiled(names["quotient"])  # type: ignore[type-var]
    assert function(1.0, 0.0) == np.inf
    assert function(3.0, 2.0) == 1.5
    folder = Path(str(function.stats.cache_path))  # type: ignore[attr-defined]
    assert folder in compiled._folders
    assert list(folder.glob("quotient.quotient-*.nbi"))
