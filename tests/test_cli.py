"""The command, as scripts and people use it."""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import pytest
from units_shown import rows

from nipper_pin import Case, Window, load, load_solution, record, simulate
from nipper_pin.cli import main

HERE = Path(__file__).parent


def test_json_on_stdout_is_the_record_of_the_run_at_rated_speed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """To the last bit, and nothing else is printed."""
    assert main(["simulate", "--json", "-"]) == 0
    out, err = capsys.readouterr()
    told, own = json.loads(out), record(simulate(load("e62"), Case(speed_rpm=450.0)))
    for document in (told, own):
        del document["work"]["wall_s"]
    assert (told, err) == (json.loads(json.dumps(own)), "")


@pytest.mark.parametrize(
    "given",
    [["--window", "transition"], ["--window=transition"],
     pytest.param(["--out=run"], marks=pytest.mark.slow)],
)  # fmt: skip
def test_the_command_of_whole_turns_writes_over_nothing(
    given: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """The user's own words, as a shell takes them, without the files of this run."""
    monkeypatch.chdir(tmp_path)
    words = ["e62", "--set", "stops.jaw.restitution=0.25", "--json", "a run.json"]
    assert main(["simulate", *words, *given]) == 0
    last = capsys.readouterr().out.rstrip().splitlines()[-1]
    kept = "e62 --set stops.jaw.restitution=0.25"
    assert last == f"Next: nipper-pin simulate {kept} --window cycle"


def test_numbers_with_shortcuts_are_in_the_document(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also one of a link; two whose paths end alike stand there by their whole paths."""
    source = Path(__file__).parents[1] / "models" / "e62"
    folder = tmp_path / "machine"
    shutil.copytree(source, folder)
    text = (folder / "e62.toml").read_text(encoding="utf-8")
    more = 'mass = "links.top_nipper.mass_kg"\nback = "stops.steeve.restitution"\n'
    text = text.replace("[shortcuts]\n", f"[shortcuts]\n{more}")
    (folder / "machine.toml").write_text(text, encoding="utf-8")
    (folder / "e62.toml").unlink()
    (folder / "e62.urdf").rename(folder / "machine.urdf")
    assert main(["simulate", str(folder), "--set", "mass=1.3", "--set", "back=0.1",
                 "--json", "-"]) == 0  # fmt: skip
    case = json.loads(capsys.readouterr().out)["case"]
    assert case["mass_kg"] == 1.3
    assert case["stops.steeve.restitution"] == 0.1
    assert case["stops.jaw.restitution"] == 0.2
    assert "restitution" not in case


@pytest.mark.parametrize(
    "arguments", [[], ["fly"], *(["simulate", "--speed", text] for text in ("fast", "1_0", "٣"))]
)
def test_arguments_that_do_not_parse_give_status_2(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "usage:" in capsys.readouterr().err


def test_what_cannot_be_simulated_gives_status_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A crank that the rocker cannot follow (no Grashof linkage) locks the mechanism on the way."""
    source = Path(__file__).parent / "verification" / "models" / "four_bar"
    folder = tmp_path / "locked"
    folder.mkdir()
    # Crank 70 instead of 30 mm: shortest plus longest link (170) exceed the other two (160).
    text = (source / "four_bar.urdf").read_text()
    x = (0.03**2 + 0.09**2 - 0.07**2) / (2 * 0.03)
    z = (0.09**2 - x**2) ** 0.5
    text = text.replace('<origin xyz="0.03 0 0"/>', '<origin xyz="0.07 0 0"/>')
    text = text.replace("0.05785714285714285 0 0.06893874832348035", f"{x!r} 0 {z!r}")
    text = text.replace("-0.01214285714285715 0 0.06893874832348035", f"{x - 0.03!r} 0 {z!r}")
    (folder / "locked.urdf").write_text(text)
    (folder / "locked.toml").write_text((source / "four_bar.toml").read_text())
    assert main(["simulate", str(folder), "--window", "cycle", "--start-index", "0"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "index" in err
    assert err.count("\n") == 1


@pytest.mark.slow
def test_out_writes_everything_and_the_case_repeats_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Files agree with the solution, and --case gives the same bits again without the model."""
    folder = tmp_path / "run"
    assert main(["simulate", "--speed", "650", "--window", "cycle", "--out", str(folder)]) == 0
    figures = ("motion", "phases", "transition", "impulses", "forces")
    assert {path.name for path in folder.iterdir()} == {
        "case.json", "collisions.csv", "phases.csv", "link_velocities.csv", "motion.csv",
        "solution.npz", *(f"{name}.png" for name in figures),
    }  # fmt: skip
    solution = load_solution(folder / "solution.npz")
    with (folder / "collisions.csv").open(encoding="utf-8", newline="") as file:
        assert list(csv.DictReader(file)) == rows(solution, "collisions.csv")
    capsys.readouterr()
    assert main(["simulate", "--case", str(folder / "case.json"), "--json", "-"]) == 0
    times = [item["rebound_time_s"] for item in json.loads(capsys.readouterr().out)["collisions"]]
    assert times == [item.rebound_time for item in solution.collisions]


def test_many_turns_repeat(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--window", "cycle", "--cycles", "50", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["work"]["turns_computed"] == 1
    one = len(simulate(load("e62"), Case(speed_rpm=450.0, window=Window.CYCLE)).collisions)
    assert len(document["collisions"]) == 50 * one


def test_turns_that_were_not_begun_are_not_computed() -> None:
    case = Case(speed_rpm=450.0, window=Window.CYCLE, cycles=50, max_collisions=2)
    solution = simulate(load("e62"), case)
    assert record(solution)["work"]["turns_computed"] == 1


@pytest.mark.sampled(4)
@pytest.mark.parametrize("turns", [1, 2, 3, 7, 11, 25])
@pytest.mark.parametrize("height_mm", [1.0, 30.0, 1000.0])
def test_a_run_that_ends_with_a_turn_begins_no_other(turns: int, height_mm: float) -> None:
    """A ball strikes at the end of a turn, early or late by round-off, and that strike is one."""
    ball = load(HERE / "strangers" / "ball_e05", {"initial.height.at_mm": height_mm})
    speed = 60.0 * turns / math.sqrt(2e-3 * height_mm / 9.81)
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=turns + 1, max_collisions=1)
    assert record(simulate(ball, case))["work"]["turns_computed"] == turns
