"""Where a command is started: closed outputs, odd variables, and interrupts at any time."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from nipper_pin.cli import main

PROGRAM = "import sys; from nipper_pin.cli import main; sys.exit(main())"
CLOSED = (
    "nipper-pin: the output is closed, so that nothing can be printed; > /dev/null discards it\n"
)


def started(
    words: str, folder: Path, ends: str = "", **variables: str
) -> subprocess.CompletedProcess[str]:
    """The command in a shell, with what stands after it on the line."""
    line = f'exec "$0" -c "$1" {words} {ends}'
    return subprocess.run(
        ["sh", "-c", line, sys.executable, PROGRAM], cwd=folder, env=os.environ | variables,
        stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.sampled(3)
@pytest.mark.parametrize("words", [
    "simulate", "simulate --json -", "check e62", "new press", "--help", "simulate --help",
])  # fmt: skip
def test_a_closed_output_is_told_of(words: str, tmp_path: Path) -> None:
    done = started(words, tmp_path, ">&-")
    assert (done.returncode, done.stderr) == (2, CLOSED)


@pytest.mark.campaign
def test_nothing_is_written_into_files_by_a_closed_number(tmp_path: Path) -> None:
    """The first file that is opened would be the output, or take the errors of libraries."""
    for ends, status in ((">&-", 2), ("2>&-", 0), ("<&- >&- 2>&-", 2)):
        done = started("simulate --json run.json", tmp_path, ends)
        assert done.returncode == status
        assert (tmp_path / "run.json").read_text().startswith("{")
        assert (tmp_path / "run.json").read_text().endswith("}\n")
        (tmp_path / "run.json").unlink()
    assert started("check nothing", tmp_path, "2>&-").returncode == 2


PLAIN, DRAWN, WORDS = "new --list", "check e62 --drawing e62.svg", "check e62"
ODD = [
    (PLAIN, {"COLUMNS": "0"}), (PLAIN, {"COLUMNS": "1"}), (PLAIN, {"COLUMNS": "-5"}),
    (PLAIN, {"COLUMNS": "wide"}), (PLAIN, {"TERM": "nonsense"}), (PLAIN, {"TZ": "nonsense"}),
    (PLAIN, {"LC_ALL": "nonsense"}), (WORDS, {"PYTHONIOENCODING": "ascii"}),
    (WORDS, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}),
    (DRAWN, {"MPLBACKEND": "nonsense"}), (DRAWN, {"HOME": "/nonexistent"}), (WORDS, {"HOME": ""}),
]  # fmt: skip


@pytest.mark.campaign
@pytest.mark.parametrize(("words", "variables"), ODD)
def test_odd_variables_harm_nobody(words: str, variables: dict[str, str], tmp_path: Path) -> None:
    done = started(words, tmp_path, **variables)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout


@pytest.mark.campaign
def test_an_interrupt_at_any_time_is_no_traceback(tmp_path: Path) -> None:
    """As soon as the command is there, libraries are still being imported."""
    told = f"import os, sys, nipper_pin.cli; os.write(1, b'x'); {PROGRAM}"
    for part in range(12):
        with subprocess.Popen(
            [sys.executable, "-c", told, "simulate", "--out", "run"], cwd=tmp_path,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        ) as process:  # fmt: skip
            assert process.stdout is not None
            assert process.stderr is not None
            process.stdout.read(1)
            # A part of what the command takes until it ends.
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(0.01 + 0.03 * part)
            process.send_signal(signal.SIGINT)
            said = process.stderr.read()
            assert b"Traceback" not in said
            assert process.wait() in {130, 0}


def test_what_a_library_makes_of_an_interrupt(monkeypatch: pytest.MonkeyPatch) -> None:
    """An import that is interrupted may end in an error of imports; others stay what they are."""

    def imports(*_: object, **__: object) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as error:
            raise ImportError from error

    def fails(*_: object, **__: object) -> None:
        raise ImportError

    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr("nipper_pin.cli.simulate.simulate", imports)
    assert main(["simulate"]) == 130
    monkeypatch.setattr("nipper_pin.cli.simulate.simulate", fails)
    with pytest.raises(ImportError):
        main(["simulate"])
    assert signal.getsignal(signal.SIGINT) is before
