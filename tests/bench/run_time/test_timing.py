"""The benchmark's clock: its figures, how often it repeats, and the machine it names."""

from __future__ import annotations

import math
import os
import platform
import statistics
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pytest

from benchmarks.run_time import timing


def ticking(monkeypatch: pytest.MonkeyPatch, *seconds: float) -> Any:
    """A function that lasts so long, run by run, by a clock of its own; the last one for ever."""
    now = [50.0]
    runs: list[float] = []

    def function() -> None:
        runs.append(seconds[min(len(runs), len(seconds) - 1)])
        now[0] += runs[-1]

    monkeypatch.setattr(timing.time, "perf_counter", lambda: now[0])
    return function


def test_figures_of_a_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first run apart; median, best and distance of the quartiles of the others."""
    others = [0.3, 0.1, 0.4, 0.15, 0.9]
    found = timing.timed(ticking(monkeypatch, 2.0, *others), 5)
    assert found.first_ms == pytest.approx(2000.0)
    assert found.median_ms == pytest.approx(300.0)
    assert found.fastest_ms == pytest.approx(100.0)
    low, _, high = statistics.quantiles(others, n=4)
    assert found.spread_ms == pytest.approx(1e3 * (high - low))
    assert found.runs == 5
    few = timing.timed(ticking(monkeypatch, 2.0, 0.1, 0.2, 0.3), 3)
    assert (few.runs, few.spread_ms) == (3, 0.0)
    four = timing.timed(ticking(monkeypatch, 2.0, 0.1, 0.2, 0.3, 0.5), 4)
    assert four.spread_ms > 0.0


@pytest.mark.parametrize(
    ("seconds", "repeats", "budget", "runs"),
    [
        # Enough repeats, but not a fifth of a second: 1 / 64 s are repeated 13 times, the first in.
        (1 / 64, 3, math.inf, 12),
        (1 / 64, 40, math.inf, 40),
        # A short budget is all that a short run is repeated for.
        (1 / 64, 3, 1 / 8, 7),
        (1.0, 9, 4.5, 4),
        (1.0, 9, 0.5, 1),
    ],
)
def test_how_often_is_repeated(
    monkeypatch: pytest.MonkeyPatch, seconds: float, repeats: int, budget: float, runs: int
) -> None:
    assert timing.timed(ticking(monkeypatch, seconds), repeats, budget).runs == runs


def test_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each entry under its own name, as the system tells it."""
    for number, name in enumerate(("OMP", "OPENBLAS", "MKL", "NUMBA"), 3):
        monkeypatch.setenv(f"{name}_NUM_THREADS", str(number))
    monkeypatch.setattr(os, "getloadavg", lambda: (0.5, 1.5, 2.5))
    monkeypatch.setattr(os, "cpu_count", lambda: 48)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {1, 2, 5})
    found = timing.environment(("jinja2", "no-such-package"))
    assert found["threads"] == {
        "OMP_NUM_THREADS": "3", "OPENBLAS_NUM_THREADS": "4", "MKL_NUM_THREADS": "5",
        "NUMBA_NUM_THREADS": "6",
    }  # fmt: skip
    assert (found["cores"], found["cores_allowed"]) == (48, 3)
    assert found["load_average"] == [0.5, 1.5, 2.5]
    assert found["platform"] == platform.platform()
    assert found["python"] == platform.python_version()
    assert len(found["date"]) == len("2026-01-02T03:04:05+00:00")
    names = ("nipper-pin", "pin", "coal", "numpy", "scipy", "numba", "msgspec", "rich",
             "matplotlib", "jinja2")  # fmt: skip
    wanted = {}
    for name in names:
        try:
            wanted[name] = version(name)
        except PackageNotFoundError:
            assert name not in found["versions"]
    assert found["versions"] == wanted
    text = "processor : 0\nmodel name\t: A chip: fast\nflags : model name\n"
    read = Path.read_text
    for said, processor in ((text, "A chip: fast"), ("none\n", platform.machine())):

        def told(path: Path, *more: Any, said: str = said, **named: Any) -> str:
            return said if path.name == "cpuinfo" else read(path, *more, **named)

        monkeypatch.setattr(Path, "read_text", told)
        assert timing.environment()["processor"] == processor


@pytest.mark.parametrize("told", ["A chip: fast", ""])
def test_a_machine_that_does_not_tell_its_processor(
    monkeypatch: pytest.MonkeyPatch, told: str
) -> None:
    """Python's own word for it where there is one, else the kind of machine."""

    def missing(path: Path, *_: Any, **__: Any) -> str:
        raise FileNotFoundError(path)

    monkeypatch.setattr(platform, "processor", lambda: told)
    monkeypatch.setattr(Path, "read_text", missing)
    assert timing._processor() == (told or platform.machine())
