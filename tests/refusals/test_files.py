"""Models and studies with one mistake: kinds of errors, and sentences that quote their evidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from snapshots import Words

from nipper_pin import AssemblyError, InputError, ModelError, UnknownNameError, load
from nipper_pin.cli import main
from nipper_pin.study import identify, optimise
from nipper_pin.study.sweep import read_plan
from tests.refusals import descriptions as toml
from tests.refusals import studies
from tests.refusals import urdfs as urdf
from tests.refusals.bases import Edits, Row, edited, model

READ: dict[str, Callable[[str], Any]] = {
    "sweep": read_plan,
    "identify": identify.read_problem,
    "camera": identify.read_problem,
    "optimise": optimise.read_problem,
}
# Base machine or study, kind of error, and rows.
TABLES: dict[str, tuple[str, type[InputError], Mapping[str, Edits | Row]]] = {
    "values": ("e62", ModelError, toml.VALUES),
    "closures": ("e62", AssemblyError, toml.CLOSURES),
    "names": ("e62", UnknownNameError, toml.NAMES),
    "springs": ("small", ModelError, toml.SPRINGS),
    "drives": ("small", ModelError, toml.DRIVES),
    "small_names": ("small", UnknownNameError, toml.SMALL_NAMES),
    "starts_and_stops": ("small", ModelError, toml.STARTS_AND_STOPS),
    "apart": ("small", AssemblyError, toml.APART),
    "urdfs": ("e62", ModelError, urdf.URDFS),
    "urdf_names": ("e62", UnknownNameError, urdf.URDF_NAMES),
    "small_urdfs": ("small", ModelError, urdf.SMALL_URDFS),
    "hostile": ("e62", ModelError, urdf.HOSTILE),
    "files": ("small", ModelError, toml.FILES),
    "sweep_values": ("sweep", ModelError, studies.SWEEP_VALUES),
    "sweep_keys": ("sweep", InputError, studies.SWEEP_KEYS),
    "sweep_names": ("sweep", UnknownNameError, studies.SWEEP_NAMES),
    "fit_values": ("identify", ModelError, studies.FIT_VALUES),
    "fit_keys": ("identify", InputError, studies.FIT_KEYS),
    "fit_names": ("identify", UnknownNameError, studies.FIT_NAMES),
    "seen": ("identify", InputError, studies.SEEN_KEYS),
    "camera": ("camera", InputError, studies.CAMERA_KEYS),
    "camera_names": ("camera", UnknownNameError, studies.CAMERA_NAMES),
    "design_values": ("optimise", ModelError, studies.DESIGN_VALUES),
    "design_keys": ("optimise", InputError, studies.DESIGN_KEYS),
    "design_names": ("optimise", UnknownNameError, studies.DESIGN_NAMES),
}


def study(base: str, edits: Edits, home: Path) -> str:
    """Write the files of a study, and the model beside it that it names; return the first file."""
    texts = dict(studies.BASES[base])
    first = home / next(iter(texts))
    if isinstance(edits, str):
        texts[first.name] = edits
    else:
        texts = edited(texts, edits)
    for name, text in texts.items():
        (home / name).write_text(text, encoding="utf-8")
    for name, (machine, changes) in studies.BESIDE.items():
        if f'model = "{name}"' in texts[first.name]:
            model(machine, changes, home).rename(home / name)
    return str(first)


def written(base: str, row: Edits | Row, home: Path) -> tuple[Callable[[Any], Any], list[str]]:
    """What reads a model or study with a mistake, and a command that does; its place is last."""
    edits, files = row if isinstance(row, Row) else (row, {})
    if base in READ:
        command = "identify" if base == "camera" else base
        return READ[base], [command, "--out", str(home / "out"), study(base, edits, home)]
    place = model(base, edits, home)
    for name, content in files.items():
        (place / name).write_bytes(content)
    return load, ["check", str(place)]


def refusal(read: Callable[[Any], Any], file: str) -> InputError | None:
    try:
        read(file)
    except InputError as error:
        return error
    return None


@pytest.mark.parametrize("table", TABLES)
def test_sentences(
    table: str, tmp_path: Path, words: Words, capsys: pytest.CaptureFixture[str]
) -> None:
    """Errors of one kind; the command says the same in a line, and writes nothing."""
    base, kind, rows = TABLES[table]
    text = ""
    for number, (name, row) in enumerate(rows.items()):
        home = tmp_path / str(number)
        home.mkdir()
        folder = home if base in READ else home / base
        read, line = written(base, row, home)
        error = refusal(read, line[-1])
        assert error is None or type(error) is kind, name
        message = "nothing" if error is None else error.message
        text += f"{name}\n    {message}\n".replace(str(folder), "FOLDER")
        if number == 0:
            there = sorted(home.rglob("*"))
            assert main(line) == 2
            assert capsys.readouterr() == ("", f"nipper-pin: {message}\n")
            assert sorted(home.rglob("*")) == there
    words(text)


@pytest.mark.parametrize("edits", [*toml.TAKEN.values(), *urdf.TAKEN.values()],
                         ids=[*toml.TAKEN, *urdf.TAKEN])  # fmt: skip
def test_values_of_models_at_their_bounds_are_taken(
    edits: str | tuple[str, str], tmp_path: Path
) -> None:
    assert load(model("small", edits, tmp_path)).name == "small"


@pytest.mark.parametrize(
    ("base", "name"), [(base, name) for base, rows in studies.TAKEN.items() for name in rows]
)
def test_values_of_studies_at_their_bounds_are_taken(base: str, name: str, tmp_path: Path) -> None:
    assert READ[base](study(base, studies.TAKEN[base][name], tmp_path)) is not None


@pytest.mark.parametrize("base", ["sweep", "identify", "optimise"])
def test_studies_that_are_not_there(base: str, capsys: pytest.CaptureFixture[str]) -> None:
    error = refusal(READ[base], "none.toml")
    assert isinstance(error, ModelError)
    assert (error.evidence["file"], error.evidence["key"]) == ("none.toml", "file")
    assert main([base, "none.toml"]) == 2
    assert capsys.readouterr() == ("", f"nipper-pin: {error.message}\n")
