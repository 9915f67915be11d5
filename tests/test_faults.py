"""Writes that fail, or in whose middle a process is killed: old or new at the target, never mixed.

The commands run under a shim that disturbs one call; what is at their targets is read with the
standard library. `scripts/maintain/confirm/faults/campaign.py` does the same with every command.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts/maintain/confirm/faults"))

from arena import Arena, NoCompilerError, build
from commands import COMMANDS, write_inputs
from field import Field
from pairs import racing_pairs
from verdicts import NEW, NONE, OLD, PART, SAME, WRONG, content, leftovers, state
from writes import KINDS, every_write

from nipper_pin import InputError
from nipper_pin.cli import main
from nipper_pin.study.folders import alone_in

BY_NAME = {item.name: item for item in COMMANDS}
# Every so many calls: all of one file and of a small folder, and some of what takes longer.
STEPS = {"simulate --out": 4, "new": 1, "simulate --json": 1, "sweep": 23}


@pytest.fixture(scope="module")
def shim(tmp_path_factory: pytest.TempPathFactory) -> Path:
    try:
        return build(tmp_path_factory.mktemp("shim"))
    except NoCompilerError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def arena(shim: Path) -> Iterator[Arena]:
    with Arena(shim) as found:
        yield found


@pytest.fixture
def inputs(tmp_path: Path) -> Path:
    write_inputs(tmp_path / "in")
    return tmp_path / "in"


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", STEPS)
def test_every_write_may_fail(
    name: str, kind: str, arena: Arena, inputs: Path, tmp_path: Path
) -> None:
    """Each in turn; then the command is run again, and ends as if nothing had been."""
    field = Field(BY_NAME[name], inputs, tmp_path / "field", arena)
    seen = list(every_write(field, kind, STEPS[name]))
    assert [item.wrong for item in seen if item.wrong] == []
    assert len(seen) >= (field.calls - 3) // STEPS[name] - 1
    if kind != "kill":
        assert sum(item.ended.status == 2 for item in seen) > len(seen) // 2


@pytest.mark.slow
def test_two_writers_at_once(shim: Path, arena: Arena, inputs: Path, tmp_path: Path) -> None:
    """The result is one's or the other's, in a folder that was there and in a new one."""
    with Arena(shim) as second:
        for place, name in enumerate(("simulate --out", "simulate --out, new", "new")):
            field = Field(BY_NAME[name], inputs, tmp_path / str(place), arena)
            for seen in racing_pairs(field, second, 6, np.random.default_rng(place)):
                assert not seen.wrong


def test_what_the_judge_says_of_results(tmp_path: Path) -> None:
    """It is the judge of all the others; hidden files, locks and times are no results."""
    old, new = {"a": b"1", "b": b"1"}, {"a": b"2", "b": b"2"}
    assert state({}, {}, new) == NONE
    assert state(old, old, new) == OLD
    assert state(new, old, new) == NEW
    assert state(new, new, new) == SAME
    for mixed in ({"a": b"1", "b": b"2"}, {"a": b"2"}, {**new, "c": b""}, {}):
        assert state(mixed, old, new) == WRONG
    whole = {"plan": b"p", "parts/1": b"1", "parts/2": b"2", "result": b"r"}
    for kept, word in (
        ({"plan": b"p", "parts/2": b"2"}, PART), ({"parts/2": b"half"}, WRONG),
        ({"parts/3": b""}, WRONG), ({"plan": b"p", "result": b"x"}, WRONG),
    ):  # fmt: skip
        assert state(kept, {}, whole, "plan|parts/.*") == word
    assert state({"plan": b"p"}, {"parts/1": b"1"}, whole, "plan|parts/.*") == WRONG
    (tmp_path / ".a.0.partial").mkdir()
    (tmp_path / ".a.0.partial" / "new").touch()
    (tmp_path / "locks").touch()
    (tmp_path / "run.json").write_text('{"b": 1, "work": {"wall_s": 0.5}}')
    assert content(tmp_path) == {"run.json": b'{"b": 1, "work": {}}'}
    assert leftovers(tmp_path) == [".a.0.partial"]


@pytest.mark.parametrize("words", ["simulate e62", "simulate e62 --json -", "new press"])
def test_an_output_that_is_full(words: str, tmp_path: Path) -> None:
    """A table or a document on a full disk: one sentence and status 2, and no traceback.

    Also of a few lines, which stay in a buffer until the end.
    """
    program = "import sys; from nipper_pin.cli import main; sys.exit(main())"
    # Where nothing is buffered there is nothing left to write at the end.
    env = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [sys.executable, "-c", program, *words.split()],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False, cwd=tmp_path,
            env=env,
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith("nipper-pin: the output: cannot be written")
    assert done.stderr.count("\n") == 1


def test_a_folder_takes_one_search_at_a_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], inputs: Path
) -> None:
    """A second one is refused in a sentence; as soon as the first one ends it may begin."""
    folder = tmp_path / "out"
    with alone_in(folder):
        assert main(["optimise", str(inputs / "design.toml"), "--out", str(folder)]) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"nipper-pin: {folder}: another process works in it")
        with pytest.raises(InputError, match="another process"), alone_in(folder):
            pass
    with alone_in(folder):
        assert list(folder.iterdir()) == []
