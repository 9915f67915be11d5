"""The command, as scripts and people use it."""

from __future__ import annotations

import csv
import json
import math
import runpy
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from units_shown import rows

import nipper_pin as nip
from nipper_pin import (
    Case,
    Window,
    load,
    load_case,
    load_solution,
    record,
    simulate,
)
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


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    "given",
    [["--window", "transition"], ["--window=transition"],
     pytest.param(["--out=run"], marks=pytest.mark.slow)],
)  # fmt: skip
def test_the_command_of_whole_turns_writes_over_nothing(
    given: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """The user's own words, as a shell takes them, without the files of this run."""
    words = ["e62", "--set", "stops.jaw.restitution=0.25", "--json", "a run.json"]
    assert main(["simulate", *words, *given]) == 0
    last = capsys.readouterr().out.rstrip().splitlines()[-1]
    kept = "e62 --set stops.jaw.restitution=0.25"
    assert last == f"Next: nipper-pin simulate {kept} --window cycle"


def test_a_model_that_a_new_value_mends(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its own number is none to compare with, and no reason to refuse the new one."""
    folder = tmp_path / "machine"
    nip.export(load("e62"), folder)
    file = folder / "machine.toml"
    text = file.read_text(encoding="utf-8")
    worse = text.replace("stiffness_N_per_m = 9000.0", "stiffness_N_per_m = -9000.0")
    assert worse != text
    file.write_text(worse, encoding="utf-8")
    assert main(["simulate", str(folder)]) == 2
    for given in (["--stiffness", "9000"], ["--set", "springs.steeve.stiffness_N_per_m=9"]):
        assert main(["simulate", str(folder), *given]) == 0
    capsys.readouterr()


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


@pytest.mark.parametrize(("words", "completed"), [
    ("sim", "simulate"), ("simulate --rest-", "--rest-rate"), ("view --window c", "cycle"),
    ("check pre", "press.toml"), ("simulate --out ou", "out"), ("plot --no", None),
])  # fmt: skip
def test_a_shell_completes(
    words: str, completed: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the script that the command prints, in a real bash."""
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["--print-completion", "bash"])
    (tmp_path / "press.toml").touch()
    (tmp_path / "out").mkdir()
    asked = f"COMP_WORDS=(nipper-pin {words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))"
    script = f"{capsys.readouterr().out}\n{asked}\n_shtab_nipper_pin\necho ${{COMPREPLY[@]}}"
    run = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert run.stderr == ""
    assert run.stdout.split() == ([] if completed is None else [completed])


def test_what_cannot_be_simulated_gives_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    """A crank that the rocker cannot follow (no Grashof linkage) locks the mechanism on the way.

    Crank 70 instead of 30 mm: shortest plus longest link (170) exceed the other two (160).
    """
    line = f"{HERE / 'verification/models/four_bar'} --set points.crank_pin.radius_mm=70"
    assert main(["simulate", *line.split(), "--window", "cycle", "--start-index", "0"]) == 1
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "index" in err


@pytest.mark.slow
def test_out_writes_a_folder_that_stands_for_its_files(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They agree with the solution, and the case repeats its bits without the model.

    A run of another model does not replace it.
    """
    assert main(["simulate", "--speed", "650", "--window", "cycle", "--out", "run"]) == 0
    assert capsys.readouterr().out.splitlines()[-2] == "written: run"
    figures = ("motion", "phases", "transition", "impulses", "forces")
    before = {path.name: path.read_bytes() for path in (here / "run").iterdir()}
    assert before.keys() == {
        "case.json", "collisions.csv", "phases.csv", "link_velocities.csv", "motion.csv",
        "solution.npz", *(f"{name}.png" for name in figures),
    }  # fmt: skip
    solution = load_solution("run")
    assert solution.case == load_case("run")[1] == Case(speed_rpm=650.0, window=Window.CYCLE)
    text = before["collisions.csv"].decode()
    assert [*csv.DictReader(text.splitlines())] == rows(solution, "collisions.csv")
    assert main(["simulate", "--case", "run", "--json", "-"]) == 0
    times = [item["rebound_time_s"] for item in json.loads(capsys.readouterr().out)["collisions"]]
    assert times == [item.rebound_time for item in solution.collisions]
    assert main(["view", "--solution", "run", "--html", "film.html"]) == 0
    assert capsys.readouterr().out.endswith("written: film.html\n")
    assert main(["simulate", "hanging_pendulum", "--out", "run"]) == 2
    assert "run holds a run of e62" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in (here / "run").iterdir()} == before


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


@pytest.mark.usefixtures("here")
def test_the_command_after_a_film_shows_the_same_window(capsys: pytest.CaptureFixture[str]) -> None:
    """A machine that rides on its cam has no transition: the turn that was compared is shown."""
    folder = HERE / "strangers" / "ecc_jump_stopname"
    for line, shown in (
        (f"{folder} --speed 600 650", f"{folder} --window cycle --speed 650.0"),
        ("e62 --cycles 2 --drive held inertial", "e62 --window cycle --cycles 2 --drive inertial"),
    ):
        assert main(["compare", *line.split(), "--html", "both.html"]) == 0
        following = capsys.readouterr().out.splitlines()[-1].removeprefix("Next: nipper-pin ")
        assert following == f"simulate {shown}"
    assert main(shlex.split(following)) == 0


@pytest.mark.slow
def test_files_of_a_comparison(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The table by the names of files in SI units, and the curves as pictures."""
    line = f"e62 --speed 450 520 --window transition --json {tmp_path / 'table.json'}"
    assert main(["compare", *line.split(), "--out", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    assert f"written: {tmp_path / 'out'}\nwritten: {tmp_path / 'table.json'}\n" in text
    found = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))
    with (tmp_path / "out" / "comparison.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    told = [{key: "" if value is None else str(value) for key, value in row.items()}
            for row in found["rows"]]  # fmt: skip
    assert rows == told
    assert (tmp_path / "out" / "curves.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / "out" / "curves.svg").read_text(encoding="utf-8")


def test_the_module_is_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = f"nipper-pin {nip.__version__}\n"
    for words, status, printed in ((["--version"], 0, said), ([], 2, "")):
        monkeypatch.setattr("sys.argv", ["nipper_pin", *words])
        with pytest.raises(SystemExit) as ended:
            runpy.run_module("nipper_pin", run_name="__main__")
        assert ended.value.code == status
        assert capsys.readouterr().out == printed
