"""The same run gives the same bits, within a process and in a new one."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

import nipper_pin
from nipper_pin import Case, load, simulate

PROGRAM = """
from nipper_pin import Case, load, simulate
solution = simulate(load("e62"), Case(speed_rpm=650.0, window="cycle"))
for event in solution.events:
    for number in (event.t, *event.q, *event.v_before, *event.v_after, *event.P_g, *event.delta,
                   *event.P_N.values(), event.energy_lost, event.series_error):
        print(float(number).hex())
"""


def _bits() -> list[str]:
    """Every number of every event of one cycle, as hexadecimal floats."""
    with redirect_stdout(StringIO()) as told:
        exec(PROGRAM, {})
    return told.getvalue().split()


@pytest.fixture(scope="module")
def bits() -> list[str]:
    return _bits()


def test_a_second_run_in_the_process_has_the_same_bits(bits: list[str]) -> None:
    """Nothing that a run leaves behind (caches, buffers of Pinocchio) reaches the next one.

    Compared bit by bit: a stale buffer shows in the last digits long before a tolerance sees it.
    """
    assert len(bits) > 500
    assert _bits() == bits


def test_a_run_after_other_runs_has_the_same_bits(bits: list[str]) -> None:
    """Another speed and another window in between change nothing."""
    mechanism = load("e62", {"stops.jaw.restitution": 0.5})
    simulate(mechanism, Case(speed_rpm=450.0))
    assert _bits() == bits


def test_a_new_process_has_the_same_bits(bits: list[str]) -> None:
    """No order of hashing or of memory enters: sets of stops are sorted wherever order matters.

    The new process has another seed for hashing.
    """
    root = str(Path(nipper_pin.__file__).parents[1])
    for seed in ("1", "2"):
        result = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            capture_output=True,
            text=True,
            check=True,
            # The rest of the environment stays: it may choose the kernels of BLAS.
            env={**os.environ, "PYTHONPATH": root, "PYTHONHASHSEED": seed},
        )
        assert result.stdout.split() == bits
