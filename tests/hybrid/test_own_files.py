"""Saved runs and cases: no file of the reader's disk is used but the meshes they were saved with.

Also the promise for old files: one of the format stays in the repository, with its numbers written
here by hand.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.mechanism import find_model

SAVED = Path(__file__).parents[1] / "reference/saved"
TIMES = [float.fromhex("0x1.99aad7df37aafp-5"), float.fromhex("0x1.acdcf58a9b63bp-5")]


def edited(file: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    document = json.loads(file.read_text())
    change(document)
    file.write_text(json.dumps(document))
    return file


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A folder of ours with a machine whose meshes are its own."""
    folder = tmp_path / "e62"
    shutil.copytree(find_model("e62"), folder)
    return folder


def test_a_mesh_of_the_reader_is_not_read(machine: Path, tmp_path: Path) -> None:
    """A file that names another folder, or another file of the same one."""
    private = tmp_path / "private"
    private.mkdir()
    shutil.copy(machine / "meshes/spring.stl", private / "secret.stl")
    case = nip.save_case(nip.load(machine), nip.Case(speed_rpm=650.0), tmp_path / "case.json")
    nip.load_case(case)

    def another(document: dict[str, Any]) -> None:
        source = document["mechanism"]
        source["folder"] = str(private)
        source["urdf"] = source["urdf"].replace("meshes/rockers.stl", "secret.stl")

    with pytest.raises(nip.NipperError, match=r"secret\.stl in .* is not the mesh"):
        nip.load_case(edited(case, another))


def test_a_mesh_that_has_changed_is_not_shown(
    machine: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = nip.save(nip.simulate(nip.load(machine), nip.Case(speed_rpm=650.0)), tmp_path / "run.npz")
    assert nip.load_solution(run).mechanism.mesh_folder == str(machine)
    with (machine / "meshes/spring.stl").open("ab") as stream:
        stream.write(b"\0")
    page = tmp_path / "page.html"
    assert main(["view", "--solution", str(run), "--html", str(page)]) == 2
    assert "meshes/spring.stl" in capsys.readouterr().err
    assert not page.exists()
    # Without its files the run is what it was; only its picture is plainer.
    shutil.rmtree(machine)
    assert nip.load_solution(run).events


def test_a_table_of_the_reader_is_not_read(tmp_path: Path) -> None:
    """Its first line would be shown by the refusal."""
    (tmp_path / "secret.csv").write_text("the first line of a secret\n")
    case = nip.save_case(
        nip.load("hanging_pendulum"), nip.Case(speed_rpm=300.0), tmp_path / "case.json"
    )

    def another(document: dict[str, Any]) -> None:
        document["mechanism"]["folder"] = str(tmp_path)
        document["mechanism"]["description"]["springs"] = {
            "tab": {"joint": "lid", "file": "secret.csv"}
        }

    with pytest.raises(nip.NipperError, match=r"springs\.tab names a file") as refused:
        nip.load_case(edited(case, another))
    assert "secret" not in refused.value.message


def test_old_files_are_read() -> None:
    """Every number as it was written."""
    run = nip.load_solution(SAVED / "format_3.npz")
    assert [event.t for event in run.events] == TIMES
    assert [hit.energy_lost for hit in run.collisions] == [
        0.13213468424623176, 0.00529061240520938,
    ]  # fmt: skip
    mechanism, case = nip.load_case(SAVED / "format_3.json")
    assert (mechanism.name, case.speed_rpm, case.cycles) == ("hanging_pendulum", 300.0, 2)
    assert [event.t for event in nip.simulate(mechanism, case).events] == pytest.approx(
        TIMES, abs=1e-13
    )
