"""Where data do not fit their tables, held against what the converter says of the same data."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from nipper_pin.mechanism import find_model
from nipper_pin.mechanism.files import first_refusal
from nipper_pin.mechanism.files.description import Description

MODELS = ("e62", "hanging_pendulum")
WRONG: tuple[Any, ...] = ([], {}, "", "odd", -1.0, True, 3, [[]], {"law": "odd"})


def documents(name: str) -> dict[str, Any]:
    """The model's TOML."""
    (file,) = find_model(name).glob("*.toml")
    return tomllib.loads(file.read_text())


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place in a document."""
    members = value.items() if isinstance(value, dict) else ()
    members = enumerate(value) if isinstance(value, list) else members
    for step, item in members:
        yield (*path, step)
        yield from places(item, (*path, step))


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


def said(error: str) -> tuple[str, str]:
    """Place, as a pattern, and key that the converter names."""
    text, _, place = error.partition(" - at `$")
    key = re.search(r"field `([^`]+)`", text)
    pattern = re.escape(place.rstrip("`")).replace(re.escape("[...]"), r"\..+")
    return pattern.removeprefix(r"\."), key[1] if key else ""


def refusal_of_the_converter(document: dict[str, Any]) -> str | None:
    """Its message; None if it takes the document."""
    try:
        msgspec.convert(document, Description)
    except msgspec.ValidationError as error:
        return str(error)
    return None


@pytest.mark.parametrize("model", MODELS)
def test_the_place_is_the_one_that_the_converter_names(model: str) -> None:
    """Of every value that it refuses; and there is none in data that it takes."""
    refused = 0
    for document in spoiled(documents(model)):
        found = first_refusal(document, Description)
        error = refusal_of_the_converter(document)
        assert (found is None) == (error is None)
        if found is not None and error is not None:
            place, key = said(error)
            assert re.fullmatch(place, found.key), (error, found)
            assert (found.unknown or found.missing or "") == key
            refused += 1
    assert refused > 250
