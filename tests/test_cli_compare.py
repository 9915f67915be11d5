"""``nipper-pin compare`` as it is typed: what A and B may be, what is printed, what is refused."""

from __future__ import annotations

import csv
import json
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest

from nipper_pin import Case, load, save, simulate
from nipper_pin.cli import main
from nipper_pin.cli.compare_sides import Source, told_settings
from nipper_pin.mechanism import known_models

BRIEF = ["--window", "transition"]


def told(line: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["compare", *shlex.split(line)]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def document(line: str, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    return json.loads(told(f"{line} --json -", capsys))


def settings(found: dict[str, Any]) -> list[tuple[str, float]]:
    return [(found[side]["model"], found[side]["speed_rpm"]) for side in ("a", "b")]


def restitutions(found: dict[str, Any]) -> dict[str, tuple[float, float]]:
    return {item["path"]: (item["a"], item["b"]) for item in found["changes"]}


JAW, SPRING = "stops.jaw.restitution", "springs.steeve.stiffness_N_per_m"
PRELOAD = "springs.steeve.preload_length_mm"


@pytest.mark.parametrize(
    ("line", "speeds", "changes"),
    [
        ("", (450.0, 450.0), {}),
        ("e62 --speed 500", (500.0, 500.0), {}),
        ("e62 --speed 450 520", (450.0, 520.0), {"speed_rpm": (450.0, 520.0)}),
        ("--speed 450 520 e62", (450.0, 520.0), {"speed_rpm": (450.0, 520.0)}),
        ("--speed 500 e62 e62", (500.0, 500.0), {}),
        ("e62 --speed 500 e62", (500.0, 500.0), {}),
        ("e62 --set-a speed=450 --set-b speed=520", (450.0, 520.0), {"speed_rpm": (450.0, 520.0)}),
        ("e62 --set-b preload=9.25", (450.0, 450.0), {PRELOAD: (11.0, 9.25)}),
        ("e62 --restitution 0.1 0.3 --set preload=9", (450.0, 450.0), {JAW: (0.1, 0.3)}),
        ("e62 --stiffness 9000 11000", (450.0, 450.0), {SPRING: (9000.0, 11000.0)}),
        ("e62 --drive held inertial e62", (450.0, 450.0), {"drive": ("held", "inertial")}),
    ],
)
def test_settings_of_one_model(
    line: str,
    speeds: tuple[float, float],
    changes: dict[str, tuple[float, float]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One value is of both, two are of A and of B; words behind numbers are models again."""
    found = document(f"{line} {shlex.join(BRIEF)}", capsys)
    assert settings(found) == [("e62", speeds[0]), ("e62", speeds[1])]
    assert restitutions(found) == changes


def test_turns_and_drives_of_a_side(capsys: pytest.CaptureFixture[str]) -> None:
    assert told_settings(Source("e62", "", (), "", "inertial"), ["--cycles", "2"]) == [
        "simulate", "e62", "--cycles", "2", "--drive", "inertial",
    ]  # fmt: skip
    with pytest.raises(SystemExit):
        main(["compare", "--drive", "e62"])
    assert "invalid drive: 'e62' (write held or inertial, " in capsys.readouterr().err


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the model, and a saved run of it as a file and in a folder."""
    folder = tmp_path_factory.mktemp("compare")
    shutil.copytree(known_models()["e62"], folder / "mine")
    for suffix in ("toml", "urdf"):
        (folder / "mine" / f"e62.{suffix}").rename(folder / "mine" / f"mine.{suffix}")
    run = simulate(load("e62"), Case(speed_rpm=600.0))
    save(run, folder / "before.npz")
    (folder / "out").mkdir()
    save(run, folder / "out" / "solution.npz")
    return folder


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("e62 mine/mine.toml --window transition", [("e62", 450.0), ("mine", 450.0)]),
        ("mine e62 --window transition", [("mine", 450.0), ("e62", 450.0)]),
        ("before.npz out", [("e62", 600.0), ("e62", 600.0)]),
        # A model beside a saved run takes over its window and its speed.
        ("before.npz mine", [("e62", 600.0), ("mine", 600.0)]),
        ("mine before.npz", [("mine", 600.0), ("e62", 600.0)]),
        ("before.npz --set-b speed=620", [("e62", 600.0), ("e62", 620.0)]),
    ],
)
def test_models_files_and_saved_runs(
    line: str,
    found: list[tuple[str, float]],
    home: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(home)
    assert settings(document(line, capsys)) == found


def test_a_change_beside_a_saved_run_is_that_of_its_model(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The machine in the file, changed, gives what the model gives with the same change."""
    monkeypatch.chdir(home)
    saved = document("before.npz --set-b preload=9.25", capsys)
    fresh = document("e62 --speed 600 --set-b preload=9.25 --window transition", capsys)
    assert saved["rows"] == fresh["rows"]
    assert restitutions(saved) == {PRELOAD: (11.0, 9.25)}


def test_the_command_after_a_film_shows_the_same_window(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A machine that rides on its cam has no transition: the turn that was compared is shown."""
    folder = Path(__file__).parent / "strangers" / "ecc_jump_stopname"
    text = told(f"{folder} --speed 600 650 --html {tmp_path / 'both.html'}", capsys)
    following = text.splitlines()[-1].removeprefix("Next: nipper-pin ")
    assert following == f"simulate {folder} --window cycle --speed 650.0"
    assert main(shlex.split(following)) == 0


@pytest.mark.slow
def test_files_of_a_comparison(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The table by the names of files in SI units, and the curves as pictures."""
    line = f"e62 --speed 450 520 --window transition --json {tmp_path / 'table.json'}"
    text = told(f"{line} --out {tmp_path / 'out'}", capsys)
    assert f"table and curves: {tmp_path / 'out'}\ndocument: {tmp_path / 'table.json'}\n" in text
    found = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))
    with (tmp_path / "out" / "comparison.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["name"] for row in rows] == [row["name"] for row in found["rows"]]
    for row, other in zip(rows, found["rows"], strict=True):
        assert float(row["a"]) == other["a"]
        assert float(row["difference_percent"]) == other["difference_percent"]
    assert (tmp_path / "out" / "curves.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / "out" / "curves.svg").read_text(encoding="utf-8")
