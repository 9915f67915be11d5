"""Models and studies with one mistake: kinds of errors, and sentences that quote their evidence.

The mistakes stand in the reviewed texts themselves, each above its sentence: a new one is written
there, and `make snapshots` adds what is said of it. What is taken after all has "nothing" there.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from snapshots import Words, blocks, without_the_machine

from nipper_pin import AssemblyError, InputError, ModelError, UnknownNameError, load
from nipper_pin.cli import main
from nipper_pin.study import identify, optimise
from nipper_pin.study.sweep import read_plan
from tests.refusals.bases import BESIDE, STUDIES, Edits, edited, model, right
from tests.refusals.hostile import HOSTILE

READ: dict[str, Callable[[str], Any]] = {
    "sweep": read_plan,
    "identify": identify.read_problem,
    "camera": identify.read_problem,
    "optimise": optimise.read_problem,
}
# By reviewed text the base machine or study, and the kind of error.
TABLES: dict[str, tuple[str, type[InputError]]] = {
    "values": ("e62", ModelError), "closures": ("e62", AssemblyError),
    "names": ("e62", UnknownNameError), "springs": ("small", ModelError),
    "drives": ("small", ModelError), "small_names": ("small", UnknownNameError),
    "starts_and_stops": ("small", ModelError), "apart": ("small", AssemblyError),
    "urdfs": ("e62", ModelError), "urdf_names": ("e62", UnknownNameError),
    "small_urdfs": ("small", ModelError), "hostile": ("e62", ModelError),
    "files": ("small with rows", ModelError),
    "sweep_values": ("sweep", ModelError), "sweep_keys": ("sweep", InputError),
    "sweep_names": ("sweep", UnknownNameError), "fit_values": ("identify", ModelError),
    "fit_keys": ("identify", InputError), "fit_names": ("identify", UnknownNameError),
    "seen": ("identify", InputError), "camera": ("camera", InputError),
    "camera_names": ("camera", UnknownNameError), "design_values": ("optimise", ModelError),
    "design_keys": ("optimise", InputError), "design_names": ("optimise", UnknownNameError),
}  # fmt: skip


def study(base: str, edits: Edits, home: Path) -> str:
    """Write the files of a study, and the model beside it that it names; return the first file."""
    texts = {name.replace("camera", "seen"): right(name) for name in STUDIES[base]}
    first = home / STUDIES[base][0]
    texts = {**texts, first.name: edits[0]} if len(edits) == 1 else edited(texts, edits)
    for name, text in texts.items():
        (home / name).write_text(text, encoding="utf-8")
    for name, (machine, changes) in BESIDE.items():
        if f'model = "{name}"' in texts[first.name]:
            model(machine, changes, home).rename(home / name)
    return str(first)


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
    base, kind = TABLES[table]
    reviewed, text = blocks(__file__, f"test_sentences[{table}]"), ""
    hostile = HOSTILE.get(table, {})
    assert {item.name for item in reviewed if not item.edits} == hostile.keys()
    for number, item in enumerate(reviewed):
        home = tmp_path / str(number)
        home.mkdir()
        edits, files = (item.edits, {}) if item.edits else hostile[item.name]
        if base in READ:
            read, place, folder = READ[base], study(base, edits, home), home
            line = ["identify" if base == "camera" else base, "--out", str(home / "out"), place]
        else:
            folder = model(base, edits, home)
            read, line = load, ["check", str(folder)]
        for name, content in files.items():
            (folder / name).write_bytes(content)
        error = refusal(read, line[-1])
        assert error is None or type(error) is kind, item.name
        message = "nothing" if error is None else error.message
        said = without_the_machine(message.replace(str(folder), "FOLDER"))
        text += f"{item.text}    {said}\n"
        if number == 0:
            there = sorted(home.rglob("*"))
            assert main(line) == 2
            assert capsys.readouterr() == ("", f"nipper-pin: {message}\n")
            assert sorted(home.rglob("*")) == there
    words(text, masked=False)


@pytest.mark.parametrize("base", ["sweep", "identify", "optimise"])
def test_studies_that_are_not_there(base: str, capsys: pytest.CaptureFixture[str]) -> None:
    error = refusal(READ[base], "none.toml")
    assert error.evidence["file"] == "none.toml"
    assert main([base, "none.toml"]) == 2
    assert capsys.readouterr() == ("", f"nipper-pin: {error.message}\n")
