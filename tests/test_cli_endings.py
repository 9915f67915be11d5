"""What every command writes, and how it ends."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from programs import main
from test_cli_options import FIT, STUDY
from test_words import BALL, CAMERA
from test_words import FIT as FILMED

from benchmarks.stress import Campaign, Verdict
from nipper_pin import cli

# A stiffer preload calms the jaw, at the cost of force.
DESIGN = """format = 1
title = "calm"
minimise = [{aims}]
[parameters.preload]
low = 9.0
high = 11.0
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with small studies, where the commands run."""
    studies = {
        "fit": FIT,
        "sweep": STUDY.format(title="one", name="restitution"),
        "two": DESIGN.format(aims='"rebound_amplitude_1", "clamping_force_N"'),
        "one": DESIGN.format(aims='"rebound_amplitude_1"'),
        "wrong": FILMED.format(name="wrong").replace('"ball"', f'"{BALL.as_posix()}"'),
    }
    for name, text in studies.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    (tmp_path / "wrong.csv").write_text(CAMERA.format(second=0.0161), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        "simulate",
        "check",
        "compare e62 --set-b stiffness=11000",
        "speed-limit --from 450 --to 600 --speeds 2 --turns 4",
        "identify fit.toml --starts 1 --profiles 0 --workers 1",
        pytest.param("optimise one.toml --starts 1 --no-check --workers 1", marks=pytest.mark.slow),
        "sweep sweep.toml --workers 1",
        pytest.param("stress --cases 1 --workers 1", marks=pytest.mark.slow),
        pytest.param("paper", marks=pytest.mark.slow),
    ],
)
def test_a_document_in_a_file_leaves_the_terminal_its_tables(
    words: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file holds the document; - prints it, and nothing else."""
    assert main([*words.split(), "--json", "run.json"]) == 0
    tables = capsys.readouterr().out
    assert tables
    assert not tables.startswith("{")
    document = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    assert main([*words.split(), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out).keys() == document.keys()
    assert err == ""


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
        named = [line for line in lines if line.startswith(f"{place}/")]
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


@pytest.mark.usefixtures("folder")
def test_what_contradicts_itself_is_printed_and_status_1(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = "identify wrong.toml --starts 1 --profiles 0 --workers 1 --json -"
    assert main(words.split()) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["goodness"]["verdict"] == "contradicted"
    assert err.startswith("nipper-pin: THE DATA CONTRADICT THE FIT: ")
    assert err.count("\n") == 1


def test_control_characters_are_written_out(capsys: pytest.CaptureFixture[str]) -> None:
    """A name with a line break or an escape sequence stays one line that a terminal shows."""
    assert main(["check", "no\n\x1b[31m\tmodel é"]) == 2
    said = capsys.readouterr().err
    assert r"no\n\x1b[31m\tmodel é" in said
    assert said.count("\n") == 1


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
    program = "import sys; from nipper_pin.cli import main; sys.exit(main())"
    with subprocess.Popen(
        [sys.executable, "-c", program, "simulate", "e62", "--json", "-"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(60.0) == 0
