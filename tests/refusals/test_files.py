"""Models and studies with one mistake: error, evidence and status of each, and the sentences."""

from __future__ import annotations

from collections.abc import Callable
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
from tests.refusals.bases import Edits, Refusal, Row, edited, evidence, model

READ: dict[str, Callable[[str], Any]] = {
    "sweep": read_plan,
    "identify": identify.read_problem,
    "camera": identify.read_problem,
    "optimise": optimise.read_problem,
}
# Base machine or study, kind of error, and rows.
TABLES: dict[str, tuple[str, type[InputError], dict[str, Row]]] = {
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
_KNOWN: dict[tuple[str, str], Refusal] = {}


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


def refusal(base: str, row: Row, home: Path, capsys: pytest.CaptureFixture[str]) -> Refusal:
    """What is said of the model or study of a row, by the library and by a command."""
    read: Callable[[Any], Any]
    if base in READ:
        read, place, file = READ[base], home, study(base, row.edits, home)
        line = ["identify" if base == "camera" else base, file, "--out", str(home / "out")]
    else:
        read, place = load, model(base, row.edits, home)
        file, line = str(place), ["check", str(place)]
        for name, content in row.files.items():
            (place / name).write_bytes(content)
    there = sorted(home.rglob("*"))
    with pytest.raises(InputError) as caught:
        read(file)
    status = main(line)
    assert sorted(home.rglob("*")) == there
    return Refusal(caught.value, status, capsys.readouterr().err, place)


@pytest.fixture
def refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[[str, str], Refusal]:
    """The refusal of a row, by the names of its table and of itself."""

    def find(table: str, name: str) -> Refusal:
        if (table, name) not in _KNOWN:
            base, _, rows = TABLES[table]
            home = tmp_path / str(len(_KNOWN))
            home.mkdir()
            _KNOWN[table, name] = refusal(base, rows[name], home, capsys)
        return _KNOWN[table, name]

    return find


@pytest.mark.parametrize(
    ("table", "name"), [(table, name) for table, (*_, rows) in TABLES.items() for name in rows]
)
def test_a_mistake_is_refused(
    table: str, name: str, refused: Callable[[str, str], Refusal]
) -> None:
    """By an error of its kind that names place and value; the command says the same in a line."""
    _, kind, rows = TABLES[table]
    error, status, said, _ = refused(table, name)
    assert type(error) is kind
    for found, wanted in zip(evidence(error), rows[name][1:3], strict=True):
        assert wanted is ... or found == wanted
    assert (status, said) == (2, f"nipper-pin: {error.message}\n")


@pytest.mark.parametrize("table", TABLES)
def test_sentences(table: str, refused: Callable[[str, str], Refusal], words: Words) -> None:
    text = ""
    for name in TABLES[table][2]:
        found = refused(table, name)
        text += f"{name}\n    {found.error.message.replace(str(found.home), 'FOLDER')}\n"
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


def test_studies_that_are_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for base in ("sweep", "identify", "optimise"):
        with pytest.raises(ModelError) as caught:
            READ[base](str(tmp_path / "none.toml"))
        assert (caught.value.evidence["file"], caught.value.evidence["key"]) == (
            "none.toml",
            "file",
        )
        assert main([base, str(tmp_path / "none.toml")]) == 2
        assert capsys.readouterr() == ("", f"nipper-pin: {caught.value.message}\n")
