"""Sweeps: results against single runs, who computes them, and what survives an accident."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from sweep_studies import (
    COMMAND,
    GEOMETRY,
    TABLE,
    chunk_files,
    plan,
    stored,
    study,
    tabulated_e62,
    wait_for,
)

from nipper_pin import Case, InputError, load, simulate
from nipper_pin.cli import main
from nipper_pin.study.sweep import read_plan, read_sweep, run_sweep
from nipper_pin.study.sweep.chunks import NO_MODEL, run_chunk
from nipper_pin.study.sweep.plan import Chunk
from nipper_pin.study.sweep.results import Store

# --- results -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_rows_are_what_single_runs_say(tmp_path: Path) -> None:
    """Each row, computed in another process from plain data, is the run of a loaded model.

    The single runs take every number by its path in the model's file, in its unit; the sweep takes
    speed, restitution and spring as columns in SI units. A wrong unit, column or order would differ
    in the first digits, and neighbouring rows differ by more than 1 %.
    """
    text = """
    quantities = ["duration_s", "impulse_N_s_1", "rebound_time_s_2", "time_s_9999"]
    [set]
    "stops.steeve.restitution" = 0.15
    [parameters."links.top_nipper.mass_kg"]
    values = [1.0, 1.3]
    [parameters.preload]
    values = [10.0, 12.0]
    [parameters.restitution]
    values = [0.1, 0.2]
    [parameters.speed_rpm]
    values = [450.0, 650.0]
    [parameters."springs.steeve.stiffness_N_per_m"]
    values = [8000.0, 9500.0]
    """
    run_sweep(plan(tmp_path, text), tmp_path / "out", workers=1)
    table = read_sweep(tmp_path / "out").table
    assert table.column_names == [
        "scenario", "links.top_nipper.mass_kg", "preload", "restitution", "speed_rpm",
        "springs.steeve.stiffness_N_per_m", "engine", "outcome", "message", "collisions",
        "premise_holds", "duration_s", "impulse_N_s_1", "rebound_time_s_2", "time_s_9999",
    ]  # fmt: skip
    rows = table.to_pylist()
    assert [row["scenario"] for row in rows] == list(range(32))
    assert len({row["duration_s"] for row in rows}) == 32
    for row in rows:
        mechanism = load("e62", {
            "stops.steeve.restitution": 0.15,
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


def test_a_point_moves_with_what_meets_in_it(tmp_path: Path) -> None:
    """The eccentricity of the model itself gives the model's own transition, another one another.

    A point that moved alone would tear a closure open, and the row would be marked.
    """
    text = """
    [case]
    speed_rpm = 650.0
    [parameters."points.eccentric_pin.radius_mm"]
    values = [5.0, 6.0]
    """
    rows = read_sweep(stored(tmp_path / "out", plan(tmp_path, text))).table.to_pylist()
    own = simulate(load("e62"), Case(speed_rpm=650.0)).transitions[0].duration
    assert [row["outcome"] for row in rows] == ["at_rest", "at_rest"]
    assert rows[0]["duration_s"] == pytest.approx(own, rel=1e-8)
    assert abs(rows[1]["duration_s"] / own - 1.0) > 1e-3


@pytest.mark.slow
def test_rows_of_csv_tables_vary(tmp_path: Path) -> None:
    """A row of a CSV table is a parameter like any other, alone and with a fixed change of another.

    The single runs take the same paths from the files. Each row changed moves the transition by
    more than 1e-5, so one that did not reach the machine, or another one, would show; and a table
    that says something else makes another plan, whose results are not taken for this one's.
    """
    home = tabulated_e62(tmp_path)
    text = """
    model = "tabulated"
    [case]
    speed_rpm = 650.0
    [set]
    "springs.steeve.force_N[3]" = 470.0
    [parameters."springs.steeve.force_N[1]"]
    values = [99.0, 105.0]
    [parameters."drives.pendulum.coordinate_rad[34]"]
    values = [%r, %r]
    """
    law: Any = load(home).drives[0].law
    own = law.coordinate[34]
    text = text % (own, own + 1e-4)
    run_sweep(plan(tmp_path, text), tmp_path / "out", workers=1)
    rows = read_sweep(tmp_path / "out").table.to_pylist()
    durations = [row["duration_s"] for row in rows]
    assert len(rows) == 4
    for row in rows:
        mechanism = load(home, {
            "springs.steeve.force_N[3]": 470.0,
            "springs.steeve.force_N[1]": row["springs.steeve.force_N[1]"],
            "drives.pendulum.coordinate_rad[34]": row["drives.pendulum.coordinate_rad[34]"],
        })  # fmt: skip
        single = simulate(mechanism, Case(speed_rpm=650.0)).transitions[0].duration
        assert row["duration_s"] == pytest.approx(single, rel=1e-8)
    assert np.diff(sorted(durations)).min() > 1e-5 * durations[0]
    table = home / "steeve.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("189.0", "190.0"), encoding="utf-8")
    with pytest.raises(InputError, match="another sweep"):
        run_sweep(plan(tmp_path, text), tmp_path / "out", workers=1)


def test_impossible_machines_are_marked_rows(tmp_path: Path) -> None:
    """A radius below zero and one beyond the guide do not cost the rows beside them."""
    text = """
    [parameters."drives.pendulum.crank_radius_mm"]
    values = [63.0, -5.0, 64.0, 10000.0]
    """
    rows = read_sweep(stored(tmp_path / "out", plan(tmp_path, text))).table.to_pylist()
    assert [row["outcome"] for row in rows] == ["at_rest", NO_MODEL, "at_rest", NO_MODEL]
    for row in rows[1::2]:
        assert "crank_radius_mm" in row["message"]
        assert row["engine"] == "none"
        assert row["collisions"] == 0
        assert np.isnan(row["duration_s"])
    assert all(row["message"] == "" and row["duration_s"] > 0.0 for row in rows[::2])


# --- who computes, and accidents ---------------------------------------------------------------


@pytest.mark.slow
def test_results_do_not_depend_on_who_computes(tmp_path: Path) -> None:
    """Files are equal to the last byte for one and for two processes, and in this one backwards.

    The columns hold finite numbers, so that equality says something.
    """
    found = plan(tmp_path, "chunk = 90\n" + TABLE)
    assert len(found.chunks()) == 7
    for workers in (1, 2):
        run_sweep(found, tmp_path / str(workers), workers=workers)
    one, two = chunk_files(tmp_path / "1"), chunk_files(tmp_path / "2")
    assert one == two
    text = found.job.text()
    for chunk, rows in reversed(list(found.rows(found.chunks()))):
        assert run_chunk(text, chunk.start, rows) == one[f"{chunk.number:07d}.parquet"]
    table = read_sweep(tmp_path / "1").table
    assert set(table["engine"].to_pylist()) == {"reduced"}
    assert np.isfinite(table["duration_s"].to_numpy()).all()


@pytest.mark.slow
def test_interrupted_sweeps_resume(tmp_path: Path) -> None:
    """What is on disk at the interrupt is kept as it is, and the end is that of a run in one go.

    A file cut short by an accident, and a temporary one, are not taken for results.
    """
    found = plan(tmp_path, GEOMETRY)
    assert len(found.chunks()) == 8
    run_sweep(found, tmp_path / "whole", workers=2)
    out = tmp_path / "parts"

    def interrupt(done: int, _found: int, _total: int) -> None:
        if done >= 8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_sweep(found, out, workers=1, progress=interrupt)
    kept = {path.name: path.stat().st_mtime_ns for path in (out / "chunks").iterdir()}
    assert 2 <= len(kept) < 8
    cut = out / "chunks" / min(kept)
    cut.write_bytes(cut.read_bytes()[:-20])
    (out / "chunks" / ".0000009.parquet.1.partial").write_bytes(b"half of it")
    assert read_plan(study(tmp_path, GEOMETRY)).hash == found.hash
    report = run_sweep(found, out, workers=2)
    assert report.found == 4 * (len(kept) - 1)
    (out / "chunks" / ".0000009.parquet.1.partial").unlink()
    assert chunk_files(out) == chunk_files(tmp_path / "whole")
    for name, written in kept.items():
        path = out / "chunks" / name
        assert (path.stat().st_mtime_ns == written) == (path != cut)
    # Nothing is left to do: no process is started.
    again = run_sweep(found, out)
    assert (again.found, again.workers) == (30, 0)


@pytest.mark.slow
@pytest.mark.parametrize("blow", [signal.SIGINT, signal.SIGKILL])
def test_a_sweep_is_stopped(tmp_path: Path, blow: signal.Signals) -> None:
    """The command itself, interrupted or killed, leaves no process behind and can be run again.

    It is stopped with a part of its chunks on disk; the end has the rows of a whole run.
    """
    path, out = study(tmp_path, GEOMETRY.replace("points = 5", "points = 40")), tmp_path / "out"
    arguments = [*COMMAND, "sweep", path, "--out", str(out), "--workers", "2"]
    # A group of its own: from a keyboard, an interrupt reaches every process of the group.
    command = subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True, start_new_session=True)
    wait_for(lambda: len(list(out.glob("chunks/*.parquet"))) >= 3)
    workers = children(command.pid)
    if blow == signal.SIGINT:
        os.killpg(command.pid, blow)
    else:
        command.send_signal(blow)
    complained = command.communicate(timeout=60)[1]
    stored = len(list(out.glob("chunks/*.parquet")))
    assert 3 <= stored < 60
    if blow == signal.SIGINT:
        assert command.returncode == 130
        assert complained.startswith(f"nipper-pin: interrupted; {4 * stored} of 240 scenarios")
        assert complained.count("\n") == 1
    assert len(workers) >= 2
    wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers))
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert f"{4 * stored} were there, {240 - 4 * stored} computed" in " ".join(done.stdout.split())
    numbers = pq.read_table([*out.glob("chunks/*.parquet")])["scenario"].to_pylist()
    assert sorted(numbers) == list(range(240))


@pytest.mark.slow
def test_an_interrupt_counts_what_is_stored(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The interrupt comes in the moment between a stored chunk and the note that it is stored.

    Without a look at the folder this chunk would be missing in what the command says.
    """
    write = Store.write

    def interrupted(store: Store, chunk: Chunk, content: bytes) -> None:
        write(store, chunk, content)
        if len(chunk_files(out)) == 2:
            raise KeyboardInterrupt

    path, out = study(tmp_path, GEOMETRY), tmp_path / "out"
    monkeypatch.setattr(Store, "write", interrupted)
    assert main(["sweep", path, "--out", str(out), "--workers", "1"]) == 130
    assert "interrupted; 8 of 30 scenarios" in capsys.readouterr().err


def children(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(number) for number in text.split()]


def test_results_of_two_plans_are_not_mixed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    small = '[parameters."drives.tension.ratio"]\nvalues = [2.2]\n'
    arguments = ["--out", str(out), "--workers", "1"]
    before = chunk_files(stored(out, plan(tmp_path, small)))
    assert main(["sweep", study(tmp_path, small.replace("2.2", "2.3")), *arguments]) == 2
    said = capsys.readouterr().err
    assert "another sweep (they differ in: axes)" in said
    assert "--out" in said
    assert chunk_files(out) == before
