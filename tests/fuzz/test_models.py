"""Model files with random errors: a clear refusal or a mechanism.

Every example edits a model that is right, so most of them get past the first check. An exception
that is not an ``InputError`` comes through and fails the test. A count keeps the tests honest: a
loader that refused everything would show there.
"""

from __future__ import annotations

import copy
import tempfile
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest
from documents import GONE, VALUES, changed, places
from hypothesis import given
from hypothesis import strategies as st
from refusals import one_line

from nipper_pin import InputError, Mechanism, load
from nipper_pin.mechanism import from_sources, known_models

E62 = known_models()["e62"]
URDF = (E62 / "e62.urdf").read_text(encoding="utf-8")
TOML = tomllib.loads((E62 / "e62.toml").read_text(encoding="utf-8"))

PLACES = [path for path in places(TOML) if path[0] != "provenance"]


def _built(urdf: str, document: dict[str, object]) -> Mechanism | InputError:
    return one_line(from_sources, "e62", urdf, document, E62)


@given(st.sampled_from(PLACES), VALUES)
def test_any_value_anywhere_in_the_toml(path: tuple[object, ...], value: object) -> None:
    _built(URDF, changed(TOML, path, value))


def test_anything_missing_from_the_toml() -> None:
    """What is missing is refused unless it has a default: both happen, so the tests bite."""
    found = [_built(URDF, changed(TOML, path, GONE)) for path in PLACES]
    refused = sum(isinstance(item, InputError) for item in found)
    assert 0.5 * len(PLACES) < refused < len(PLACES)
    assert isinstance(_built(URDF, TOML), Mechanism)


_ROOT = ElementTree.fromstring(URDF)
ELEMENTS = len(list(_ROOT.iter()))
_texts = st.one_of(
    st.sampled_from(
        ["", "nan", "inf", "-1", "0", "1e400", "0 0", "1 2 3 4", "a b c", "0 -1 0", "0 1 0",
         "frame", "jaw", "top_nipper", "../../etc/passwd", "/etc/passwd", "file:///etc/passwd",
         "package://x/y.stl", "meshes", "meshes/../../e62/e62.toml", "..\\x", "revolute",
         "floating", "mesh"]
    ),
    st.floats().map(repr),
    st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=8),
)  # fmt: skip


@pytest.mark.slow
@given(st.integers(0, ELEMENTS - 1), st.data())
def test_any_attribute_anywhere_in_the_urdf(place: int, data: st.DataObject) -> None:
    root = ElementTree.fromstring(URDF)
    element = list(root.iter())[place]
    names = [*element.attrib, "name", "type", "xyz", "filename"]
    element.set(data.draw(st.sampled_from(names)), data.draw(_texts))
    _built(ElementTree.tostring(root, encoding="unicode"), TOML)


@pytest.mark.slow
@given(st.integers(1, ELEMENTS - 1), st.sampled_from(["remove", "double", "rename", "move"]),
       st.integers(0, ELEMENTS - 1))  # fmt: skip
def test_elements_lost_doubled_and_moved(place: int, change: str, other: int) -> None:
    root = ElementTree.fromstring(URDF)
    element = list(root.iter())[place]
    parent = next(item for item in root.iter() if element in list(item))
    if change == "remove":
        parent.remove(element)
    elif change == "double":
        parent.append(copy.deepcopy(element))
    elif change == "rename":
        element.tag = list(root.iter())[other].tag
    else:
        list(root.iter())[other].append(copy.deepcopy(element))
    _built(ElementTree.tostring(root, encoding="unicode"), TOML)


@given(st.sampled_from(["e62.toml", "e62.urdf"]), st.binary(max_size=40), st.floats(0.0, 1.0))
def test_bytes_in_the_files(name: str, junk: bytes, part: float) -> None:
    """Files on disk: junk that is no UTF-8, no TOML, no XML."""
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home) / "e62"
        folder.mkdir()
        for file in ("e62.toml", "e62.urdf"):
            (folder / file).write_bytes((E62 / file).read_bytes())
        content = (folder / name).read_bytes()
        cut = int(part * len(content))
        (folder / name).write_bytes(content[:cut] + junk)
        one_line(load, folder)
