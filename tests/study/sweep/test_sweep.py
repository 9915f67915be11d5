"""Sweeps: results against single runs, who computes them, and what survives an accident.

Rows of whole turns are those of tables of turns, in files like all others.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from sweep_studies import (
    CYCLE,
    GEOMETRY,
    TABLE,
    chunk_files,
    plan,
    started,
    stored,
    study,
    wait_for,
)
from waiting import notes

from nipper_pin import Case, InputError, Mechanism, load, read_sweep, simulate, turn_table
from nipper_pin.cli import main
from nipper_pin.hybrid.result.turns import turn_names
from nipper_pin.mechanism import find_model, from_sources, model_folder
from nipper_pin.study.folders import alone_in
from nipper_pin.study.sweep import Plan, sweep
from nipper_pin.study.turns import TURNS_PAY_FROM
from nipper_pin.view.progress import progress
from tests.refusals.bases import model

# --- results -------------------------------------------------------------------------------------


def test_rows_are_what_single_runs_say(tmp_path: Path) -> None:
    """Each row, computed from plain data, is the run of a loaded model.

    The single runs take every number by its path in the model's file, in its unit; the sweep takes
    speed, restitution and spring as columns in SI units. A wrong unit, column or order would differ
    in the first digits, and rows differ by more than 1e-4. A point takes along what meets in it.
    """
    text = """
    quantities = ["duration_s", "impulse_N_s_1", "rebound_time_s_2", "time_s_9999"]
    [set]
    "stops.steeve.restitution" = 0.15
    [samples]
    method = "latin_hypercube"
    count = 3
    [parameters]
    "points.eccentric_pin.radius_mm" = { low = 4.8, high = 5.2 }
    "links.top_nipper.mass_kg" = { low = 1.0, high = 1.3 }
    preload = { low = 10.0, high = 12.0 }
    restitution = { low = 0.1, high = 0.2 }
    speed_rpm = { low = 450.0, high = 650.0 }
    "springs.steeve.stiffness_N_per_m" = { low = 8000.0, high = 9500.0 }
    """
    table = read_sweep(stored(tmp_path / "out", plan(tmp_path, text))).table
    assert table.column_names == [
        "scenario", "points.eccentric_pin.radius_mm", "links.top_nipper.mass_kg", "preload",
        "restitution", "speed_rpm",
        "springs.steeve.stiffness_N_per_m", "engine", "outcome", "message", "collisions",
        "premise_holds", "duration_s", "impulse_N_s_1", "rebound_time_s_2", "time_s_9999",
    ]  # fmt: skip
    rows = table.to_pylist()
    assert [row["scenario"] for row in rows] == list(range(3))
    durations = np.sort([row["duration_s"] for row in rows])
    assert (np.diff(durations) > 1e-4 * durations[1:]).all()
    for row in rows:
        mechanism = load("e62", {
            "stops.steeve.restitution": 0.15,
            "points.eccentric_pin.radius_mm": row["points.eccentric_pin.radius_mm"],
            "links.top_nipper.mass_kg": row["links.top_nipper.mass_kg"],
            "springs.steeve.preload_length_mm": row["preload"],
            "springs.steeve.stiffness_N_per_m": row["springs.steeve.stiffness_N_per_m"],
            "stops.jaw.restitution": row["restitution"],
        })  # fmt: skip
        single = simulate(mechanism, Case(speed_rpm=row["speed_rpm"]))
        assert row["outcome"] == "at_rest"
        # Both are relative errors of 1e-10 at most, by the tolerance that the study leaves alone.
        assert row["duration_s"] == pytest.approx(single.transitions[0].duration, rel=1e-8)
        assert row["impulse_N_s_1"] == pytest.approx(single.collisions[0].impulse, rel=1e-8)
        assert row["rebound_time_s_2"] == pytest.approx(single.collisions[1].rebound_time, rel=1e-8)
        assert np.isnan(row["time_s_9999"])


def test_rows_of_csv_tables_vary(tmp_path: Path) -> None:
    """A row of a CSV table is a parameter like any other, alone and with a fixed change of another.

    The single runs take the same paths from the files. Each row changed moves the transition by
    more than 1e-5, so one that did not reach the machine, or another one, would show; and a table
    that says something else makes another plan, whose results are not taken for this one's.
    """
    toml = (find_model("e62") / "e62.toml").read_text(encoding="utf-8")
    spring = "stiffness_N_per_m = 9000.0\npreload_length_mm = 11.0", 'file = "steeve.csv"'
    edits = (toml[toml.index("[shortcuts]") :], "", *spring)
    home = model("e62", edits, tmp_path).rename(tmp_path / "tabulated")
    table = home / "steeve.csv"
    table.write_text("coordinate_mm,force_N\n-10,9\n0,99\n10,189\n40,459\n", encoding="utf-8")
    text = """
    model = "tabulated"
    [case]
    speed_rpm = 650.0
    [set]
    "springs.steeve.force_N[3]" = 470.0
    [parameters]
    "springs.steeve.force_N[1]" = { values = [99.0, 105.0] }
    """
    rows = read_sweep(stored(tmp_path / "out", plan(tmp_path, text))).table.to_pylist()
    durations = [row["duration_s"] for row in rows]
    assert len(rows) == 2
    for row in rows:
        mechanism = load(home, {
            "springs.steeve.force_N[3]": 470.0,
            "springs.steeve.force_N[1]": row["springs.steeve.force_N[1]"],
        })  # fmt: skip
        single = simulate(mechanism, Case(speed_rpm=650.0)).transitions[0].duration
        assert row["duration_s"] == pytest.approx(single, rel=1e-8)
    assert np.diff(sorted(durations)).min() > 1e-5 * durations[0]
    before = chunk_files(tmp_path / "out")
    table.write_text(table.read_text(encoding="utf-8").replace("189", "190"), encoding="utf-8")
    with pytest.raises(InputError, match="another sweep"):
        sweep(plan(tmp_path, text), tmp_path / "out", workers=1)
    assert chunk_files(tmp_path / "out") == before


# --- who computes --------------------------------------------------------------------------------


@pytest.mark.slow
def test_results_do_not_depend_on_who_computes(tmp_path: Path) -> None:
    """Files are equal to the last byte for two processes, and for this one.

    The columns hold finite numbers, so that equality says something.
    """
    found = plan(tmp_path, "chunk = 40\n" + TABLE.replace("600", "160"))
    sweep(found, tmp_path / "out", workers=2)
    assert chunk_files(tmp_path / "out") == chunk_files(stored(tmp_path / "here", found))
    table = read_sweep(tmp_path / "out").table
    assert set(table["engine"].to_pylist()) == {"reduced"}
    assert np.isfinite(table["duration_s"].to_numpy()).all()


@pytest.mark.parametrize("bounds", [[], ["--chunks", "0"]])
def test_a_second_process_is_refused(
    bounds: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a sentence, before anything is written; as soon as the first one ends it may begin."""
    text, out = "[parameters.restitution]\nvalues = [0.1]\n", tmp_path / "out"
    arguments = ["sweep", study(tmp_path, text), "--out", str(out), "--workers", "1", *bounds]
    with alone_in(out):
        assert main(arguments) == 2
        assert capsys.readouterr().err == (
            f"nipper-pin: {out}: another process works in it; wait for it, or give --out\n"
        )
        assert list(out.iterdir()) == []
    stored(out, plan(tmp_path, text))
    with alone_in(out, shared=True):
        assert main(arguments) == (0 if bounds else 2)
    assert main(arguments) == 0
    assert read_sweep(out).stored == 1


