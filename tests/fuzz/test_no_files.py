"""What has a file's name and is none: a pipe that nobody fills, and a device that never ends."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from refusals import answer

from nipper_pin import Case, load, save, save_case, simulate
from nipper_pin.mechanism import find_model

BASES = Path(__file__).parent / "bases"
SCRIPTS = Path(__file__).parents[2] / "scripts"
NONE = ("pipe", "link to a pipe", "endless", "link to a folder")
# Each with the file of the folder that is none, and what then reads it.
READ = [
    ("model/model.toml", "check model"), ("model/model.urdf", "check model"),
    ("parts/rates.csv", "check parts"), ("parts/meshes/tetrahedron.stl", "check parts"),
    ("model/model.toml", "simulate model"),
    ("model/model.toml", "compare model model"),
    ("case.json", "simulate --case case.json"),
    ("run.npz", "view --solution run.npz --html page.html"),
    ("run.npz", "compare run.npz run.npz"),
    ("sweep.toml", "sweep sweep.toml --out new"), ("sweep.toml", "sweep sweep.toml --dry-run"),
    ("results/plan.json", "sweep sweep.toml --out results"),
    ("results/plan.json", "plot results"),
    ("results/chunks/0000000.parquet", "plot results"),
    ("optimise_rebound.toml", "optimise optimise_rebound.toml --out new"),
    ("identify_camera.toml", "identify identify_camera.toml"),
    ("identify_camera_measured.csv", "identify identify_camera.toml"),
]  # fmt: skip


@pytest.fixture(autouse=True)
def in_time() -> Iterator[None]:
    """Whoever waits for a pipe is woken."""

    def woken(*_: object) -> None:
        message = "it waits, or reads for ever"
        raise TimeoutError(message)

    before = signal.signal(signal.SIGALRM, woken)
    signal.alarm(30)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file of every kind that is read."""
    for name, home in (("model", find_model("hanging_pendulum")), ("parts", BASES / "parts")):
        shutil.copytree(home, tmp_path / name)
        for kind in ("urdf", "toml"):
            (tmp_path / name / f"{home.name}.{kind}").rename(tmp_path / name / f"{name}.{kind}")
    with (tmp_path / "parts" / "parts.toml").open("a") as stream:
        stream.write('[springs.table]\njoint = "h2"\nfile = "rates.csv"\n')
    (tmp_path / "parts" / "rates.csv").write_text("coordinate_deg,torque_N_m\n-9,-1\n9,1\n")
    for name in ("optimise_rebound.toml", "identify_camera.toml", "identify_camera_measured.csv"):
        shutil.copy(SCRIPTS / name, tmp_path)
    shutil.copy(BASES / "sweep.toml", tmp_path)
    (tmp_path / "results" / "chunks").mkdir(parents=True)
    shutil.copy(BASES / "plan.json", tmp_path / "results")
    shutil.copy(BASES / "0000000.parquet", tmp_path / "results" / "chunks")
    machine, case = load("hanging_pendulum"), Case(speed_rpm=60.0, max_collisions=1)
    save_case(machine, case, tmp_path / "case.json")
    save(simulate(machine, case), tmp_path / "run.npz")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def put(file: Path, kind: str) -> None:
    """Something that is no file in the place of a file."""
    file.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(file)
    elif kind == "link to a pipe":
        os.mkfifo(file.with_name("elsewhere"))
        file.symlink_to("elsewhere")
    else:
        file.symlink_to("/dev/zero" if kind == "endless" else "/tmp")


@pytest.mark.parametrize("kind", NONE)
@pytest.mark.parametrize(("name", "words"), READ)
def test_what_is_no_file_is_refused(name: str, words: str, kind: str, place: Path) -> None:
    """At once and in a sentence, whoever reads it."""
    put(place / name, kind)
    status, _, err = answer(words.split())
    assert status in {1, 2}
    assert err.startswith("nipper-pin: ")
    assert Path(name).name in err
    assert err.count("\n") == 1
