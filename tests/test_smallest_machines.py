"""Every command on the smallest machines: it runs, or refuses with a sentence that names the lack.

One slide or one hinge, with a stop or without, with and without restitution, driven, and less.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from programs import STUDIES, study_text
from snapshots import Words
from waiting import notes

from nipper_pin.cli import main

MODELS = STUDIES / "smallest"
# A ball with a floor, an arm on a peg; a slide, a hinge and a drive alone; and less.
MACHINES = (
    "ball", "ball_without_rebound", "ball_that_lies", "ball_with_faces", "arm_on_a_peg", "slide",
    "hinge", "driven", "no_transition_stop", "nothing",
)  # fmt: skip
COMMANDS = {
    "check": "check {m}",
    "check as JSON": "check {m} --json document.json",
    "drawing": "check {m} --drawing drawing.svg",
    "transition": "simulate {m}",
    "turns": "simulate {m} --window cycle --cycles 2 --forces --json document.json",
    "free shafts": "simulate {m} --window cycle --drive inertial",
    "page": "view {m} --html page.html",
    "page of a transition": "view {m} --window transition --html page.html",
    "film": "view {m} --slow 1 --gif film.gif",
    "comparison": "compare {m} --speed 60 80 --json document.json",
    "page of two": "compare {m} --speed 60 80 --window cycle --html page.html",
    "curves": "compare {m} --speed 60 80 --window cycle --out compared",
    "kept run": "simulate {m} --window cycle --out run",
    "levers": "levers {m}",
    "speed limit": "speed-limit {m}",
    "live page": "live {m} --no-browser --port 0",
}
FIGURES = ("curves", "kept run")


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "command",
    [pytest.param(of, marks=[pytest.mark.slow] * (of in FIGURES)) for of in COMMANDS],
)
def test_every_command(
    command: str, here: Path, words: Words, capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 0, no note and the files that were asked for; or status 2 and one sentence."""
    text = ""
    for machine in MACHINES:
        line = COMMANDS[command].format(m=MODELS / machine).split()
        status, told = main(line), capsys.readouterr()
        err = notes(told.err)
        said = err.removeprefix("nipper-pin: ").replace(str(MODELS), "MODELS") or "runs\n"
        text += f"{machine}: {said}"
        files = [Path(word) for word in line if word.endswith((".json", ".svg", ".html", ".gif"))]
        if status:
            assert (status, len(err.splitlines())) == (2, 1)
            assert not any(here.iterdir())
            continue
        assert all(file.stat().st_size > 100 for file in files)
        for file in files:
            assert file.suffix != ".json" or json.loads(file.read_text(encoding="utf-8"))
        assert ", is off its stop" not in told.out.replace(",  ", ", ")
        if command == "kept run":
            assert main(["view", "--solution", "run/solution.npz", "--html", "page.html"]) == 0
            collisions = (here / "run" / "collisions.csv").read_text(encoding="utf-8")
            assert collisions.startswith("number")
        capsys.readouterr()
        for item in here.iterdir():
            shutil.rmtree(item) if item.is_dir() else item.unlink()
    words(text)


SWEEP = study_text("smallest/sweep.toml")
OPTIMISE = study_text("smallest/optimise.toml")
IDENTIFY = study_text("smallest/identify.toml")
MEASURED = study_text("smallest/measured.csv")
NUMBERS = {
    "ball": ("stops.floor.restitution", 0.9), "arm_on_a_peg": ("stops.peg.restitution", 0.9),
    "slide": ("links.ball.mass_kg", 2.0),
}  # fmt: skip
# A command, the file of its study, the quantity, and the window of a sweep.
SWEEP_IT = "sweep study.toml --workers 1 --out swept"
OPTIMISE_IT = "optimise study.toml --workers 1 --starts 1 --no-check --out found"
STUDIES = {
    "sweep of transitions": (SWEEP_IT, SWEEP, "duration_s", "transition"),
    "sweep of turns": (SWEEP_IT, SWEEP, "clamped_share", "cycle"),
    "optimum of transitions": (OPTIMISE_IT, OPTIMISE, "rebound_amplitude_1", ""),
    "optimum of turns": (OPTIMISE_IT, OPTIMISE, "energy_lost_turn_J", ""),
    "identification": (
        "identify study.toml --workers 1 --starts 1 --profiles 0", IDENTIFY, "", "",
    ),
}  # fmt: skip


@pytest.mark.campaign
@pytest.mark.parametrize("study", STUDIES)
def test_every_study(
    study: str, here: Path, words: Words, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sweep, which is drawn and verified, an optimum, an identification; or one sentence."""
    command, written, quantity, window = STUDIES[study]
    text = ""
    (here / "measured.csv").write_text(MEASURED, encoding="utf-8")
    for machine, (number, high) in NUMBERS.items():
        filled = written.format(
            m=MODELS / machine, quantity=quantity, window=window, number=number, high=high
        )
        (here / "study.toml").write_text(filled, encoding="utf-8")
        status, told = main(command.split()), capsys.readouterr()
        err = notes(told.err)
        said = err.removeprefix("nipper-pin: ").replace(str(MODELS), "MODELS") or "runs\n"
        text += f"{machine}: {said}"
        assert (len(err.splitlines()), status in (1, 2)) in {(0, False), (1, True)}
        if command == SWEEP_IT and not status:
            status, told = main(["plot", "swept"]), capsys.readouterr()
            assert (status, told.err) == (0, "")
            assert any((here / "swept" / "plots").iterdir())
        for name in ("swept", "found"):
            shutil.rmtree(here / name, ignore_errors=True)
    words(text)
