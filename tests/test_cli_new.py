"""`nipper-pin new`, the tutorial and what `check` advises: from an empty folder to a run."""

from __future__ import annotations

import math
import os
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, Outcome, Window, export, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism.skeleton import write_skeleton

ROOT = Path(__file__).resolve().parents[1]
TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
MARKED = re.compile(r"<!-- (?P<what>[^\n]*) -->\n```\w+\n(?P<text>.*?)```", re.DOTALL)
RADIUS, LENGTH, TOUCH = 0.025, 0.113, math.atan2(-20.0, -15.0)
EPS = float(np.finfo(float).eps)


def ram_rate(psi: float, radius: float = RADIUS, length: float = LENGTH) -> float:
    """Derivative of the above by the crank angle [m/rad]."""
    across = radius * math.cos(psi)
    down = math.sqrt(length**2 - across**2)
    return across * (1.0 - radius * math.sin(psi) / down)


def listings() -> dict[str, str]:
    return {match["what"]: match["text"] for match in MARKED.finditer(TUTORIAL)}


def first_step(home: Path) -> Path:
    folder = home / "slider"
    folder.mkdir()
    for what, text in listings().items():
        if what.startswith("file: "):
            (home / what.removeprefix("file: ")).write_text(text, encoding="utf-8")
    return folder


def second_step(home: Path) -> Path:
    """What step 2 says, done to the files of step 1 word by word."""
    folder = first_step(home)
    for what, text in listings().items():
        match = re.fullmatch(r"replace in (\S+) from: (.+) to: (.+)", what)
        if match is None:
            continue
        path = home / match[1]
        old = path.read_text(encoding="utf-8")
        start = old.index(match[2])
        stop = len(old) if match[3] == "end" else old.index(match[3])
        # The indentation before the first replaced element belongs to it.
        start = old.rindex("\n", 0, start) + 1
        stop = stop if match[3] == "end" else old.rindex("\n", 0, stop) + 1
        path.write_text(old[:start] + text + old[stop:], encoding="utf-8")
    toml = folder / "slider.toml"
    text = toml.read_text(encoding="utf-8")
    assert text.count("degrees_of_freedom = 1") == 1
    text = text.replace(
        "degrees_of_freedom = 1", 'transition_stop = "anvil"\ndegrees_of_freedom = 2'
    )
    toml.write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def press(tmp_path: Path) -> Mechanism:
    """In a folder that is there and empty."""
    (tmp_path / "press").mkdir()
    return load(write_skeleton(tmp_path / "press"))


@pytest.mark.parametrize("step", ["1", "2", "3"])
def test_commands_of_the_tutorial_work_as_printed(
    here: Path, capsys: pytest.CaptureFixture[str], step: str
) -> None:
    (first_step if step == "1" else second_step)(here)
    text = TUTORIAL.partition(f"## Step {step}:")[2].partition("\n## ")[0]
    commands = re.findall(r"(?m)^    nipper-pin (.+)$", text)
    assert len(commands) >= 2
    for command in commands:
        assert main(command.split()) == 0, command
    said = capsys.readouterr().out
    assert ("nothing can collide" in said) == (step == "1")
    for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(code, {})  # a listing of this repository's own document
        assert float(capsys.readouterr().out) < 2.5e-8


def test_press_of_the_tutorial_is_that_of_the_skeleton(tmp_path: Path, press: Mechanism) -> None:
    """Two texts written apart from each other, one machine: the collisions are the same.

    Both end in the same bodies but for the decimals of angle_at_touch_deg (the law is a constant
    speed, so that angle has no effect on the motion at all).
    """
    tutorial = load(second_step(tmp_path))
    case = Case(speed_rpm=120.0)
    one, other = simulate(tutorial, case), simulate(press, case)
    assert one.outcome is other.outcome is Outcome.AT_REST
    assert len(one.collisions) == len(other.collisions) > 3
    for first, second in zip(one.collisions, other.collisions, strict=True):
        assert first.approach_rate == pytest.approx(second.approach_rate, rel=1e-9)
        assert first.impulse == pytest.approx(second.impulse, rel=1e-9)


