"""Models with one mistake: error, evidence and status of each, and the reviewed sentences."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from snapshots import Words

from nipper_pin import AssemblyError, InputError, ModelError, UnknownNameError, load
from tests.refusals import descriptions as toml
from tests.refusals import urdfs as urdf
from tests.refusals.bases import Refusal, Row, evidence, model, refusal

# Base machine, kind of error, and rows.
TABLES: dict[str, tuple[str, type[InputError], dict[str, Row]]] = {
    "values": ("e62", ModelError, toml.VALUES),
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
}
_KNOWN: dict[tuple[str, str], Refusal] = {}


@pytest.fixture
def refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[[str, str], Refusal]:
    """The refusal of a row, by the names of its table and of itself."""

    def find(table: str, name: str) -> Refusal:
        if (table, name) not in _KNOWN:
            base, _, rows = TABLES[table]
            folder = tmp_path / str(len(_KNOWN))
            folder.mkdir()
            _KNOWN[table, name] = refusal(base, rows[name], folder, capsys)
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
def test_values_at_their_bounds_are_taken(edits: str | tuple[str, str], tmp_path: Path) -> None:
    assert load(model("small", edits, tmp_path)).name == "small"
