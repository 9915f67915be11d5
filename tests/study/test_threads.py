"""The same bits, whatever the environment says of the threads of BLAS."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
COMMAND = "import sys; from nipper_pin.cli import main; sys.exit(main())"
MEASURED = """speed_rpm,quantity,value,sigma
450,rebound_amplitude_1,5.2e-3,5e-5
650,rebound_amplitude_1,5.5e-3,5e-5
650,rebound_time_s_1,5.5e-3,5e-5
650,rebound_amplitude_2,3.1e-4,5e-6
"""
FIT = """format = 1
title = "three numbers"
model = "e62"
measured = "measured.csv"
[parameters."springs.steeve.preload_length_mm"]
low = 8.0
high = 16.0
[parameters.restitution]
low = 0.05
high = 0.4
[parameters."drives.tension.ratio"]
low = 1.8
high = 2.6
"""
SENSITIVITIES = """
from nipper_pin import load
from nipper_pin.study.sensitivity import sensitivities

if __name__ == "__main__":
    paths = ["stops.jaw.restitution", "springs.steeve.preload_length_mm"]
    found = sensitivities(load("e62"), 650.0, paths, workers=1)
    print([(row.per.tolist(), row.control.tolist()) for row in found.rows])
"""


def said(threads: str | None, words: list[str], folder: Path) -> str:
    """What a program writes that is started with so many threads; None: by itself."""
    env = {name: value for name, value in os.environ.items() if name not in THREADS}
    env |= {} if threads is None else dict.fromkeys(THREADS, threads)
    run = subprocess.run(
        [sys.executable, *words], env=env, cwd=folder, capture_output=True, text=True, check=False
    )
    assert run.stdout, run.stderr
    return run.stdout


@pytest.mark.campaign
def test_an_identification(tmp_path: Path) -> None:
    """One start, its deviations, and a profile: the last bits of all numbers."""
    (tmp_path / "measured.csv").write_text(MEASURED, encoding="utf-8")
    (tmp_path / "fit.toml").write_text(FIT, encoding="utf-8")
    words = ["identify", "fit.toml", "--starts", "1", "--workers", "1", "--profiles", "1"]
    found = {said(threads, ["-c", COMMAND, *words, "--json", "-"], tmp_path)
             for threads in (None, "1", "2")}  # fmt: skip
    assert len(found) == 1
    assert len(json.loads(found.pop())["parameters"]) == 3


@pytest.mark.campaign
def test_sensitivities(tmp_path: Path) -> None:
    """By a caller whose BLAS has several threads, too."""
    file = tmp_path / "program.py"
    file.write_text(SENSITIVITIES, encoding="utf-8")
    assert len({said(threads, [str(file)], tmp_path) for threads in (None, "1", "2")}) == 1


@pytest.mark.campaign
def test_the_published_study(tmp_path: Path) -> None:
    words = ["-m", "benchmarks", "paper", "--json", "-"]

    def numbers(threads: str) -> Any:
        return json.loads(said(threads, words, tmp_path))

    assert numbers("1") == numbers("2")


def test_the_command_computes_in_one_thread(tmp_path: Path) -> None:
    """Whatever the environment says, and before numpy has read it."""
    program = (
        "import os; import nipper_pin.cli; "
        "from nipper_pin.study.processes import in_one_thread; "
        "print(in_one_thread(), os.environ['OPENBLAS_NUM_THREADS'])"
    )
    assert said("2", ["-c", program], tmp_path).split() == ["True", "1"]