def test_press_strikes_as_fast_as_its_crank_drives_it(press: Mechanism) -> None:
    """First approach rate in closed form; the tutorial quotes it as 222 mm/s.

    With the buffer on its stop the ram is that of a rigid slider-crank, and the anvil is struck at
    touch. A wrong closure, axis or law gives another rate; round-off is 100 eps of it.
    """
    omega = 120.0 * math.tau / 60.0
    hit = simulate(press, Case(speed_rpm=120.0)).collisions[0]
    assert hit.stop == "anvil"
    assert hit.approach_rate == pytest.approx(omega * ram_rate(TOUCH), rel=1e-12)
    assert round(-1e3 * hit.approach_rate) == 222


def test_longer_crank_strikes_as_closed_form_says(press: Mechanism) -> None:
    """The override that the tutorial shows: crank of 27 mm, rod as long as the points then are.

    Crank pin at 27 mm (-0.6, -0.8), ram pin where it was. A crank that grew on one side of its pin
    only would open the closure; a rod that did not turn would give another rate.
    """
    mechanism = load(press.mesh_folder, {"points.crank_pin.radius_mm": "27"})
    length = math.hypot(0.0162, 0.132 - 0.0216)
    hit = simulate(mechanism, Case(speed_rpm=120.0)).collisions[0]
    expected = 120.0 * math.tau / 60.0 * ram_rate(TOUCH, 0.027, length)
    assert hit.approach_rate == pytest.approx(expected, rel=1e-12)


def test_guide_on_the_frame_keeps_its_direction(tmp_path: Path) -> None:
    """Ram and guide moved aside by 5 mm: an offset slider-crank, whose ram still moves along z.

    Closed form with offset e: z = r sin(psi) - sqrt(l^2 - (e - r cos(psi))^2). A guide that turned
    with the line from crank axis to ram pin would tilt by 5/132 and be out by a millimetre. Four
    decimals of angle_at_touch_deg are 2.2e-8 m, as in step 1.
    """
    mechanism = load(first_step(tmp_path), {"points.ram_pin.x_mm": 5.0})
    solution = simulate(mechanism, Case(speed_rpm=120.0, window=Window.CYCLE))
    times = np.linspace(*solution.trajectory.span, 101)
    q = solution.trajectory.evaluate(times).q
    found = q[:, next(item.index for item in mechanism.joints if item.name == "height")]
    psi = solution.shaft.angle(times)
    length, aside = math.hypot(0.020, 0.112), 0.005 - RADIUS * np.cos(psi)
    expected = RADIUS * np.sin(psi) - np.sqrt(length**2 - aside**2) + 0.132
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=2.5e-8)


