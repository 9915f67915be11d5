"""What every command writes, and how it ends."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from programs import STUDIES, main
from test_cli_options import CALLS
from waiting import notes

from benchmarks.stress import Campaign, Verdict
from nipper_pin import cli

PROGRAM = "import sys; from nipper_pin.cli import main; sys.exit(main())"


@pytest.fixture
def folder(here: Path) -> Path:
    """A folder with small studies, where the commands run."""
    return Path(shutil.copytree(STUDIES, here, dirs_exist_ok=True))


def once(call: Callable[..., object]) -> Callable[..., object]:
    """A call that gives its first answer again."""
    answers: list[object] = []

    def asked(*given: Any, **named: Any) -> object:
        answers[:] = answers or [call(*given, **named)]
        return answers[0]

    return asked


@pytest.mark.parametrize(
    "words",
    [
        "simulate",
        "check",
        "compare e62 --set-b stiffness=11000",
        "levers",
        "speed-limit --from 450 --to 600 --speeds 2 --turns 4",
        "identify fit.toml --starts 1 --profiles 0 --workers 1",
        pytest.param("optimise one.toml --starts 1 --no-check --workers 1", marks=pytest.mark.slow),
        "sweep sweep.toml --workers 1",
        pytest.param("stress --cases 1 --workers 1", marks=pytest.mark.slow),
    ],
)
def test_a_document_in_a_file_leaves_the_terminal_its_tables(
    words: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The file holds the document; - prints it, and nothing else. It is computed once."""
    room, _, name = CALLS[words.split()[0]].rpartition(".")
    monkeypatch.setattr(import_module(room), name, once(getattr(import_module(room), name)))
    assert main([*words.split(), "--json", "run.json"]) == 0
    tables = capsys.readouterr().out
    assert tables
    assert not tables.startswith("{")
    document = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    assert main([*words.split(), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out).keys() == document.keys()
    assert notes(err) == ""


@pytest.mark.slow
def test_files_that_were_written_are_named(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line each, the figure of a front last; a front of one point has no figure."""
    search = "--starts 1 --no-check --workers 1"
    assert main(["sweep", "sweep.toml", "--workers", "1", "--out", "swept"]) == 0
    for words, place, last in (
        (f"optimise two.toml --points 3 --format png {search}", "here", "front.png"),
        (f"optimise one.toml {search}", "there", "case.json"),
        ("plot swept", "drawn", ""),
    ):
        capsys.readouterr()
        assert main([*words.split(), "--out", place]) == 0
        lines = capsys.readouterr().out.splitlines()
        told = [line for line in lines if line.startswith("written: ")]
        named = [line.removeprefix("written: ") for line in told]
        assert sorted(named) == sorted(
            f"{place}/{file.name}" for file in (folder / place).iterdir()
        )
        assert named[-1].endswith(last)


def failed(number: int, family: str, word: str, detail: str = "") -> Verdict:
    return Verdict(number, family, word, "energy", detail, f"{number:04x}", 0.5)


@pytest.mark.parametrize(
    ("verdicts", "status", "said"),
    [
        ([failed(k, "transitions", "right") for k in range(3)], 0, ""),
        (
            [failed(0, "transitions", "right"), failed(1, "t", "wrong", "x" * 400),
             failed(2, "t", "wrong", "other")],
            1,
            f"nipper-pin: 2 of 3 cases are wrong, the first one number 1: {'x' * 300}\n",
        ),
        (
            [failed(k, "transitions", "refused") for k in range(40)],
            1,
            "nipper-pin: 40 of 40 cases of the family 'transitions' are refused, where ",
        ),
    ],
    ids=["right", "wrong", "refused"],
)  # fmt: skip
def test_a_campaign_ends_as_its_verdicts_say(
    verdicts: list[Verdict],
    status: int,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The table is printed in any case; then what is wrong, or refused more often than may be."""
    campaign = Campaign(5, tuple(verdicts), 1.0)
    monkeypatch.setattr("benchmarks.stress.run_campaign", lambda *_, **__: campaign)
    assert main(["stress"]) == status
    out, err = capsys.readouterr()
    assert f"{len(verdicts)} cases, seed 5" in out
    assert err == said or (said != "" and err.startswith(said))
    assert err.count("\n") == (1 if said else 0)


def test_a_broken_pipe_to_a_worker_is_an_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Only a reader of the output may stop early: then nobody is told, and nothing went wrong."""

    def broken(*_: object, **__: object) -> None:
        raise BrokenPipeError(32, "Broken pipe")

    monkeypatch.setattr("nipper_pin.cli.simulate.simulate", broken)
    monkeypatch.setattr("nipper_pin.cli._unread", lambda: False)
    assert main(["simulate", "e62"]) == 1
    assert "another process ended before its work was done" in capsys.readouterr().err


@pytest.mark.parametrize("closed", [False, True])
def test_a_pipe_without_a_reader_is_known(closed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    if closed:
        os.close(reading)
    with os.fdopen(writing, "w") as stream:
        monkeypatch.setattr("sys.stdout", stream)
        assert cli._unread() is closed
        monkeypatch.undo()
    if not closed:
        os.close(reading)


def test_a_reader_that_stops_early_is_no_error() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "simulate", "e62", "--json", "-"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(60.0) == 0


# Where a command is started: closed outputs, odd variables, and interrupts at any time.

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
    assert (done.returncode, notes(done.stderr)) == (0, "")
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


def test_a_command_in_a_thread_leaves_interrupts_alone() -> None:
    """Python lets the main thread alone handle signals."""
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(main, ["simulate", "none"]).result() == 2
