"""One process at a time works in the folder of a sweep, or jobs of an array."""

from __future__ import annotations

import re
import subprocess
import time
from pathlib import Path

import pytest
from sweep_studies import COMMAND, GEOMETRY, TABLE, chunk_files, study, wait_for

from nipper_pin.cli import main, sweep
from nipper_pin.study.folders import alone_in
from nipper_pin.study.sweep import read_plan, read_sweep, run_sweep


def start(path: str, out: Path, *more: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*COMMAND, "sweep", path, "--out", str(out), "--workers", "1", *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


@pytest.mark.parametrize("bounds", [[], ["--chunks", "0"]])
def test_a_second_process_is_refused(
    bounds: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a sentence, before anything is written; as soon as the first one ends it may begin."""
    path, out = study(tmp_path, "[parameters.restitution]\nvalues = [0.1]\n"), tmp_path / "out"
    arguments = ["sweep", path, "--out", str(out), "--workers", "1", *bounds]
    with alone_in(out):
        assert main(arguments) == 2
        assert capsys.readouterr().err == (
            f"nipper-pin: {out}: another process works in it; wait for it, or give --out\n"
        )
        assert list(out.iterdir()) == []
    with alone_in(out, shared=True):
        assert main(arguments) == (0 if bounds else 2)
    assert main(arguments) == 0
    assert read_sweep(out).stored == 1


@pytest.mark.slow
def test_a_second_command_changes_nothing_of_the_first(tmp_path: Path) -> None:
    path = study(tmp_path, GEOMETRY)
    run_sweep(read_plan(path), tmp_path / "alone", workers=1)
    first = start(path, tmp_path / "out")
    wait_for(lambda: (tmp_path / "out" / "chunks").is_dir())
    second = start(path, tmp_path / "out")
    assert "another process works in it" in second.communicate(timeout=300)[1]
    assert second.returncode == 2
    complained = first.communicate(timeout=300)[1]
    assert first.returncode == 0, complained
    assert chunk_files(tmp_path / "out") == chunk_files(tmp_path / "alone")


@pytest.mark.slow
def test_jobs_of_an_array_begin_at_once(tmp_path: Path) -> None:
    """Each may be the first in the folder, and two of them have a chunk in common."""
    path, out = study(tmp_path, GEOMETRY), tmp_path / "out"
    run_sweep(read_plan(path), tmp_path / "alone", workers=1)
    jobs = [start(path, out, "--chunks", bounds) for bounds in ("0-2", "3-5", "5-7")]
    for job in jobs:
        complained = job.communicate(timeout=300)[1]
        assert job.returncode == 0, complained
    assert chunk_files(out) == chunk_files(tmp_path / "alone")


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
