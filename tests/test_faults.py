"""Disks that are full, and processes that are killed while they write: old or new, never mixed.

The kernel itself disturbs: a limit of the size of files makes the write that passes it fail, or
kills the process there.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from programs import study_text

import nipper_pin as nip
from tests.fuzz.refusals import files

# Modules that keep files of their own are imported, and have written them, before the limit comes.
PROGRAM = """
import resource, signal, sys
if {"--out", "--gif"} & set(sys.argv):
    import matplotlib.font_manager
from nipper_pin.cli import main
limit, kill = int(sys.argv.pop(1)), sys.argv.pop(1) == "killed"
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
if kill:
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
if limit >= 0:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
sys.exit(main())
"""
SWEEP = study_text("sweep_on_a_full_disk.toml")
# What is written, and what was there before.
COMMANDS = {
    "simulate --out": (
        "simulate e62 --speed 650 --out out", "simulate e62 --speed 500 --out out"
    ),
    "simulate --json": (
        "simulate e62 --speed 650 --json out", "simulate e62 --speed 500 --json out"
    ),
    "new": ("new press", ""),
    "view --html": (
        "view hanging_pendulum --window transition --html out.html",
        "view hanging_pendulum --window transition --slow 20 --html out.html",
    ),
    "view --gif": (
        "view hanging_pendulum --window transition --slow 2 --gif out.gif",
        "view hanging_pendulum --window transition --slow 1 --gif out.gif",
    ),
    "check --json": ("check e62 --speed 650 --json out", "check e62 --json out"),
}  # fmt: skip
QUICK = ("new",)


def run(words: str, place: Path, limit: int = -1, end: str = "refused") -> tuple[int, str]:
    """Exit status and what was said, of a command that may write so many bytes into a file."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(limit), end, *words.split()],
        cwd=place, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stderr


@pytest.mark.parametrize("end", ["refused", "killed"])
@pytest.mark.parametrize(
    "name",
    [pytest.param(item, marks=[pytest.mark.campaign] * (item not in QUICK)) for item in COMMANDS],
)
def test_a_write_that_cannot_be_finished(name: str, end: str, tmp_path: Path) -> None:
    """In the first file, in the largest and between; the same command then ends as ever.

    Half of a size: the times that a run tells have more or fewer digits.
    """
    words, before = COMMANDS[name]
    (tmp_path / "whole").mkdir()
    assert run(words, tmp_path / "whole")[0] == 0
    whole = files(tmp_path / "whole")
    sizes = sorted(len(data) for data in whole.values())
    place = tmp_path / "place"
    place.mkdir()
    assert not before or run(before, place)[0] == 0
    old = files(place)
    for limit in sorted({1, sizes[len(sizes) // 2] // 2, sizes[-1] // 2}):
        status, said = run(words, place, limit, end)
        found = files(place)
        if end == "killed":
            assert status == -signal.SIGXFSZ
            found = {key: data for key, data in found.items() if ".partial" not in key}
        else:
            assert status == 2
            assert said.startswith("nipper-pin: ")
            assert said.count("\n") == 1
        assert found == old
    assert run(words, place)[0] == 0
    assert files(place).keys() == whole.keys()
    assert files(place) != old


@pytest.mark.campaign
@pytest.mark.parametrize("end", ["refused", "killed"])
def test_a_sweep_that_cannot_be_finished_goes_on(end: str, tmp_path: Path) -> None:
    """What it leaves are finished chunks; its rows are in the end those of a sweep in one go."""
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    words = "sweep sweep.toml --workers 1 --out "
    assert run(words + "whole", tmp_path)[0] == 0
    sizes = sorted(len(data) for data in files(tmp_path / "whole").values())
    for limit in (1, sizes[len(sizes) // 2] // 2, sizes[-1] // 2):
        assert run(words + "out", tmp_path, limit, end)[0] not in (0, 1)
    assert run(words + "out", tmp_path)[0] == 0
    rows, whole = (nip.read_sweep(tmp_path / each).table.to_pydict() for each in ("out", "whole"))
    assert rows == whole
    assert not [name for name in files(tmp_path / "out") if ".partial" in name]


@pytest.mark.sampled(2)
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
