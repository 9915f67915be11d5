"""Processes of a study."""

from __future__ import annotations

import os

import pytest

from nipper_pin.study.processes import fresh_processes

# What OpenMP, OpenBLAS and MKL read when they are loaded.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def nothing() -> None:
    """What a process imports while the others go on."""


def test_every_process_computes_in_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever this one does, which goes on as it was."""
    for name, value in zip(THREADS, ("3", "2", "4"), strict=True):
        monkeypatch.setenv(name, value)
    with fresh_processes(1, nothing) as pool:
        assert list(pool.map(os.getenv, THREADS)) == ["1", "1", "1"]
    assert [os.environ[name] for name in THREADS] == ["3", "2", "4"]
