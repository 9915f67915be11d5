"""Files that an earlier fuzzer found, read again: taken, or refused by one line.

A file that once failed is called ``failed_...`` by what it ended in. For every kind of file that
comes from other people there is a function of a folder and its bytes.
"""

from __future__ import annotations

import json
import re
import shutil
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from refusals import taken
from sweep_studies import taken_up

from nipper_pin import (
    Case,
    Mechanism,
    Resolution,
    Solution,
    load,
    load_case,
    load_solution,
    read_sweep,
    simulate,
)
from nipper_pin.mechanism import find_model
from nipper_pin.reduced.turns import turn_quantities
from nipper_pin.study import identify, optimise
from nipper_pin.study.identify import read_measured
from nipper_pin.study.sweep import read_plan
from nipper_pin.view.scene import solids

HERE = Path(__file__).parent
CORPUS, BASES = HERE / "corpus", HERE / "bases"
MODELS = {"parts": BASES / "parts", "e62": find_model("e62")}
MOST_FILES, MOST_BYTES = 400, 2**20
# One of so many models that can be used is simulated as well, and another one followed by turns.
SIMULATED = 50


def used(mechanism: Mechanism, data: bytes) -> None:
    """What is cheap and what commands do with a model first."""
    repr(mechanism)
    mechanism._repr_html_()
    solids(mechanism)
    chance, rated = zlib.crc32(data) % SIMULATED, mechanism.cylinder.rated_speed_rpm
    if chance == 0:
        fine = Resolution(tolerance=1e-8)
        case = Case(speed_rpm=rated, max_collisions=8, resolution=fine)
        taken(lambda: simulate(mechanism, case))
    elif chance == 1:
        speeds = [0.5 * rated, rated, 3.0 * rated]
        taken(lambda: turn_quantities(mechanism, speed_rpm=speeds, turns=4, last=2))


def model(home: Path, data: bytes, suffix: str, name: str = "") -> bool:
    """A file of a model, that which its first line names, beside the other one."""
    name = name or ("e62" if b"e62" in data[:200] else "parts")
    file = home / name / f"{name}.{suffix}"
    file.write_bytes(data)
    try:
        return taken(lambda: used(load(file.parent), data))
    finally:
        shutil.copyfile(MODELS[name] / file.name, file)


_TABLES = {
    b"coordinate_deg": '[springs.tab]\njoint = "jaw"\nfile = "t.csv"\n',
    b"coordinate_mm": '[springs.tab]\njoint = "steeve"\nfile = "t.csv"\n',
}
_DRIVE = '[drives.tension]\njoint = "tension_shaft"\nlaw = "table"\nfile = "t.csv"\n'


def csv(home: Path, data: bytes) -> bool:
    """A table of a spring or a drive, by its first word."""
    text = (MODELS["e62"] / "e62.toml").read_text(encoding="utf-8")
    (home / "e62" / "t.csv").write_bytes(data)
    head = next((key for key in _TABLES if data.startswith(key)), None)
    if head is None:
        text = re.sub(r"\[drives.tension\].*?(?=\n\[|\n#)", _DRIVE, text, flags=re.DOTALL)
    else:
        text += "\n" + _TABLES[head]
    return model(home, text.encode(), "toml", "e62")


def measured(home: Path, data: bytes) -> bool:
    file = home / "measured.csv"
    file.write_bytes(data)
    return taken(lambda: read_measured(file))


def case(home: Path, data: bytes) -> bool:
    """A saved case; the folder of its model is that of the base."""
    file = home / "case.json"
    file.write_bytes(data.replace(b"@HOME@", str(home).encode()))
    return taken(lambda: used(load_case(file)[0], data))


def npz(home: Path, data: bytes) -> bool:
    """A saved run, and all that is computed of it when it is asked for."""
    file = home / "run.npz"
    file.write_bytes(data)
    read: list[Solution] = []
    if not taken(lambda: read.append(load_solution(file))):
        return False
    taken(lambda: asked(read[0]))
    return True


