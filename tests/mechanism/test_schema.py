"""The schema in the documents and the loader say the same of the same data."""

from __future__ import annotations

import itertools
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from nipper_pin import Drawing, InputError, ModelError
from nipper_pin.mechanism import find_model
from nipper_pin.mechanism.drives import DriveTable, register_drive
from nipper_pin.mechanism.files.describe import describe
from nipper_pin.mechanism.files.schema import drawing_schema, model_schema, schema_text
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.mechanism.skeleton import write_skeleton
from tests.refusals.bases import places

ROOT = Path(__file__).resolve().parents[2]

SCHEMA, DRAWING = model_schema(), drawing_schema()

VALID = jsonschema.Draft202012Validator(SCHEMA)


def test_document_is_the_schema_of_the_structs() -> None:
    """docs/model.schema.json is what the structs give; after a change of them, write it anew:

    from nipper_pin.mechanism.files.schema import schema_text; print(schema_text("model"), end="")
    and with "drawing" docs/drawing.schema.json.
    """
    for name in ("model", "drawing"):
        text = schema_text(name)
        assert (ROOT / "docs" / f"{name}.schema.json").read_text(encoding="utf-8") == text
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert json.loads(schema_text("model")) == SCHEMA
    for path in ROOT.glob("models/**/*.toml"):
        VALID.validate(tomllib.loads(path.read_text(encoding="utf-8")))


def test_every_key_says_what_it_means() -> None:
    """An editor shows a sentence for each key; one that the docstrings forgot would show none."""
    for name, table in [*SCHEMA["$defs"].items(), *DRAWING["$defs"].items()]:
        assert table["description"].endswith("."), name
        for key, value in table["properties"].items():
            assert value["description"].endswith("."), f"{name}.{key}"
            assert "\n" not in value["description"]
    guide = SCHEMA["$defs"]["OscillatingGuideDrive"]["properties"]
    assert "[mm]" in guide["crank_radius_mm"]["description"]
    # Of a base of the struct, not of the struct itself.
    assert "[Hz]" in guide["shaft_frequency_hz"]["description"]


def test_tables_that_are_no_drive_law() -> None:
    """Neither another class nor a second law of one name."""

    class SecondCam(DriveTable, frozen=True, kw_only=True, tag="cam"):
        """A law of this name exists."""

    no_table: Any = dict
    with pytest.raises(InputError, match="is no table of a drive law: derive it from DriveTable"):
        register_drive(no_table)
    with pytest.raises(InputError, match=r"a drive law 'cam' exists already \(CamDrive\)"):
        register_drive(SecondCam)


def test_classes_of_one_name() -> None:
    """The schema goes by names of classes, in all rooms: none pushes another one out."""
    for name in ("CamDrive", "OrificeForce", "StopDescription"):
        kind = type(DriveTable)(
            name, (DriveTable,), {"__module__": __name__}, frozen=True, kw_only=True, tag="lifter"
        )
        with pytest.raises(InputError, match=f"a class {name} exists already"):
            register_drive(kind)
    keys = model_schema()["$defs"]["Description"]["properties"]
    laws = keys["drives"]["additionalProperties"]["anyOf"]
    assert {"$ref": "#/$defs/CamDrive"} in laws


MODELS = ("e62", "hanging_pendulum")

WRONG: tuple[Any, ...] = (
    [], {}, "", "odd", -1.0, True, 3, [[]], {"law": "odd"}, 0.0, 2.5, 40.0,
)  # fmt: skip


def documents(name: str) -> dict[str, Any]:
    """The model's TOML."""
    (file,) = find_model(name).glob("*.toml")
    return tomllib.loads(file.read_text())


def spoiled(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The document with a key left out, or one added, everywhere, and each value four times wrong.

    Which four of the wrong values goes round, so that all of them come to all kinds of places.
    """
    wrong = itertools.cycle(WRONG)
    for path in list(places(document)):
        parent: Any = document
        for step in path[:-1]:
            parent = parent[step]
        right = parent[path[-1]]
        for parent[path[-1]] in itertools.islice(wrong, 4):
            yield document
        del parent[path[-1]]
        if isinstance(parent, dict):
            yield document
            parent["odd"] = 1.0
            yield document
            del parent["odd"]
            parent[path[-1]] = right
        else:
            yield document
            parent.insert(path[-1], right)


def loads(document: dict[str, Any]) -> bool | None:
    """None where 3.0 and its like are refused, which are whole numbers to a schema."""
    try:
        describe(document, "model.toml")
    except ModelError as error:
        return None if "a whole number" in error.message else False
    return True


@pytest.mark.parametrize("model", MODELS)
def test_the_schema_marks_what_the_loader_refuses(model: str) -> None:
    """For an editor that has it; what is said, and of which place, stands in `refusals`."""
    refused = 0
    for document in itertools.islice(spoiled(documents(model)), 0, None, 13):
        loaded = loads(document)
        assert loaded is None or VALID.is_valid(document) == loaded
        refused += loaded is False
    assert refused > 20


def test_the_schema_of_a_drawing_marks_no_drawing_that_is_read(tmp_path: Path) -> None:
    """All of the gallery; and of a spoiled press none that still makes a machine."""
    valid = jsonschema.Draft202012Validator(DRAWING)
    jsonschema.Draft202012Validator.check_schema(DRAWING)
    for name in GALLERY:
        assert valid.is_valid(drawn(name).tables)
    press: Any = Drawing.load(write_skeleton(tmp_path / "press.toml")).tables
    press = json.loads(json.dumps(press))
    counts = {True: 0, False: 0}
    for document in itertools.islice(spoiled(press), 0, None, 7):
        try:
            Drawing(document).mechanism()
        except InputError:
            counts[valid.is_valid(document)] += 1
        else:
            assert valid.is_valid(document)
    # What it cannot know are names that are not there, and loops that do not close.
    assert counts[False] > 2 * counts[True] > 0
