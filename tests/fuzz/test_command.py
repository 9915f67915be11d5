"""The command with random arguments and files: status 0, 1 or 2, one sentence, no traceback.

An exception that is not an error of the package comes out of ``main`` and fails the test.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import assert_clear, files, one_line

from nipper_pin.study import identify, optimise
from nipper_pin.study.identify.problem.problem import BUILT_IN
from nipper_pin.study.sweep import read_plan
from tests.refusals.bases import right

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
# What decides how long a run takes stays small: a fuzzer has no use for a million turns.
_OPTIONS = {
    "--speed": st.one_of(_wrong, st.floats(-1e3, 1e5).map(repr), st.floats(200.0, 900.0).map(repr)),
    "--restitution": st.one_of(_numbers, st.floats(0.0, 0.6).map(repr)),
    "--stiffness": st.one_of(_numbers, st.floats(1e3, 1e5).map(repr)),
    "--set": st.one_of(
        _words,
        st.tuples(
            st.sampled_from(
                ["stops.jaw.restitution", "links.top_nipper.mass_kg", "springs.steeve",
                 "cylinder.direction", "phases", "initial_phase", "drives.tension.ratio",
                 "links.top_nipper", "urdf", "points.x", "gravity_m_s2", "provenance", ""]
            ),
            _words,
        ).map("=".join),
    ),
    "--window": st.sampled_from(["transition", "cycle", "week"]),
    "--start-index": _numbers,
    "--drive": st.sampled_from(["held", "inertial", ""]),
    "--rest-rate": _numbers,
    "--tolerance": _numbers,
    "--cycles": st.sampled_from(["0", "1", "2", "-1", "1.5", "two"]),
}  # fmt: skip
_arguments = st.lists(
    st.sampled_from(sorted(_OPTIONS)).flatmap(
        lambda name: _OPTIONS[name].map(lambda value: f"{name}={value}")
    ),
    max_size=3,
).map(lambda items: ["simulate", "e62", *items, "--json", "-"])


@pytest.mark.campaign
@given(_arguments)
def test_any_arguments_of_simulate(arguments: list[str]) -> None:
    assert_clear(arguments)


@pytest.mark.campaign
@given(st.lists(_words, max_size=4))
def test_any_words(words: list[str]) -> None:
    """Words in place of commands and their arguments; none of them may start a server."""
    if not words or words[0] not in ("view", "live"):
        with tempfile.TemporaryDirectory() as folder:
            before = Path.cwd()
            os.chdir(folder)
            try:
                assert_clear(["check", *words])
                assert_clear(words or [""], 2)
            finally:
                os.chdir(before)


_tokens = st.one_of(
    st.sampled_from(
        ["0", "-1", "nan", "inf", "1e400", "true", '""', '"jaw"', "[]", "{}", "[1, 2]", '["x"]',
         "99999999999999999999", "1979-05-27", "[[]]", '"../x"', "not toml", "'''", "1e-300"]
    ),
    st.floats().map(repr),
    st.integers().map(str),
)  # fmt: skip


def _edited(text: str, data: st.DataObject) -> str:
    """The text with one value replaced, one line removed or doubled, or cut off."""
    lines = text.splitlines()
    place = data.draw(st.integers(0, len(lines) - 1))
    change = data.draw(st.sampled_from(["value", "value", "value", "gone", "twice", "cut"]))
    if change == "value" and "=" in lines[place]:
        lines[place] = f"{lines[place].split('=')[0]}= {data.draw(_tokens)}"
    elif change == "gone":
        del lines[place]
    elif change == "twice":
        lines.append(lines[place])
    else:
        lines = lines[:place]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "read"),
    [(right("sweep.toml"), lambda path: read_plan(str(path)).chunks()),
     (BUILT_IN.read_text(encoding="utf-8"), identify.read_problem),
     (right("fit.toml").replace('measured = "seen.csv"\n', ""), identify.read_problem),
     (right("design.toml"), optimise.read_problem)],
    ids=["sweep", "built-in fit", "fit", "design"],
)  # fmt: skip
@settings(max_examples=40)
@given(data=st.data())
def test_any_study(text: str, read: Callable[[Path], object], data: st.DataObject) -> None:
    """Read only: what is right would be computed, and that takes long."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.toml"
        path.write_text(_edited(text, data), encoding="utf-8")
        before = files(Path(folder))
        one_line(read, path)
        assert files(Path(folder)) == before
