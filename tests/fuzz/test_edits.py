"""Files with one thing in them changed, cut off, or from elsewhere: taken, or refused by one line.

Every example edits what is right, so that most of them get past the first check. An exception that
is not an error of the package comes through and fails the test.
"""

from __future__ import annotations

import copy
import json
import os
import tempfile
import tomllib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import assert_clear, files, one_line, packed, stored_run

from nipper_pin import (
    Case,
    InputError,
    Mechanism,
    load,
    load_case,
    load_solution,
    save,
    save_case,
    simulate,
)
from nipper_pin.mechanism import from_sources, known_models
from nipper_pin.mechanism.files import toml
from nipper_pin.study import identify, optimise
from nipper_pin.study.identify.problem.problem import BUILT_IN
from nipper_pin.study.sweep import read_plan
from tests.refusals.bases import places, right

E62 = known_models()["e62"]
URDF, TOML = ((E62 / f"e62.{kind}").read_text(encoding="utf-8") for kind in ("urdf", "toml"))
SCALARS = st.one_of(
    st.none(), st.booleans(), st.floats(), st.integers(-(10**30), 10**30), st.text(max_size=8),
    st.sampled_from([0, -0.0, 1e308, 5e-324, 2**70, "jaw", "steeve", "e62"]),
)  # fmt: skip
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
    max_leaves=5,
)
GONE = object()
Path_ = tuple[Any, ...]


def changed(document: Any, path: Path_, value: object) -> Any:
    """The document with another value at a path, or without it."""
    whole = holder = copy.deepcopy(document)
    for step in path[:-1]:
        holder = holder[step]
    if value is GONE:
        del holder[path[-1]]
    else:
        holder[path[-1]] = value
    return whole


def built(document: Any, urdf: str = URDF) -> Mechanism | InputError:
    return one_line(from_sources, "e62", urdf, document, E62)


