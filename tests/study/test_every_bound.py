"""Least and largest values of keys of studies, both sides of each; packages that are missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from nipper_pin.errors import InputError
from nipper_pin.study.identify.problem import problem
from nipper_pin.study.optimise.problem import problem_file
from nipper_pin.study.sweep import estimate, run, study_file
from nipper_pin.study.sweep.results import store, table


def taken(kind: Any, key: str, value: object, **others: object) -> bool:
    """Whether a table takes a value under a key."""
    try:
        found = msgspec.convert({key: value, **others}, kind)
    except msgspec.ValidationError as error:
        # What is wrong is said of this key, and no other.
        return f"$.{key}" not in str(error)
    return bool(getattr(found, key) == value)


OF_SETTING = {"speed_rpm": 650.0}


@pytest.mark.parametrize(
    ("kind", "key", "low", "high", "others"),
    [
        (study_file._CaseTable, "tolerance", 1e-13, 1e-3, {}),
        (problem_file._CaseTable, "tolerance", 1e-13, 1e-6, {}),
        (problem._CaseTable, "tolerance", 1e-13, 1e-4, {}),
        (problem._Setting, "restitution", 0.0, 1.0, OF_SETTING),
    ],
)
def test_ranges_that_hold_their_ends(
    kind: Any, key: str, low: float, high: float, others: Any
) -> None:
    for value in (low, high, 0.5 * (low + high)):
        assert taken(kind, key, value, **others)
    for value in (low * (1.0 - 1e-9) if low else -1e-300, high * (1.0 + 1e-9), -high):
        assert not taken(kind, key, value, **others)


@pytest.mark.parametrize(
    ("kind", "key", "least", "others"),
    [
        (study_file._CaseTable, "max_collisions", 1, {}),
        (study_file._SamplesTable, "count", 1, {"method": "sobol"}),
        (study_file._SamplesTable, "seed", 0, {"method": "sobol", "count": 5}),
        (study_file._ParameterTable, "points", 2, {}),
        (study_file._StudyTable, "chunk", 1, {"format": 1, "parameters": {}}),
    ],
)
def test_least_counts(kind: Any, key: str, least: int, others: Any) -> None:
    assert taken(kind, key, least, **others)
    assert taken(kind, key, least + 1, **others)
    assert not taken(kind, key, least - 1, **others)
    assert not taken(kind, key, least + 0.5, **others)


@pytest.mark.parametrize(
    ("kind", "key", "others"),
    [
        (study_file._CaseTable, "speed_rpm", {}), (study_file._CaseTable, "rest_rate", {}),
        (problem_file._CaseTable, "speed_rpm", {}), (problem_file._CaseTable, "rest_rate", {}),
        (problem._CaseTable, "rest_rate", {}), (problem._Setting, "speed_rpm", {}),
    ],
)  # fmt: skip
def test_values_above_zero(kind: Any, key: str, others: Any) -> None:
    assert taken(kind, key, 1e-300, **others)
    assert not taken(kind, key, 0.0, **others)
    assert not taken(kind, key, -1.0, **others)


def test_words_of_a_sweep() -> None:
    """Formats, windows, drives, scales and methods that there are, and their defaults."""
    case, parameter = study_file._CaseTable, study_file._ParameterTable
    for kind, key, words, others in (
        (case, "window", ("transition",), {}), (case, "drive", ("held", "inertial"), {}),
        (parameter, "scale", ("linear", "log"), {}),
    ):  # fmt: skip
        for word in words:
            assert taken(kind, key, word, **others)
        for word in ("", "other", f"{words[0]}_"):
            assert not taken(kind, key, word, **others)
    plain = msgspec.convert({}, case)
    assert (plain.window, plain.drive, plain.speed_rpm, plain.rest_rate) == (
        "transition", "held", None, None,
    )  # fmt: skip
    assert (plain.tolerance, plain.max_collisions) == (1e-10, 256)
    one = msgspec.convert({}, parameter)
    assert (one.values, one.low, one.high, one.points, one.scale) == (
        (),
        None,
        None,
        None,
        "linear",
    )
    whole = msgspec.convert({"format": 1, "parameters": {}}, study_file._StudyTable)
    assert (whole.title, whole.model, whole.chunk, whole.quantities) == ("", "e62", None, None)
    assert (whole.set, whole.samples, whole.case) == ({}, None, plain)
    for kind in (study_file._StudyTable, problem_file._FileTable):
        assert not taken(kind, "format", 2, parameters={})


# What runs of a sweep refuse.


@pytest.fixture(name="bare")
def without_pyarrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nipper_pin.extras.installed", lambda name: name != "pyarrow")


@pytest.mark.usefixtures("bare")
def test_sweeps_without_pyarrow(tmp_path: Path) -> None:
    plan: Any = SimpleNamespace()
    for act in (
        store.need_pyarrow,
        lambda: estimate.estimate(plan),
        lambda: table.read_sweep(tmp_path),
        lambda: run.run_sweep(plan, tmp_path / "new"),
    ):
        with pytest.raises(InputError, match="sweeps needs pyarrow, which is not") as caught:
            act()
        assert caught.value.evidence == {"extra": "sweep", "packages": ("pyarrow",)}
    assert list(tmp_path.iterdir()) == []


def test_workers_of_a_sweep(tmp_path: Path) -> None:
    plan: Any = SimpleNamespace()
    for act in (
        lambda: run.run_sweep(plan, tmp_path, workers=0),
        lambda: estimate.estimate(plan, workers=0),
    ):
        with pytest.raises(InputError, match="workers = 0 cannot be used: a whole") as caught:
            act()
        assert caught.value.evidence["key"] == "workers"
    with pytest.raises(InputError, match="and --scheduler has its own") as caught:
        run.run_sweep(plan, tmp_path, workers=1, scheduler="tcp://a")
    assert caught.value.evidence == {"workers": 1, "scheduler": "tcp://a"}


@pytest.mark.parametrize("chunks", [None, (1, 2)])
def test_a_sweep_and_its_report(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, chunks: Any
) -> None:
    """Alone in the folder but for ranges; what was found is what was not computed."""
    asked: list[Any] = []

    class Store:
        def __init__(self, folder: Path, plan: Any) -> None:
            asked.append((folder, plan))
            self.plan = SimpleNamespace(chunks=lambda: "all")

    class Run:
        total, computed, chunks, count = 22, 9, 4, 3
        damaged = {7: "7.parquet", 9: "9.parquet"}  # noqa: RUF012
        tally = SimpleNamespace(rows=22)
        extremes = SimpleNamespace(smallest="it")

        def __init__(self, *words: Any) -> None:
            asked.append(words[1:])

        def complete(self) -> None:
            asked.append("complete")

    @contextmanager
    def alone(folder: Path, *, shared: bool) -> Iterator[None]:
        asked.append((folder, shared))
        yield
        asked.append("left")

    clock = iter([100.0, 103.5])
    monkeypatch.setattr(run, "alone_in", alone)
    monkeypatch.setattr(run, "Store", Store)
    monkeypatch.setattr(run, "_Run", Run)
    monkeypatch.setattr(run, "chosen", lambda *words: words)
    monkeypatch.setattr(run.SweepReport, "check", lambda _: asked.append("checked"))
    monkeypatch.setattr(run.time, "perf_counter", lambda: next(clock))
    plan: Any = "plan"
    progress: Any = "told"
    found = run.run_sweep(
        plan, tmp_path, scheduler="tcp://a" if chunks else None, chunks=chunks, progress=progress
    )
    assert asked == [
        (tmp_path, chunks is not None), (tmp_path, "plan"),
        (None, "tcp://a" if chunks else None, ("all", chunks), "told"), "complete", "left",
        "checked",
    ]  # fmt: skip
    assert (found.folder, found.scenarios, found.found, found.computed) == (tmp_path, 22, 13, 9)
    assert (found.chunks, found.damaged) == (4, ("7.parquet", "9.parquet"))
    assert (found.workers, found.wall_s) == ("tcp://a" if chunks else 3, 3.5)
    assert found.tally.rows == 22
    assert found.extremes is Run.extremes