@pytest.mark.slow
def test_jobs_of_an_array_begin_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each may be the first in the folder, and two of them have a chunk in common.

    Each does its own chunks and no more; a command for all of them is refused meanwhile.
    """
    path, out = study(tmp_path, GEOMETRY), tmp_path / "out"
    every = ["sweep", path, "--out", str(out), "--workers", "1"]
    jobs = [started(*every[1:], "--chunks", bounds) for bounds in ("0-3", "3-5")]
    wait_for(lambda: (out / "chunks").is_dir() or jobs[0].poll() is not None)
    assert main(every) == 2
    assert "another process works in it" in capsys.readouterr().err
    for job, scenarios in zip(jobs, (16, 12), strict=True):
        said, complained = job.communicate(timeout=300)
        assert job.returncode == 0, complained
        assert said.startswith(f"{scenarios} of 30 scenarios")
    whole = chunk_files(stored(tmp_path / "alone", plan(tmp_path, GEOMETRY)))
    assert chunk_files(out) == dict([*whole.items()][:6])


def test_progress_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Lines on stderr whose numbers are those of the clock and of the parts."""
    seconds = iter(range(0, 1000, 20))
    monkeypatch.setattr(time, "monotonic", lambda: float(next(seconds)))
    with progress("scenarios") as tell:
        for done in (100, 200, 300, 400):
            tell(done, 500)
    assert capsys.readouterr().err.splitlines() == [
        # With 30 s between two lines, by the rate since 100 were done at 20 s.
        "nipper-pin: scenarios: 200 of 500 after 60 s, about 120 s left",
        "nipper-pin: scenarios: 300 of 500 after 100 s, about 80 s left",
        "nipper-pin: scenarios: 400 of 500 after 140 s, about 40 s left",
    ]


