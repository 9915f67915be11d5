"""``nipper-pin verify``: what is whole is called whole, and every damage of it is found.

Damage is done to bytes, which the checks never see as such; that a changed byte is told is the
whole of the promise, so each is tried at places drawn at random.
"""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, load, load_solution, save, simulate
from nipper_pin.cli import main
from nipper_pin.errors import NipperError

STUDY = """
format = 1
chunk = 4
model = "e62"
quantities = ["duration_s"]
[case]
speed_rpm = 650.0
[parameters.restitution]
values = [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55]
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with its tables, and a sweep of three chunks."""
    folder = tmp_path_factory.mktemp("saved")
    assert main(["simulate", "e62", "--speed", "650", "--out", str(folder / "run")]) == 0
    (folder / "study.toml").write_text(STUDY)
    words = ["sweep", str(folder / "study.toml"), "--out", str(folder / "sweep"), "--workers", "1"]
    assert main(words) == 0
    return folder


@pytest.fixture
def saved(home: Path, tmp_path: Path) -> Path:
    for name in ("run", "sweep"):
        shutil.copytree(home / name, tmp_path / name)
    return tmp_path


def answer(path: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    capsys.readouterr()
    status = main(["verify", str(path)])
    out, err = capsys.readouterr()
    return status, out, err


@pytest.mark.parametrize(
    ("name", "said"),
    [("run", "run (e62, 650 r/min, transition, 6 collisions"), ("run/case.json", "case (e62, 650"),
     ("run/solution.npz", "run (e62"), ("sweep", "sweep (10 of 10 scenarios)")],
)  # fmt: skip
def test_what_is_whole(
    name: str, said: str, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = answer(saved / name, capsys)
    assert (status, err) == (0, "")
    assert said in " ".join(out.split())
    assert "made by nipper-pin 0.1.0" in " ".join(out.split())
    assert out.endswith("\nwhole\n")


@pytest.mark.parametrize("name", ["sweep/plan.json"])
def test_every_byte_of_a_sealed_file_counts(
    name: str, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One bit of a letter or digit: in JSON, blanks between values may change and say the same."""
    file = saved / name
    content, random = file.read_bytes(), np.random.default_rng(7)
    places = [k for k, byte in enumerate(content) if file.suffix != ".json" or byte > 32]
    for place in random.choice(places, 40, replace=False):
        damaged = bytearray(content)
        damaged[place] ^= 1 << random.integers(5)
        file.write_bytes(damaged)
        status, _, err = answer(saved / name.split("/chunks")[0].replace("/plan.json", ""), capsys)
        assert status == 1, (place, bytes(damaged[place - 20 : place + 20]))
        assert err.count("\n") == 1


def test_a_damaged_run_is_told_or_has_the_same_numbers(
    saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A few bytes of an archive say when it was packed; all others are content."""
    file = saved / "run/solution.npz"
    whole = load_solution(file)
    content, random = file.read_bytes(), np.random.default_rng(8)
    told = 0
    for place in random.integers(len(content), size=60):
        damaged = bytearray(content)
        damaged[place] ^= 1 << random.integers(8)
        file.write_bytes(damaged)
        if answer(file, capsys)[0] == 1:
            told += 1
            continue
        again = load_solution(file)
        for one, other in zip(whole.segments, again.segments, strict=True):
            for a, b in zip(one.panels, other.panels, strict=True):
                assert a.q.tobytes() == b.q.tobytes()
                assert a.v.tobytes() == b.v.tobytes()
    assert told > 50


@pytest.mark.slow
def test_files_of_two_runs(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table, a case or a solution of another run in the folder of one."""
    other = saved / "other"
    assert main(["simulate", "e62", "--speed", "640", "--out", str(other)]) == 0
    for name, said in (
        ("motion.csv", "motion.csv beside it is not the table of this run"),
        ("collisions.csv", "collisions.csv beside it is not"),
        ("case.json", "solution.npz is a run of another case than case.json"),
        ("solution.npz", "solution.npz is a run of another case than case.json"),
    ):
        before = (saved / "run" / name).read_bytes()
        shutil.copy(other / name, saved / "run" / name)
        status, _, err = answer(saved / "run", capsys)
        assert status == 1
        assert said in err
        (saved / "run" / name).write_bytes(before)
    assert answer(saved / "run", capsys)[0] == 0


@pytest.mark.parametrize("how", ["missing", "a folder", "a link", "a link to nothing", "a pipe"])
@pytest.mark.parametrize(
    "name", ["collisions.csv", "phases.csv", "link_velocities.csv", "motion.csv", "solution.npz",
             "case.json"],
)  # fmt: skip
def test_a_run_without_one_of_its_files(
    name: str, how: str, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = saved / "run" / name
    file.rename(saved / "elsewhere")
    if how == "a folder":
        file.mkdir()
    elif how == "a pipe":
        os.mkfifo(file)
    elif how != "missing":
        file.symlink_to(saved / ("elsewhere" if how == "a link" else "nothing"))
    status, out, err = answer(saved / "run", capsys)
    assert status == 1
    assert "whole" not in out
    assert f"{name} is {'missing' if how == 'missing' else 'no file of its own'}" in err


def test_a_run_and_a_case_alone_are_whole(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where no tables are beside them: Python may have saved them."""
    for file in (saved / "run").iterdir():
        if file.name not in {"solution.npz", "case.json"}:
            file.unlink()
    assert answer(saved / "run", capsys)[0] == 0
    (saved / "run/case.json").unlink()
    assert answer(saved / "run", capsys)[0] == 0


def test_one_number_of_a_table(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The ninth digit of the time of a collision; the sixteenth may be another machine's."""
    file = saved / "run/collisions.csv"
    lines = file.read_text().splitlines()
    cells = lines[2].split(",")
    for factor, expected in ((1.0 + 1e-8, 1), (1.0 + 1e-15, 0)):
        cells[2] = repr(float(lines[2].split(",")[2]) * factor)
        file.write_text("\n".join([*lines[:2], ",".join(cells), *lines[3:]]) + "\n")
        # The column goes on to times of the same size, so its largest number is near this one.
        assert answer(saved / "run", capsys)[0] == expected


def test_a_sweep_that_is_not_finished(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (saved / "sweep/chunks/0000001.parquet").unlink()
    status, out, err = answer(saved / "sweep", capsys)
    assert status == 1
    assert "7 of 10 scenarios" in " ".join(out.split())
    assert "3 of 10 scenarios are missing" in err
    # The chunk of another place is none of these.
    shutil.copy(saved / "sweep/chunks/0000000.parquet", saved / "sweep/chunks/0000001.parquet")
    assert "0000001.parquet: holds scenarios of another chunk" in answer(saved / "sweep", capsys)[2]


def test_a_case_may_be_edited(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is a text that is checked as models are; the run beside it is of another one then."""
    file = saved / "run/case.json"
    document = json.loads(file.read_text())
    document["case"]["speed_rpm"] = 600.0
    file.write_text(json.dumps(document))
    assert main(["simulate", "--case", str(file)]) == 0
    assert answer(file, capsys)[0] == 0
    status, _, err = answer(saved / "run", capsys)
    assert status == 1
    assert "solution.npz is a run of another case than case.json" in err
    document["case"]["speed_rpm"] = -600.0
    file.write_text(json.dumps(document))
    assert answer(file, capsys)[0] == 1


def test_json_says_the_same(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (saved / "sweep/chunks/0000002.parquet").write_bytes(b"")
    assert main(["verify", str(saved / "sweep"), "--json", str(saved / "found.json")]) == 1
    found = json.loads((saved / "found.json").read_text())
    assert found["whole"] is False
    assert [part["kind"] for part in found["parts"]] == ["sweep"]
    assert len(found["problems"]) == 2
    assert all(problem in capsys.readouterr().err for problem in found["problems"][:1])


def test_what_is_not_ours(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (saved / "text.json").write_text("[]")
    (saved / "empty").mkdir()
    for name, expected in (("nothing", 2), ("empty", 2), ("text.json", 1)):
        status, _, err = answer(saved / name, capsys)
        assert status == expected, name
        assert err.count("\n") == 1


def test_old_files_name_their_version() -> None:
    for format_ in (2, 3):
        for suffix in ("npz", "json"):
            file = Path(__file__).parent / f"reference/saved/format_{format_}.{suffix}"
            assert main(["verify", str(file)]) == 0


def test_a_run_that_fails_its_own_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every checksum is right, and the numbers are not."""
    run = simulate(load("e62"), Case(speed_rpm=650.0))
    run.segments[0].panels[0].q[:, 1] += 1e-3
    file = save(run, tmp_path / "run.npz")
    assert not isinstance(load_solution(file), NipperError)
    status, _, err = answer(file, capsys)
    assert status == 1
    assert "the closures gape" in err
