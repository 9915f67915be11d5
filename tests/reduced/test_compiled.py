"""Machine code on disk: kept where it can be, compiled anew if it is cut off or of other sources.

A small function is compiled by the decorator of the engine, each time from a module that is loaded
anew, as another process would. Whether a kept file was used is what numba counts itself.
"""

from __future__ import annotations

import gc
import importlib.util
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core import config
from numba.core.errors import TypingError

from nipper_pin import Mechanism, turn_table
from nipper_pin.reduced import ReducedModel, transitions
from nipper_pin.reduced.kernels import compiled as compiling
from nipper_pin.reduced.kernels.kernel import run

SOURCE = """
import numpy as np
from nipper_pin.reduced.kernels.compiled import compiled, part
@part
def scaled(row, x):
    return row[0] * x
@compiled
def triple(x):
    return scaled(np.full(1, 3.0), x)
"""


def loaded(folder: Path) -> Any:
    """The function, as a process finds it that has not compiled it yet."""
    file = folder / "function.py"
    if not file.exists():
        file.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("function", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.triple


def used_kept_code(folder: Path) -> bool:
    triple = loaded(folder)
    assert triple(14.0) == 42.0
    return sum(triple.stats.cache_hits.values()) == 1


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "kept"
    monkeypatch.setattr(config, "CACHE_DIR", str(folder))
    assert not used_kept_code(tmp_path)
    assert used_kept_code(tmp_path)
    return folder


@pytest.mark.parametrize("argument", [14.0, "no number"])
@pytest.mark.parametrize("collecting", [True, False])
def test_garbage_is_collected_as_before(tmp_path: Path, collecting: bool, argument: Any) -> None:
    """After a compilation, and after one that fails."""
    before = gc.isenabled()
    try:
        (gc.enable if collecting else gc.disable)()
        with suppress(TypingError):
            loaded(tmp_path)(argument)
        assert gc.isenabled() == collecting
    finally:
        (gc.enable if before else gc.disable)()


@pytest.mark.parametrize("kind", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", ["cut off", "empty", "other bytes"])
def test_damaged_files_count_as_missing(kept: Path, tmp_path: Path, kind: str, damage: str) -> None:
    (file,) = kept.rglob(f"*.{kind}")
    content = file.read_bytes()
    file.write_bytes({
        "cut off": content[:100], "empty": b"", "other bytes": b"\x80\x04K.",
    }[damage])  # fmt: skip
    assert not used_kept_code(tmp_path)
    assert used_kept_code(tmp_path)


@pytest.mark.usefixtures("kept")
def test_code_of_other_sources_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "_sources", lambda: "sources with another constant")
    assert not used_kept_code(tmp_path)
    assert used_kept_code(tmp_path)


def test_every_source_and_tolerance_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The digest changes with one byte of any file that is compiled in, and of no other."""
    found = compiling._sources.__wrapped__()
    read, seen = Path.read_bytes, []

    def changed(file: Path) -> bytes:
        seen.append(file)
        return read(file) + b"#" * (file.name == name)

    monkeypatch.setattr(Path, "read_bytes", changed)
    kernels = Path(compiling.__file__).parent
    constants = re.compile(r"^from \.\.\.tolerances\.(\w+) import", re.MULTILINE)
    code = [file.read_text(encoding="utf-8") for file in kernels.glob("*.py")]
    used = {f"{name}.py" for text in code for name in constants.findall(text)}
    assert len(used) > 1
    for name in ("kernel.py", "flight.py", *used):
        assert compiling._sources.__wrapped__() != found
        assert name in {file.name for file in seen}
    name = "study.py"
    assert compiling._sources.__wrapped__() == found


def test_without_a_folder_that_can_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A read-only installation for a user without a home: it says so once, and computes."""
    monkeypatch.setattr(config, "CACHE_DIR", "")
    monkeypatch.setattr(config, "CACHE_LOCATOR_CLASSES", "UserProvidedCacheLocator")
    compiling._tell_that_nothing_is_kept.cache_clear()
    with pytest.warns(RuntimeWarning, match="set NUMBA_CACHE_DIR"):
        loaded(tmp_path)
    # A second warning would be an error here.
    assert not used_kept_code(tmp_path)


def test_a_folder_that_stops_taking_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "kept"
    monkeypatch.setattr(config, "CACHE_DIR", str(folder))
    triple = loaded(tmp_path)
    (home,) = folder.iterdir()
    home.rmdir()
    home.write_text("a file where the folder was")
    assert triple(14.0) == 42.0


def test_one_is_told_of_the_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where code is compiled, not where it is kept, on a terminal or not."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "kept"))
    told = []
    for terminal, folder in ((False, "a"), (True, "b"), (True, "c"), (True, "c")):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        (tmp_path / folder).mkdir(exist_ok=True)
        compiling._tell_that_it_takes_time.cache_clear()
        assert loaded(tmp_path / folder)(14.0) == 42.0
        told.append(capsys.readouterr().err.count("compiling the reduced engine"))
    assert told == [1, 1, 1, 0]


def test_references_are_as_many_after_a_call_as_before(model: ReducedModel) -> None:
    """Of arrays that compiled code reads, without counting them, and of those that it wrote."""

    def counted() -> list[int]:
        read = (*model.charts, *model.arrival.charts)
        return [sys.getrefcount(item) for item in read if isinstance(item, np.ndarray)]

    before = counted()
    for _ in range(20):
        found = transitions(model, speed_rpm=[450.0, 650.0], assumed=False)
        written = sys.getrefcount(found.table)
        assert written == 2
    assert found.premise.tolist() == [1, 1]
    assert counted() == before


def test_all_machine_code_is_kept_so() -> None:
    """What is true of a small function is true of transitions, turns and searches."""
    package = Path(compiling.__file__).parents[2]
    users = {
        file.relative_to(package).as_posix()
        for room in ("reduced", "study")
        for file in (package / room).rglob("*.py")
        if re.search(r"^\s*(import|from) numba", file.read_text(encoding="utf-8"), re.MULTILINE)
    }
    assert users == {"reduced/kernels/compiled.py", "reduced/kernels/in_memory.py"}


def test_other_columns_of_a_table_compile_nothing(model: ReducedModel, e62: Mechanism) -> None:
    # Compiled code of a kind of arrays takes seconds; numbers and columns have to be of one kind.
    two = np.array([640.0, 650.0])
    held = np.frombuffer(two.tobytes())
    cases: list[dict[str, Any]] = [
        {"speed_rpm": 650.0},
        {"speed_rpm": two},
        {"speed_rpm": held, "restitution": held / 2000.0},
        {"speed_rpm": 650.0, "restitution": np.linspace(0.1, 0.3, 6)[::3]},
    ]
    transitions(model, **cases[0])
    before = len(run.signatures)
    for given in cases:
        assert transitions(model, **given).premise.all()
        turn_table(e62, engine="reduced", turns=1, **given)
    assert len(run.signatures) == before


def test_compiled_functions_divide_by_zero_as_numpy_does(tmp_path: Path) -> None:
    (tmp_path / "function.py").write_text(SOURCE.replace("row[0] * x", "x / 0.0"))
    assert loaded(tmp_path)(1.0) == np.inf
