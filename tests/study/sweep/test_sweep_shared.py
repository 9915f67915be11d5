"""Several processes in one folder: each scenario is computed once, whatever becomes of them."""

from __future__ import annotations

import errno
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from sweep_studies import COMMAND, GEOMETRY, TABLE, chunk_files, study, wait_for

from nipper_pin.cli import main, sweep
from nipper_pin.study.sweep import read_plan, read_sweep, run_sweep

MANY = GEOMETRY.replace("points = 5", "points = 12")


def start(path: str, out: Path, *more: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*COMMAND, "sweep", path, "--out", str(out), "--workers", "1", "--json", "-", *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def report(process: subprocess.Popen[str]) -> dict[str, int]:
    said, complained = process.communicate(timeout=300)
    assert process.returncode == 0, complained
    found: dict[str, int] = json.loads(said)
    return found


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, dict[str, bytes]]:
    """The study, and the files of one process."""
    folder = tmp_path_factory.mktemp("alone")
    path = study(folder, MANY)
    run_sweep(read_plan(path), folder / "out", workers=2)
    return path, chunk_files(folder / "out")


@pytest.mark.slow
def test_two_processes_share_a_folder(tmp_path: Path, alone: tuple[str, dict[str, bytes]]) -> None:
    """What each says that it computed adds up to all, without a scenario that both computed.

    Both start with an empty folder at once, and both end with all files, which are those of one
    process to the last byte.
    """
    path, whole = alone
    found = [report(process) for process in [start(path, tmp_path / "out") for _ in range(2)]]
    assert [item["scenarios"] for item in found] == [72, 72]
    assert [item["computed"] + item["found"] for item in found] == [72, 72]
    assert sum(item["computed"] for item in found) == 72
    assert min(item["computed"] for item in found) > 0
    assert chunk_files(tmp_path / "out") == whole


@pytest.mark.slow
def test_a_process_takes_over_from_one_that_is_killed(
    tmp_path: Path, alone: tuple[str, dict[str, bytes]]
) -> None:
    """Chunks that a process had taken when it was killed are computed by the other one."""
    path, whole = alone
    out = tmp_path / "out"
    doomed = start(path, out)
    wait_for(lambda: len(list(out.glob("chunks/*.parquet"))) >= 2)
    other = start(path, out)
    doomed.kill()
    doomed.communicate()
    assert len(list(out.glob("chunks/*.parquet"))) < len(whole)
    assert report(other)["scenarios"] == 72
    assert chunk_files(out) == whole


@pytest.mark.slow
def test_jobs_of_an_array_have_chunks_of_their_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three ranges of a plan of 8 chunks together are the whole; each does its own and no more."""
    path, out = study(tmp_path, GEOMETRY), tmp_path / "out"
    run_sweep(read_plan(path), tmp_path / "alone", workers=1)
    arguments = ["sweep", path, "--out", str(out), "--workers", "1", "--chunks"]
    for bounds, scenarios, files in (("0-3", 16, 4), ("3", 4, 4), ("6-99", 6, 6), ("4-5", 8, 8)):
        assert main([*arguments, bounds]) == 0
        assert capsys.readouterr().out.startswith(f"{scenarios} of 30 scenarios")
        assert len(chunk_files(out)) == files
    assert chunk_files(out) == chunk_files(tmp_path / "alone")
    for bounds in ("8", "8-9", "3-2", "a-b", "1:2", ""):
        assert main([*arguments, bounds]) == 2, bounds
        assert f"--chunks {bounds}" in capsys.readouterr().err


def test_a_folder_without_locks_needs_ranges(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_lock(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("nipper_pin.study.sweep.results.locks.fcntl.lockf", no_lock)
    path = study(tmp_path, '[parameters."drives.tension.ratio"]\nvalues = [2.2]\n')
    arguments = ["sweep", path, "--out", str(tmp_path / "out")]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert "this file system has no locks (No locks available)" in said
    assert "give --chunks" in said
    assert main([*arguments, "--chunks", "0"]) == 0
    assert read_sweep(tmp_path / "out").stored == 1


@pytest.mark.slow
def test_chunks_that_nobody_finishes_are_not_waited_for_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another process has a chunk, and does nothing; meanwhile lines say that time goes by."""
    path, out = study(tmp_path, GEOMETRY.replace("points = 5", "points = 2")), tmp_path / "out"
    run_sweep(read_plan(path), out, workers=1)
    (out / "chunks" / "0000001.parquet").unlink()
    holder = subprocess.Popen(
        [sys.executable, "-c", "import fcntl, sys, time; handle = open(sys.argv[1], 'r+'); "
         "fcntl.lockf(handle, fcntl.LOCK_EX, 1, 2); print('held', flush=True); time.sleep(600)",
         str(out / "locks")],
        stdout=subprocess.PIPE,
    )  # fmt: skip
    try:
        assert holder.stdout is not None
        holder.stdout.readline()
        monkeypatch.setattr("nipper_pin.study.sweep.run._PATIENCE_S", 0.5)
        monkeypatch.setattr(sweep, "_EVERY_S", 0.1)
        assert main(["sweep", path, "--out", str(out)]) == 1
    finally:
        holder.kill()
        holder.communicate()
    *lines, last = capsys.readouterr().err.splitlines()
    assert len(lines) >= 2
    assert all(re.fullmatch(r"nipper-pin: 8 of 12 scenarios after \d+ s", line) for line in lines)
    assert "other processes have had 1 chunks" in last
    assert main(["sweep", path, "--out", str(out)]) == 0
    assert "8 were there, 4 computed" in " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
def test_progress_without_a_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Lines on stderr whose numbers are those of the clock and of the chunks."""
    seconds = iter(range(0, 1000, 20))
    monkeypatch.setattr(time, "monotonic", lambda: float(next(seconds)))
    with sweep._lines() as show:
        for done in (100, 200, 300, 400):
            show(done, 100, 500)
    assert capsys.readouterr().err.splitlines() == [
        # At 40 s and 80 s, with 30 s between two lines: (200 - 100) / 40 s; 300 / 80 s.
        "nipper-pin: 200 of 500 scenarios after 40 s, 2.5/s, about 120 s left",
        "nipper-pin: 400 of 500 scenarios after 80 s, 3.75/s, about 27 s left",
    ]
    monkeypatch.undo()
    monkeypatch.setattr(sweep, "_EVERY_S", 0.0)
    text = TABLE.replace("600", "200").replace("high = 680.0", "high = 500.0")
    path = study(tmp_path, "chunk = 100\n" + text)
    assert main(["sweep", path, "--out", str(tmp_path / "out"), "--workers", "1"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert re.match(r"nipper-pin: 100 of 200 scenarios after \d+ s, [\d.e+]+/s, about", lines[-2])
    assert lines[-1].startswith("nipper-pin: 200 of 200 scenarios after")