def test_a_path_of_any_length_is_printed_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Lines are broken around it, and commands are not broken: its length changes no word."""
    width = len(str(tmp_path)) + 60
    monkeypatch.setenv("COLUMNS", str(width))
    headings, commands = set(), set()
    for letters in range(1, 121, 5):
        path = str(tmp_path / (letters * "q"))
        assert main(["new", path]) == 0
        heading, end, rest = capsys.readouterr().out.partition("each.\n")
        assert all(len(line) <= width or path in line for line in heading.splitlines())
        headings.add(" ".join(f"{heading}{end}".replace(path, "PATH").split()))
        commands.add(rest.partition("as it stands:\n")[2].replace(path, "PATH"))
    assert headings == {
        "PATH: a press with one stop to strike and one to come back to, every line explained; "
        "one drawing, in mm. Change its points, bodies and joints, and check after each."
    }
    assert [line.split()[1:3] for line in commands.pop().splitlines()] == [
        ["check", "PATH"], ["simulate", "PATH"], ["view", "PATH"]
    ]  # fmt: skip
    assert not commands


def test_schemas_lie_beside_what_is_written(tmp_path: Path, press: Mechanism) -> None:
    """That of a drawing, and that of a model; both are those of the documents."""
    whole = export(press, tmp_path / "whole")
    for folder, name in ((Path(press.mesh_folder), "drawing"), (whole, "model")):
        text = (folder / f"{folder.name}.toml").read_text(encoding="utf-8")
        assert text.splitlines()[0] == f"#:schema ./{name}.schema.json"
        shown = (ROOT / "docs" / f"{name}.schema.json").read_text(encoding="utf-8")
        assert (folder / f"{name}.schema.json").read_text(encoding="utf-8") == shown


def test_every_table_of_the_skeleton_is_explained(press: Mechanism) -> None:
    text = Path(press.mesh_folder, "press.toml").read_text(encoding="utf-8")
    tables = re.findall(r"(?m)^(\[\w[^\n]*)$", text)
    assert len(tables) > 6
    for table in tables:
        above = text[: text.index(f"\n{table}")].rstrip().splitlines()[-1]
        assert above.startswith("#") or table == "[stops.buffer]", table


# What `check` advises works when it is pasted.


def advised_by(capsys: pytest.CaptureFixture[str], *words: str) -> list[list[str]]:
    """Commands that `check` ends with, in words."""
    assert main(["check", *words]) == 0
    lines = capsys.readouterr().out.splitlines()
    commands = [line.partition(": nipper-pin ")[2] for line in lines]
    return [shlex.split(command) for command in commands if command]


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("study", "options"),
    [
        ("sweep", "--dry-run"),
        ("identify", "--starts 1 --profiles 0 --workers 1"),
        pytest.param("optimise", "--starts 1 --no-check --workers 1", marks=pytest.mark.slow),
    ],
)
def test_a_study_runs_as_it_is_written(
    study: str, options: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "--study", study, "own.toml"]) == 0
    assert f"nipper-pin {study} own.toml" in capsys.readouterr().out
    assert main([study, "own.toml", *options.split()]) == 0


@pytest.mark.usefixtures("here")
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("name", "transition"),
    [("press", True), ("sieve", False), ("klann", False)],
)
def test_what_is_advised_works(
    name: str, transition: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a folder with a space, with a number changed; a transition only where there is one."""
    folder = f"my machines/{name}"
    drawn = [] if name == "press" else ["--from", name]
    assert main(["new", *drawn, folder]) == 0
    printed = [shlex.split(line) for line in capsys.readouterr().out.splitlines()
               if line.startswith("  nipper-pin ")]  # fmt: skip
    assert [words[2] for words in printed] == [folder] * len(printed)
    assert len(printed) >= 2
    gravity = "gravity_m_s2=9.5"
    capsys.readouterr()
    advised = advised_by(capsys, folder, "--set", gravity, "--speed", "61.5")
    assert [words[:2] for words in advised] == [
        *([["simulate", folder]] if transition else []), ["simulate", folder], ["view", folder]
    ]  # fmt: skip
    for words in advised:
        assert words[2:6] == ["--set", gravity, "--speed", "61.5"]
        assert main(words) == 0
    assert ("--window" in advised[0]) != transition


def test_check_watches_what_is_saved(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Again after each save, be it wrong, not while nothing happens; until Ctrl-C."""
    assert main(["new", "press.toml"]) == 0
    file = here / "press.toml"
    right = file.read_text(encoding="utf-8")
    texts = iter([None, right.replace("A = [-15.0", "A = [-15.O"), None,
                  right.replace("restitution = 0.2 ", "restitution = 0.4 ")])  # fmt: skip
    at = file.stat().st_mtime

    def sleep(_: float) -> None:
        nonlocal at
        text = next(texts, "")
        if text == "":
            raise KeyboardInterrupt
        if text is not None:
            file.write_text(text, encoding="utf-8")
            at += 1.0
            os.utime(file, (at, at))

    monkeypatch.setattr("time.sleep", sleep)
    capsys.readouterr()
    assert main(["check", "press.toml", "--watch", "--drawing", "press.svg"]) == 130
    first, wrong, second, rest = capsys.readouterr().out.split("Watching")
    assert "restitution 0.2" in first
    assert "press.toml" in wrong
    assert "restitution" not in wrong
    assert "stop anvil: restitution 0.4" in second
    assert "restitution" not in rest
    assert (here / "press.svg").is_file()


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