# --- accidents -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_sweep_is_stopped_and_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command itself, killed and then interrupted, leaves no process behind.

    Each time it is stopped with a part of its chunks on disk, which stay as they are (the blow may
    leave others, half written under hidden names); the end has the rows of a whole run.
    """
    path, out = study(tmp_path, GEOMETRY.replace("points = 5", "points = 10")), tmp_path / "out"
    arguments = ["sweep", path, "--out", str(out), "--workers", "2"]

    def stopped(blow: signal.Signals) -> tuple[int, str]:
        """Status and complaint of a command that is stopped after three more chunks."""
        before = len(list(out.glob("chunks/*.parquet")))
        command = started(*arguments[1:])
        wait_for(lambda: len(list(out.glob("chunks/*.parquet"))) >= before + 3)
        text = Path(f"/proc/{command.pid}/task/{command.pid}/children").read_text()
        workers = [int(number) for number in text.split()]
        assert len(workers) >= 2
        # From a keyboard, an interrupt reaches every process of the group.
        if blow == signal.SIGINT:
            os.killpg(command.pid, blow)
        else:
            command.send_signal(blow)
        complained = command.communicate(timeout=60)[1]
        wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers))
        return command.returncode, notes(complained)

    def finished() -> dict[str, bytes]:
        return {name: data for name, data in chunk_files(out).items() if not name.startswith(".")}

    stopped(signal.SIGKILL)
    kept = finished()
    status, complained = stopped(signal.SIGINT)
    found = finished()
    assert 6 <= len(found) < 15
    assert {name: found[name] for name in kept} == kept
    assert status == 130
    assert complained.startswith(f"nipper-pin: interrupted; {4 * len(found)} of 60 scenarios")
    assert complained.count("\n") == 1
    assert main([*arguments[:-1], "1"]) == 0
    told = f"{4 * len(found)} were there, {60 - 4 * len(found)} computed"
    assert told in " ".join(capsys.readouterr().out.split())
    numbers = pq.read_table([*out.glob("chunks/*.parquet")])["scenario"].to_pylist()
    assert sorted(numbers) == list(range(60))


# --- whole turns ---------------------------------------------------------------------------------


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
    stored_ones = read_sweep(out)
    assert stored_ones.quantities == tuple(every(e62))
    chunk = stored_ones.table
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
