"""The command with random arguments and files: status 0, 1 or 2, one sentence, no traceback.

An exception that is not an error of the package comes out of ``main`` and fails the test; that the
arguments reach the commands shows in the statuses, of which more than one kind has to occur.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import answer, assert_clear, files, one_line

from nipper_pin import load_case, load_solution
from nipper_pin.study.identify.problem.problem import BUILT_IN

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


def test_what_is_right_is_done_and_what_is_wrong_is_not() -> None:
    assert assert_clear(["simulate", "--json", "-"]) == 0
    assert assert_clear(["simulate", "--speed", "-1"]) == 2


SWEEP = """format = 1
title = "fuzz"
model = "e62"
chunk = 4
quantities = ["duration_s"]
[case]
speed_rpm = 650.0
drive = "held"
tolerance = 1e-10
max_collisions = 256
[samples]
method = "sobol"
count = 16
seed = 7
[parameters.restitution]
low = 0.05
high = 0.25
[parameters.stiffness]
values = [7000.0, 9000.0]
"""
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


@pytest.mark.campaign
@settings(max_examples=50)
@given(st.data())
def test_any_study_of_a_sweep(data: st.DataObject) -> None:
    pytest.importorskip("pyarrow")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.toml"
        path.write_text(_edited(SWEEP, data), encoding="utf-8")
        before = files(Path(folder))
        assert_clear(["sweep", str(path), "--dry-run", "--json", "-"], 0, 2)
        assert files(Path(folder)) == before


@settings(max_examples=40)
@given(st.data())
def test_any_problem_of_an_identification(data: st.DataObject) -> None:
    """Read only: what is right would be solved, and that takes minutes."""
    from nipper_pin.study.identify import read_problem

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.toml"
        path.write_text(_edited(BUILT_IN.read_text(encoding="utf-8"), data), encoding="utf-8")
        one_line(read_problem, path)


@pytest.mark.parametrize(
    "arguments",
    [
        ["paper", "no-such-model"],
        ["paper", "--set", "x"],
        ["paper", "--out", "{file}"],
        ["study", "lunch"],
        ["identify", "{missing}"],
        ["identify", "{file}"],
        ["sweep", "{missing}"],
        ["sweep", "{file}"],
        ["plot", "{missing}"],
        ["plot", "{folder}"],
        ["view", "--solution", "{missing}", "--html", "{folder}/x.html"],
        ["view", "--slow", "nan", "--html", "{folder}/x.html"],
        ["view", "--exaggerate", "1e9", "--html", "{folder}/x.html"],
        ["compare", "{missing}.npz", "e62"],
        ["compare", "e62", "{file}"],
        ["compare", "e62", "--set-b", "speed=nan"],
        ["compare", "e62", "--slow", "nan", "--html", "{folder}/x.html"],
        ["compare", "e62", "--html", "{folder}"],
        ["simulate", "--case", "{folder}"],
        ["simulate", "--out", "{file}"],
        ["simulate", "--json", "{folder}"],
        ["check", "{folder}"],
    ],
)
def test_files_that_are_not_what_they_should_be(tmp_path: Path, arguments: list[str]) -> None:
    """Status 2, and nothing is written or changed."""
    places = {
        "missing": str(tmp_path / "missing"),
        "file": str(tmp_path / "file"),
        "folder": str(tmp_path / "folder"),
    }
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_bytes(b"\x00\xff no file of ours")
    before = files(tmp_path)
    assert_clear([item.format(**places) for item in arguments], 2)
    assert files(tmp_path) == before


_SAVING = """
import sys
from nipper_pin import Case, load, save, save_case, simulate
mechanism = load("e62")
case = Case(speed_rpm=650.0, window="cycle")
solution = simulate(mechanism, case)
print("ready", flush=True)
while True:
    save(solution, sys.argv[1] + "/run.npz")
    save_case(mechanism, case, sys.argv[1] + "/case.json")
"""


@pytest.mark.campaign
@pytest.mark.parametrize("pause", [0.05, 0.1, 0.17, 0.26])
def test_a_killed_process_leaves_whole_files(tmp_path: Path, pause: float) -> None:
    """However a writer dies, a name holds a whole file: it is given when the file is complete.

    The writer does nothing but write, so the kill falls into a write nearly always.
    """
    with subprocess.Popen(
        [sys.executable, "-c", _SAVING, str(tmp_path)], stdout=subprocess.PIPE, text=True
    ) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "ready\n"
        end = time.monotonic() + 20.0
        while not (tmp_path / "case.json").exists() and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(pause)
        writer.send_signal(signal.SIGKILL)
    solution = load_solution(tmp_path / "run.npz")
    assert solution.collisions
    assert load_case(tmp_path / "case.json")[1] == solution.case
    others = {path.name for path in tmp_path.iterdir()} - {"run.npz", "case.json"}
    assert all(name.startswith(".") and name.endswith(".partial") for name in others)


def test_messages_are_one_line_whatever_the_names() -> None:
    status, out, err = answer(["simulate", "--set", "a\nb\x1b[31m=1\n2"])
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert "\x1b" not in err
