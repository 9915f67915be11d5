"""The command, as scripts and people use it."""

from __future__ import annotations

import csv
import json
import math
import runpy
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest
from units_shown import rows

import nipper_pin as nip
from nipper_pin import (
    Case,
    Mechanism,
    Window,
    load,
    load_case,
    load_solution,
    record,
    save,
    save_case,
    simulate,
)
from nipper_pin.cli import main
from nipper_pin.cli.compare_sides import Source, told_settings
from nipper_pin.mechanism import known_models

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


@pytest.mark.slow
def test_the_folder_of_a_run(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It stands for its files, and is not replaced by a run of another model."""
    assert main(["simulate", "e62", "--speed", "650", "--out", "run"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[-2] == "written: run"
    assert load_solution(here / "run").case == load_case("run")[1] == Case(speed_rpm=650.0)
    assert main(["simulate", "--case", "run", "--json", "again.json"]) == 0
    assert main(["view", "--solution", "run", "--html", "film.html"]) == 0
    assert capsys.readouterr().out.endswith("written: film.html\n")
    before = {file.name: file.read_bytes() for file in (here / "run").iterdir()}
    assert main(["simulate", "hanging_pendulum", "--out", "run"]) == 2
    assert "run holds a run of e62" in capsys.readouterr().err
    assert {file.name: file.read_bytes() for file in (here / "run").iterdir()} == before


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


# Saved cases beside other options: each changes the run.

BASE = {"--speed": "650", "--set": "preload=10.5", "--restitution": "0.2"}
# The last 3 are about whole turns; the cases of all others are transitions.
BESIDE = [
    ["--set", "springs.steeve.preload_length_mm=9.25"],
    ["--set", "preload=9.25"],
    ["--restitution", "0.1"],
    ["--stiffness", "11000"],
    ["--speed", "500"],
    ["--drive", "inertial"],
    ["--rest-rate", "0.1"],
    ["--tolerance", "1e-9"],
    ["--window", "cycle"],
    ["--cycles", "2"],
    ["--start-index", "20"],
    ["--no-reuse"],
]


def document(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["simulate", *arguments, "--json", "-"]) == 0, capsys.readouterr().err
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    del found["work"]["wall_s"]
    return found


def words(options: dict[str, str]) -> list[str]:
    return [word for pair in options.items() for word in pair]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A case of each window."""
    home = tmp_path_factory.mktemp("cases")
    e62 = load("e62", {"preload": 10.5, "restitution": 0.2})
    return {
        window: str(save_case(e62, Case(speed_rpm=650.0, window=window), home / f"{window}.json"))
        for window in ("transition", "cycle")
    }


@pytest.mark.parametrize("option", BESIDE, ids=" ".join)
def test_an_option_beside_a_case_changes_its_run(
    option: list[str], saved: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """What comes out is what the same options give without the file, and not the saved run."""
    window = "cycle" if BESIDE.index(option) >= len(BESIDE) - 3 else "transition"
    others = {"--window": window, **BASE}
    others.pop(option[0], None)
    case = saved[window]
    beside = document(["--case", case, *option], capsys)
    assert beside == document([*words(others), *option], capsys)
    assert beside != document(["--case", case], capsys)


def test_a_case_can_be_taken_back_to_the_limit_and_to_copies(
    tmp_path: Path, e62: Mechanism, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a case holds can be unset, too."""
    file = save_case(
        e62,
        Case(speed_rpm=450.0, window="cycle", cycles=2, rest_rate=0.5, reuse_cycles=False),
        tmp_path / "case.json",
    )
    back = document(["--case", str(file), "--rest-rate", "limit", "--reuse"], capsys)
    assert back == document(["--window", "cycle", "--cycles", "2"], capsys)


# `compare`: what A and B may be, and what is printed.


def told(line: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["compare", *shlex.split(line)]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def compared(line: str, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
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
        ("--speed 450 520 e62", (450.0, 520.0), {"speed_rpm": (450.0, 520.0)}),
        ("--speed 500 e62 e62", (500.0, 500.0), {}),
        ("e62 --speed 500 e62", (500.0, 500.0), {}),
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
    found = compared(f"{line} --window transition", capsys)
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
    assert settings(compared(line, capsys)) == found


def test_a_change_beside_a_saved_run_is_that_of_its_model(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The machine in the file, changed, gives what the model gives with the same change."""
    monkeypatch.chdir(home)
    saved = compared("before.npz --set-b preload=9.25", capsys)
    fresh = compared("e62 --speed 600 --set-b preload=9.25 --window transition", capsys)
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


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["simulte", "e62"], "did you mean 'simulate'? There are simulate, view"),
        (["xyz"], "no command 'xyz'; There are simulate"),
        (["simulate", "e62", "--spped", "600"], "--spped 600; did you mean '--speed'? -h lists"),
        (["simulate", "e62", "--spped=600"], "did you mean '--speed'?"),
        (["check", "e62", "e63", "e64"], "unrecognized arguments: e63 e64; -h lists the options"),
    ],
)
def test_a_mistyped_word_is_told_with_the_nearest(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_the_module_is_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["nipper_pin", "--version"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("nipper_pin", run_name="__main__")
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"nipper-pin {nip.__version__}\n"
