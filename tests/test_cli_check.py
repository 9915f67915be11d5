"""What `check` advises works when it is pasted, and what it says of stops and masses is so."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from nipper_pin.cli import main
from nipper_pin.mechanism import load
from nipper_pin.study.check import check_model
from nipper_pin.study.next_steps import NextSteps, next_steps
from tests.small_machines import frame, hinge, link, machine, slide


def _advised(capsys: pytest.CaptureFixture[str], *words: str) -> list[list[str]]:
    """Commands that `check` ends with, in words."""
    assert main(["check", *words]) == 0
    lines = capsys.readouterr().out.splitlines()
    commands = [line.partition(": nipper-pin ")[2] for line in lines]
    return [shlex.split(command) for command in commands if command]


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


def test_a_start_is_passed_on(capsys: pytest.CaptureFixture[str]) -> None:
    advised = _advised(capsys, "e62", "--start-index", "21.5")
    assert [words[-2:] for words in advised[1:2]] == [["--start-index", "21.5"]]
    assert advised[2][2:4] == ["--start-index", "21.5"]
    assert "--start-index" not in advised[0]
    assert main(["check", "e62", "--start-index", "21.5", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["start_index"] == 21.5
    assert report["masses_kg"]["top_nipper"] == 1.2


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


def test_a_stop_that_only_bounces_is_not_said_to_be_never_struck(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Without loss a wheel between two stops bounces on and on."""
    from rich.console import Console

    from nipper_pin.view.studies.check_report import print_report

    parts = [link("sled"), slide("sled", "frame", "sled"),
             link("ball"), slide("ball", "sled", "ball")]  # fmt: skip
    stops = {"left": {"joint": "ball", "restitution": 1.0, "at_mm": -1.0},
             "right": {"joint": "ball", "restitution": 1.0, "at_mm": 1.0,
                       "side": "upper"}}  # fmt: skip
    drives = {"sled": {"joint": "sled", "law": "screw", "lead_mm_per_turn": 5.0}}
    springs = {"pull": {"joint": "ball", "stiffness_N_per_m": 100.0, "preload_length_mm": 5.0}}
    report = check_model(machine(parts, 2, stops=stops, drives=drives, springs=springs), 60.0)
    print_report(report, NextSteps((), ()), Console(width=200))
    said = capsys.readouterr().out
    assert "stop left is struck first at index" in said
    assert "left: restitution 1, lower limit of ball at -1 mm; smallest force while closed not " \
        "seen: it bounces and does not come to rest" in said  # fmt: skip
    assert "smallest force while closed not seen: it is never closed" in said


def test_masses_in_grams_are_noticed() -> None:
    """700 kg in a box of 0.1 l, and 1,200 kg without a shape; 7.8 kg/l with its pin is steel."""
    box = "<collision><geometry><box size='0.1 0.1 0.01'/></geometry></collision></link>"
    steel = (
        "<collision><geometry><cylinder radius='0.05' length='0.1'/></geometry></collision></link>"
    )
    parts = [
        link("ram", mass=700.0).replace("</link>", box), slide("ram", "frame", "ram"),
        link("rod", mass=1200.0), hinge("rod", "ram", "rod"), frame("foot", "rod", (0.1, 0.0)),
        link("pin", mass=6.1).replace("</link>", steel), hinge("pin", "rod", "pin"),
    ]  # fmt: skip
    report = check_model(machine(parts, 3), 60.0)
    assert [item.mass_kg for item in report.masses] == [700.0, 1200.0, 6.1]
    assert report.masses[0].density_kg_m3 == pytest.approx(7e6)
    assert report.masses[2].density_kg_m3 == pytest.approx(6.1 / 7.853982e-4)
    doubts = [step for step in next_steps(report, "m").missing if "grams" in step]
    assert doubts == [
        "Missing: link ram weighs 700 kg, 7e+06 kg/m3 by its shapes is far denser than any metal: "
        "is it in grams?",
        "Missing: link rod weighs 1200 kg, more than a machine's link weighs: is it in grams?",
    ]
    assert not any(item.doubt for item in check_model(load("e62"), 450.0).masses)
