"""The same bits, whatever the environment says of the threads of BLAS."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
FILMED = Path(__file__).resolve().parents[2] / "scripts" / "identify_camera.toml"
COMMAND = "import sys; from nipper_pin.cli import main; sys.exit(main())"
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
@pytest.mark.parametrize(
    "words",
    [
        # One start, its deviations, and a profile: the last bits of all numbers.
        ["-c", COMMAND, "identify", str(FILMED), "--starts", "1", "--workers", "1", "--profiles",
         "1", "--json", "-"],
        # By a caller whose BLAS has several threads, too.
        ["program.py"],
        ["-m", "benchmarks", "paper", "--json", "-"],
    ],
    ids=["identify", "sensitivities", "published study"],
)  # fmt: skip
def test_threads_change_no_bit(words: list[str], tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(SENSITIVITIES, encoding="utf-8")
    first, *others = (said(threads, words, tmp_path) for threads in (None, "1", "2"))
    assert len(first) > 100
    assert {*others} == {first}


def test_the_command_computes_in_one_thread(tmp_path: Path) -> None:
    """Whatever the environment says, and before numpy has read it."""
    program = (
        "import os; import nipper_pin.cli; "
        "from nipper_pin.study.processes import in_one_thread; "
        "print(in_one_thread(), os.environ['OPENBLAS_NUM_THREADS'])"
    )
    assert said("2", ["-c", program], tmp_path).split() == ["True", "1"]