def asked(solution: Solution) -> None:
    repr(solution)
    solution._repr_html_()
    for question in ("collisions", "phases", "transitions", "errors", "energy"):
        getattr(solution, question)
    assert solution.checks is not None
    start, end = solution.trajectory.span
    solution.trajectory.reactions(0.5 * (start + end))
    for event in solution.events[:4]:
        solution.motion_at(event)
    json.dumps(solution.collisions, default=repr)


def parquet(home: Path, data: bytes) -> bool:
    """A chunk of a sweep, alone and in the folder of its sweep."""
    from nipper_pin.study.sweep.results import Tally
    from nipper_pin.study.sweep.results.chunk_file import check, read_file
    from nipper_pin.study.sweep.results.tally import SUMMARY

    folder = home / "sweep"
    file = folder / "chunks" / "0000000.parquet"
    file.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(BASES / "plan.json", folder / "plan.json")
    file.write_bytes(data)

    def use() -> None:
        table = read_file(file, SUMMARY)
        plan = json.loads((folder / "plan.json").read_bytes())["identity"]
        check(table, file.name, 0, 4, plan)
        Tally().add(table)

    taken(use)
    return taken(lambda: read_sweep(folder).to_frame("pandas"))


def plan(home: Path, data: bytes) -> bool:
    """The record of a sweep's plan: read with its chunks, and gone on with."""
    folder = home / "plan"
    (folder / "chunks").mkdir(parents=True, exist_ok=True)
    shutil.copyfile(BASES / "0000000.parquet", folder / "chunks" / "0000000.parquet")
    planned = read_plan(str(BASES / "sweep.toml"))
    (folder / "plan.json").write_bytes(
        data.replace(b"@IDENTITY@", planned.job.identity.encode())
        .replace(b"@HASH@", planned.hash.encode())
        .replace(b'"@VERSIONS@"', json.dumps(planned.job.versions).encode())
    )
    taken(lambda: repr(read_sweep(folder, most=2)))
    return taken(lambda: taken_up(folder, planned))


def study(home: Path, data: bytes) -> bool:
    """The file of a sweep, a design problem or an identification, by its keys."""
    file = home / "study.toml"
    file.write_bytes(data)
    if re.search(rb"minimise|maximise", data):
        return taken(lambda: optimise.read_problem(file))
    if re.search(rb"targets|measured", data):
        shutil.copyfile(BASES / "rebounds.csv", home / "rebounds.csv")
        return taken(lambda: identify.read_problem(file))
    return taken(lambda: read_plan(str(file)).chunks())


# By the name of a folder of the corpus, what reads its files and what it needs.
TARGETS: dict[str, tuple[Callable[[Path, bytes], bool], str]] = {
    "urdf": (lambda home, data: model(home, data, "urdf"), ""),
    "toml": (lambda home, data: model(home, data, "toml"), ""),
    "csv": (csv, ""), "measured": (measured, ""), "case": (case, ""), "npz": (npz, ""),
    "parquet": (parquet, "pyarrow"), "plan": (plan, "pyarrow"), "study": (study, ""),
}  # fmt: skip


@pytest.mark.parametrize("name", TARGETS)
def test_every_input_is_taken_or_refused_by_one_line(name: str, tmp_path: Path) -> None:
    """A target that took or refused everything would show nothing."""
    read, need = TARGETS[name]
    if need:
        pytest.importorskip(need)
    for base, folder in MODELS.items():
        shutil.copytree(folder, tmp_path / base)
    files = sorted((CORPUS / name).iterdir())
    assert 0 < sum(read(tmp_path, file.read_bytes()) for file in files) < len(files)


def test_the_corpus_has_a_folder_for_each_target_and_is_small() -> None:
    assert {item.name for item in CORPUS.iterdir()} == TARGETS.keys()
    files = [item for item in CORPUS.rglob("*") if item.is_file()]
    assert len(files) <= MOST_FILES
    assert sum(item.stat().st_size for item in files) <= MOST_BYTES