def in_a_file(read: Callable[[Path], object], content: bytes, name: str = "a.toml") -> None:
    """Read only: what is right would be computed, and that takes long. The file stays as it is."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        one_line(read, path)
        assert files(Path(folder)) == {name: content}


def asked(path: Path) -> None:
    """Load a solution and ask it for what is computed only when it is asked for."""
    solution = load_solution(path)
    one_line(lambda: [solution.collisions, solution.phases, solution.transitions])


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, dict[str, np.ndarray]]:
    """Document and arrays of a small stored run."""
    solution = simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=2))
    return stored_run(save(solution, tmp_path_factory.mktemp("run") / "run.npz"))


Used = Callable[[Any], object]


@pytest.fixture(scope="module")
def documents(
    run: tuple[Any, dict[str, np.ndarray]], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, tuple[Any, Used]]:
    """What is right, as plain data, and what writes and reads it."""
    case = save_case(load("e62"), Case(speed_rpm=650.0), tmp_path_factory.mktemp("case") / "a.json")

    def study(text: str, read: Callable[[Path], object]) -> tuple[Any, Used]:
        def use(document: Any) -> None:
            # Tables and other things in one list are not written.
            text = ""
            with suppress(AttributeError):
                text = toml(document)
            in_a_file(read, text.encode())

        return tomllib.loads(text), use

    fit = right("fit.toml").replace('measured = "seen.csv"\n', "")
    return {
        "model": (tomllib.loads(TOML), built),
        "case": (json.loads(case.read_text("utf-8")),
                 lambda document: in_a_file(load_case, json.dumps(document).encode())),
        "run": (run[0], lambda document: in_a_file(asked, packed(document, run[1]), "a.npz")),
        "sweep": study(right("sweep.toml"), lambda path: read_plan(str(path)).chunks()),
        "built-in fit": study(BUILT_IN.read_text(encoding="utf-8"), identify.read_problem),
        "fit": study(fit, identify.read_problem),
        "design": study(right("design.toml"), optimise.read_problem),
    }  # fmt: skip


@pytest.mark.parametrize("kind", ["model", "case", "run", "sweep", "built-in fit", "fit", "design"])
@settings(max_examples=60)
@given(data=st.data())
def test_one_thing_is_another_one_or_gone(
    kind: str, documents: dict[str, tuple[Any, Used]], data: st.DataObject
) -> None:
    document, use = documents[kind]
    path = data.draw(st.sampled_from([*places(document)]))
    use(changed(document, path, data.draw(VALUES) if data.draw(st.booleans()) else GONE))


def test_anything_missing_from_the_toml() -> None:
    """What is missing is refused unless it has a default: both happen, so the tests bite."""
    document = tomllib.loads(TOML)
    parts = [path for path in places(document) if path[0] != "provenance"]
    found = [built(changed(document, path, GONE)) for path in parts]
    refused = sum(isinstance(item, InputError) for item in found)
    assert 0.5 * len(parts) < refused < len(parts)
    assert isinstance(built(document), Mechanism)


ELEMENTS = len(list(ElementTree.fromstring(URDF).iter()))
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
@settings(max_examples=300)
@given(st.integers(1, ELEMENTS - 1), st.integers(0, ELEMENTS - 1),
       st.sampled_from(["attribute", "remove", "double", "rename", "move"]), st.data())  # fmt: skip
def test_elements_changed_lost_doubled_and_moved(
    place: int, other: int, change: str, data: st.DataObject
) -> None:
    root = ElementTree.fromstring(URDF)
    elements = list(root.iter())
    element = elements[place]
    parent = next(item for item in elements if element in list(item))
    if change == "attribute":
        names = [*element.attrib, "name", "type", "xyz", "filename"]
        element.set(data.draw(st.sampled_from(names)), data.draw(_texts))
    elif change == "remove":
        parent.remove(element)
    elif change == "double":
        parent.append(copy.deepcopy(element))
    elif change == "rename":
        element.tag = elements[other].tag
    else:
        elements[other].append(copy.deepcopy(element))
    built(tomllib.loads(TOML), ElementTree.tostring(root, encoding="unicode"))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("events", 0, "P_N", "jaw"), None), (("events", 1, "P_N"), {"a": 1}),
        (("events", 0, "t"), "soon"), (("events", 1, "stops"), []),
        (("events", 0, "number"), [[1, 2], [3]]), (("segments", 0, "t_end"), {}),
        (("shaft", "start_angle_rad"), {}), (("shaft", "speed_rad_s"), ""),
        (("case", "speed_rpm"), 10**400), (("case", "cycles"), True),
        *((path, GONE) for path in (
            ("events",), ("format",), ("events", -1), ("case", "cycles"),
            ("segments", 0, "panels", 0, -1), ("segments", 0, "panels", 0, 2, -1),
        )),
        (("outcome",), "GOOD"), (("events", 0, "kind"), "bang"), (("case", "speed_rpm"), -1.0),
        (("case", "colour"), "red"), (("mechanism", "urdf"), "<robot/>"),
        (("mechanism", "urdf"), "no xml"), (("segments",), None), (("segments", 0, "source"), 1),
        (("mechanism", "description", "stops", "jaw", "restitution"), -1),
        (("events", 0, "source"), 2), (("events", 0, "closed_after"), ["nowhere"]),
        (("events", 0, "P_g"), [0.0]), (("case", "resolution", "integrator"), "radau"),
    ],
)  # fmt: skip
def test_wrong_values_are_refused_when_they_are_read(
    run: tuple[Any, dict[str, np.ndarray]], tmp_path: Path, path: Path_, value: object
) -> None:
    """Missing keys, unknown names, impossible values.

    Runs with wrong types were read, and failed with a traceback when asked.
    """
    file = tmp_path / "wrong.npz"
    file.write_bytes(packed(changed(run[0], path, value), run[1]))
    with pytest.raises(InputError):
        load_solution(file)


def test_a_run_without_one_of_its_arrays(
    run: tuple[Any, dict[str, np.ndarray]], tmp_path: Path
) -> None:
    document, arrays = run
    file = tmp_path / "less.npz"
    for name in arrays:
        file.write_bytes(packed(document, {key: arrays[key] for key in arrays if key != name}))
        with pytest.raises(InputError):
            load_solution(file)


@pytest.mark.parametrize("name", ["e62.toml", "e62.urdf"])
@given(junk=st.binary(max_size=40), part=st.floats(0.0, 1.0))
def test_files_that_were_cut_off(name: str, junk: bytes, part: float) -> None:
    """Junk at the end that is no UTF-8, no TOML and no XML."""
    whole = (E62 / name).read_bytes()
    content = whole[: int(part * len(whole))] + junk
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home) / "e62"
        folder.mkdir()
        for file in ("e62.toml", "e62.urdf"):
            (folder / file).write_bytes(content if file == name else (E62 / file).read_bytes())
        one_line(load, folder)


@pytest.mark.parametrize("words", ["simulate --case", "view --html page.html --solution"])
def test_a_damaged_file_on_the_command_line(here: Path, words: str) -> None:
    """Status 2, one sentence, and the file is left as it was."""
    for content in (
        b"", b"{}", b"PK\x03\x04", b"\x93NUMPY\x01\x00", b"[1, 2", b"\xff\xfe", b"null",
    ):  # fmt: skip
        Path("damaged").write_bytes(content)
        assert assert_clear([*words.split(), "damaged"], 2) == 2
        assert files(here) == {"damaged": content}


def test_deep_and_long_documents(tmp_path: Path) -> None:
    """Nesting beyond any recursion limit, numbers of many digits, names of many letters."""
    path = tmp_path / "case.json"
    for text in ("[" * 100_000, '{"a":' * 50_000, "9" * 10_000, '"' + "a" * 100_000 + '"'):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError):
            load_case(path)


# Random words on the command line.

_wrong = st.sampled_from(
    ["0", "-0.0", "1e400", "nan", "-inf", "1_000", "0x10", "", " ", "½", "\uff11"]
)
_numbers = st.one_of(_wrong, st.floats().map(repr), st.integers(-(10**12), 10**12).map(str))
_words = st.one_of(
    _numbers,
    st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=10),
    st.sampled_from(
        ["e62", "jaw", "-", "--", "../e62", "/", ".", "~", "stops.jaw.restitution=0.1"]
    ),
)


@pytest.mark.campaign
@given(st.lists(_words, max_size=4))
def test_any_words(words: list[str]) -> None:
    """Words in place of commands and their arguments; none of them may start a server."""
    if words and words[0] in ("view", "live"):
        return
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            assert_clear(["check", *words])
            assert_clear(words or [""], 2)
        finally:
            os.chdir(before)
