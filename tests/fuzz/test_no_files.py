"""What has a file's name and is none: a pipe that nobody fills, and a device that never ends."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from refusals import answer

from nipper_pin import Case, load, save, save_case, simulate
from nipper_pin.mechanism import find_model

BASES = Path(__file__).parent / "bases"
SCRIPTS = Path(__file__).parents[2] / "scripts"
# What stands in the place of a file, and what it is called.
NONE: dict[str, tuple[Callable[[Path], object], str]] = {
    "a pipe": (os.mkfifo, "a named pipe"),
    "a folder": (Path.mkdir, "a folder"),
    "a link to a pipe": (lambda path: path.symlink_to("pipe"), "a named pipe"),
    "a link to a folder": (lambda path: path.symlink_to("."), "a folder"),
    "a link to what never ends": (lambda path: path.symlink_to("/dev/zero"), "a device"),
    "a link that leads nowhere": (lambda path: path.symlink_to("gone"), "nowhere"),
    "links in a circle": (lambda path: path.symlink_to(path.name), "circle"),
}
# Each with the file of the folder that is none, and what then reads it.
READ = [
    ("model/model.toml", "check model"), ("model/model.urdf", "check model"),
    ("other/any.toml", "check other"), ("other/any.urdf", "check other"),
    ("other/any.toml", "check other/any.toml"),
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


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a file of every kind that is read."""
    home = tmp_path_factory.mktemp("place")
    pendulum = find_model("hanging_pendulum")
    for name, base in (("model", pendulum), ("other", pendulum), ("parts", BASES / "parts")):
        shutil.copytree(base, home / name)
        for kind in ("urdf", "toml"):
            called = "any" if name == "other" else name
            (home / name / f"{base.name}.{kind}").rename(home / name / f"{called}.{kind}")
    with (home / "parts" / "parts.toml").open("a") as stream:
        stream.write('[springs.table]\njoint = "h2"\nfile = "rates.csv"\n')
    (home / "parts" / "rates.csv").write_text("coordinate_deg,torque_N_m\n-9,-1\n9,1\n")
    for name in ("optimise_rebound.toml", "identify_camera.toml", "identify_camera_measured.csv"):
        shutil.copy(SCRIPTS / name, home)
    shutil.copy(BASES / "sweep.toml", home)
    (home / "results" / "chunks").mkdir(parents=True)
    shutil.copy(BASES / "plan.json", home / "results")
    shutil.copy(BASES / "0000000.parquet", home / "results" / "chunks")
    machine, case = load("hanging_pendulum"), Case(speed_rpm=60.0, max_collisions=1)
    save_case(machine, case, home / "case.json")
    save(simulate(machine, case), home / "run.npz")
    return home


@pytest.mark.parametrize("kind", NONE)
@pytest.mark.parametrize(("name", "words"), READ)
def test_what_is_no_file_is_refused(
    name: str, words: str, kind: str, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At once and in a sentence, whoever reads it."""
    monkeypatch.chdir(place)
    file, aside = place / name, place / "aside"
    make, called = NONE[kind]
    file.rename(aside)
    os.mkfifo(file.with_name("pipe"))
    make(file)
    status, _, err = answer(words.split())
    file.rmdir() if file.is_dir() and not file.is_symlink() else file.unlink()
    file.with_name("pipe").unlink()
    aside.rename(file)
    assert status in {1, 2}
    assert err.startswith("nipper-pin: ")
    assert Path(name).name in err
    # Of a model it is told what it is, if it neither leads out of the folder nor is one itself.
    otherwise = ("stays inside it", "in the model folder", "any.toml.urdf is missing")
    assert called in err or not words.startswith("check") or any(item in err for item in otherwise)
    assert err.count("\n") == 1
