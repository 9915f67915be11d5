"""What `check` advises works when it is pasted, and what it says of stops and masses is so."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from nipper_pin.cli import main


def _advised(capsys: pytest.CaptureFixture[str], *words: str) -> list[list[str]]:
    """Commands that `check` ends with, in words."""
    assert main(["check", *words]) == 0
    lines = capsys.readouterr().out.splitlines()
    commands = [line.partition(": nipper-pin ")[2] for line in lines]
    return [shlex.split(command) for command in commands if command]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("name", "transition"),
    [("press", True), ("sieve", False), ("klann", False)],
)
def test_what_is_advised_works(
    name: str,
    transition: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """In a folder with a space, with a number changed; a transition only where there is one."""
    monkeypatch.chdir(tmp_path)
    folder = f"my machines/{name}"
    drawn = [] if name == "press" else ["--from", name]
    assert main(["new", *drawn, folder]) == 0
    printed = [shlex.split(line) for line in capsys.readouterr().out.splitlines()
               if line.startswith("  nipper-pin ")]  # fmt: skip
    assert [words[2] for words in printed] == [folder] * len(printed)
    assert len(printed) >= 2
    gravity = "gravity_m_s2=9.5"
    capsys.readouterr()
    advised = _advised(capsys, folder, "--set", gravity, "--speed", "61.5")
    assert [words[:2] for words in advised] == [
        *([["simulate", folder]] if transition else []), ["simulate", folder], ["view", folder]
    ]  # fmt: skip
    for words in advised:
        assert words[2:6] == ["--set", gravity, "--speed", "61.5"]
        assert main(words) == 0
    assert ("--window" in advised[0]) != transition


def test_a_start_that_cannot_be_assembled_names_the_loop_and_the_phase(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The leg cannot follow a crank of more than twice its length to index 24."""
    folder = str(tmp_path / "leg")
    assert main(["new", "--from", "jansen", folder]) == 0
    capsys.readouterr()
    longer = ["--set", "initial_phase=3", "--set", "points.A.radius_mm=35"]
    assert main(["check", folder, *longer]) == 1
    said = capsys.readouterr().err
    assert "the loops do not close" in said
    assert "widest open is closure 'C'; turns start in phase 3 free (no stop closed)" in said
    assert "start_index has to lie in it" in said
