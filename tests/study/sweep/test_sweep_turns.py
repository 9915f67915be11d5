"""Sweeps of whole turns: their rows are those of tables of turns, in files like all others."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from sweep_studies import GEOMETRY, TABLE, plan, stored, study

from nipper_pin import InputError, Mechanism, read_sweep, turn_table
from nipper_pin.cli import main
from nipper_pin.hybrid.result.turns import turn_names
from nipper_pin.mechanism import from_sources, model_folder
from nipper_pin.study.sweep import Plan, run_sweep
from nipper_pin.study.turns import TURNS_PAY_FROM

CYCLE = '[case]\nwindow = "cycle"\nturns = 3\nleast_force_N = 60.0\n'
FEW = TABLE.replace("600", str(TURNS_PAY_FROM))
STEEVE = '[parameters."stops.steeve.restitution"]\nlow = 0.1\nhigh = 0.4\n'


def every(mechanism: Mechanism) -> list[str]:
    return [name for name in turn_names(mechanism) if name != "repeats_after"]


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory, e62: Mechanism) -> tuple[Plan, Path]:
    """The plan of a study of all quantities, and the folder with its one chunk."""
    folder = tmp_path_factory.mktemp("turns")
    found = plan(folder, f"quantities = {every(e62)}\n{CYCLE}{FEW}{STEEVE}")
    return found, stored(folder / "out", found)


def as_planned(found: Plan) -> Mechanism:
    """The machine of the texts that workers are given."""
    job = json.loads(found.job.text())
    folder = model_folder(job["name"], job["folder"])
    return from_sources(job["name"], job["urdf"], job["document"], folder)


def test_rows_are_those_of_a_table(swept: tuple[Plan, Path], e62: Mechanism) -> None:
    """To the last bit; restitutions of both stops are columns of it."""
    found, out = swept
    ((_, rows),) = found.rows(found.chunks())
    chunk = read_sweep(out).table
    table = turn_table(
        as_planned(found), speed_rpm=rows[:, 0],
        restitution={"jaw": rows[:, 1], "steeve": rows[:, 4]},
        stiffness_N_per_m=rows[:, 2], preload_length_mm=rows[:, 3], turns=3, least_force_N=60.0,
    )  # fmt: skip
    assert set(table.engine) == {"reduced"}
    axes = [axis.name for axis in found.axes]
    assert chunk.column_names == [
        "scenario", *axes, "engine", "outcome", "message", "collisions", "premise_holds", "turns",
        "repeats_after", *every(e62),
    ]  # fmt: skip
    for name in ("engine", "outcome"):
        assert chunk[name].to_pylist() == getattr(table, name).tolist()
    assert chunk["message"].to_pylist() == [*table.message]
    for name in ("turns", "repeats_after"):
        assert chunk[name].type == pa.int32()
        assert chunk[name].to_pylist() == getattr(table, name).tolist()
    assert chunk["collisions"].to_pylist() == table.collisions["jaw"].tolist()
    assert chunk["premise_holds"].null_count == len(rows)
    for name in every(e62):
        np.testing.assert_array_equal(chunk[name].to_numpy(), table.quantity(name), err_msg=name)
    assert {name for name in every(e62) if chunk[name].null_count} == set()
    units = {item.name: (item.metadata or {}).get(b"unit", b"").decode() for item in chunk.schema}
    assert units["clamped_time_s"] == "s"
    assert units["largest_gap"] == "rad"
    assert units["impulse_sum_N_s_steeve"] == "N s"
    assert units["rest_index"] == units["collisions_jaw"] == "1"


def test_the_direct_engine_reads_what_is_asked_for(tmp_path: Path) -> None:
    """Few scenarios: its rows, and why it served; the second one does not repeat in time."""
    text = f'quantities = ["largest_gap", "collisions_steeve"]\n{CYCLE}'
    text += "[set]\nstiffness = 3000.0\npreload = 2.0\n"
    found = plan(tmp_path, f"{text}[parameters.speed_rpm]\nvalues = [450.0, 800.0]\n")
    (file,) = (stored(tmp_path / "out", found) / "chunks").iterdir()
    chunk = pq.read_table(file)
    table = turn_table(as_planned(found), speed_rpm=[450.0, 800.0], turns=3)
    assert table.repeats_after.tolist() == chunk["repeats_after"].to_pylist() == [1, 0]
    assert table.turns.tolist() == chunk["turns"].to_pylist()
    assert chunk["engine"].to_pylist() == ["direct", "direct"]
    np.testing.assert_array_equal(chunk["largest_gap"].to_numpy(), table.largest_gap)
    assert chunk["collisions_steeve"].to_pylist() == table.collisions["steeve"].tolist()
    about = json.loads(chunk.schema.metadata[b"nipper_pin"])
    assert about["direct"] == {f"the reduced engine pays from {TURNS_PAY_FROM} cases on": 2}


def test_machines_that_cannot_be_built(tmp_path: Path) -> None:
    """A row without a turn."""
    text = f'{CYCLE}[parameters."points.eccentric_pin.radius_mm"]\nvalues = [5.0, 500.0]\n'
    chunk = read_sweep(stored(tmp_path / "out", plan(tmp_path, text))).table
    assert chunk["outcome"].to_pylist() == ["followed", "failed"]
    assert chunk["turns"].to_pylist() == [1, 0]
    assert np.isnan(chunk["clamped_share"].to_numpy()).tolist() == [False, True]


def test_chunks_of_turns(tmp_path: Path) -> None:
    """Smaller than those of transitions; whole machines where each is another one."""
    sizes = [item.stop - item.start for item in
             plan(tmp_path, CYCLE + TABLE.replace("600", "100_000")).chunks()]  # fmt: skip
    assert len(sizes) == 64
    assert max(sizes) - min(sizes) <= 1
    grid = CYCLE + GEOMETRY.replace("chunk = 4\n", "")
    # Two scenarios of the direct engine a machine, 0.126 s: two machines take the shortest time.
    assert {item.stop - item.start for item in plan(tmp_path, grid).chunks()} <= {2, 4}


def test_a_folder_is_read_and_goes_on_with_its_own_plan_only(
    swept: tuple[Plan, Path], tmp_path: Path, e62: Mechanism
) -> None:
    found, out = swept
    table = read_sweep(out)
    assert table.quantities == tuple(every(e62))
    assert table.stored == table.scenarios == found.scenarios == run_sweep(found, out).found
    for changed in ("turns = 3", "least_force_N = 60.0"):
        text = found.job.study.replace(changed, changed.replace("3", "4").replace("60.", "6."))
        other = plan(tmp_path, text.partition("\n")[2].partition("\n")[2])
        with pytest.raises(InputError, match=f"differ in: {changed.partition(' ')[0]}"):
            run_sweep(other, out)


@pytest.mark.slow
def test_a_study_from_its_file_to_its_figures(tmp_path: Path) -> None:
    """By the command: estimate, rows, the same folder again, a picture of the period."""
    asked = '["clamped_share", "largest_torque_N_m_pendulum"]'
    text = f"quantities = {asked}\n{CYCLE}{FEW}"
    file, out = study(tmp_path, text), str(tmp_path / "out")
    assert main(["sweep", file, "--dry-run"]) == 0
    stored(Path(out), plan(tmp_path, text))
    assert main(["sweep", file, "--out", out, "--workers", "1"]) == 0
    rows = read_sweep(out)
    assert rows.stored == TURNS_PAY_FROM
    assert set(rows.table["engine"].to_pylist()) == {"reduced"}
    torque = rows.table["largest_torque_N_m_pendulum"]
    assert rows.table.schema.field("largest_torque_N_m_pendulum").metadata == {b"unit": b"N m"}
    assert min(torque.to_pylist()) > 10.0
    for name in ("clamped_share", "repeats_after", "turns"):
        assert main(["plot", out, "--quantity", name]) == 0
        assert (tmp_path / "out" / "plots" / f"main_effects_{name}.svg").is_file()
    assert main(["plot", out, "--quantity", "premise_holds"]) == 2


def test_numbers_of_turns_are_whole(swept: tuple[Plan, Path], tmp_path: Path) -> None:
    """Of text they are damage; a parameter of another sweep may have their names."""
    out = tmp_path / "out"
    shutil.copytree(swept[1], out)
    (file,) = (out / "chunks").iterdir()
    whole = pq.read_table(file)
    for kind, right in ((pa.string(), False), (pa.float64(), True)):
        place = whole.column_names.index("turns")
        pq.write_table(whole.set_column(place, "turns", whole["turns"].cast(kind)), file)
        if right:
            assert read_sweep(out).table["turns"].to_pylist() == whole["turns"].to_pylist()
        else:
            with pytest.raises(InputError, match="'turns'"):
                read_sweep(out)
