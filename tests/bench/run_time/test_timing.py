"""The benchmark's clock: its figures, how often it repeats, and the machine it names."""

from __future__ import annotations

import math
import os
import statistics
from importlib.metadata import version
from typing import Any

import pytest

from benchmarks.run_time import timing


@pytest.mark.parametrize(
    ("seconds", "repeats", "budget", "runs"),
    [
        # The first run is apart from the others.
        ([2.0, 0.3, 0.1, 0.4, 0.15, 0.9], 5, math.inf, 5),
        ([2.0, 0.1, 0.2, 0.3], 3, math.inf, 3),
        # Enough repeats, but not a fifth of a second: 1 / 64 s are repeated 13 times, the first in.
        ([1 / 64], 3, math.inf, 12),
        # A short budget is all that a short run is repeated for.
        ([1 / 64], 3, 1 / 8, 7),
        ([1.0], 9, 0.0, 1),
    ],
)
def test_figures_of_a_clock(
    monkeypatch: pytest.MonkeyPatch, seconds: list[float], repeats: int, budget: float, runs: int
) -> None:
    """Median, best and distance of the quartiles by a clock that each run moves on by so much."""
    now, done = [50.0], [0]

    def function() -> None:
        now[0] += seconds[min(done[0], len(seconds) - 1)]
        done[0] += 1

    monkeypatch.setattr(timing.time, "perf_counter", lambda: now[0])
    found = timing.timed(function, repeats, budget)
    assert (found.runs, done[0]) == (runs, runs + 1)
    others = [seconds[min(n, len(seconds) - 1)] for n in range(1, runs + 1)]
    low, _, high = statistics.quantiles(others, n=4) if runs > 3 else (0.0, 0.0, 0.0)
    assert found.first_ms == pytest.approx(1e3 * seconds[0])
    assert found.wall_ms == pytest.approx(1e3 * statistics.median(others))
    assert found.fastest_ms == pytest.approx(1e3 * min(others))
    assert found.spread_ms == pytest.approx(1e3 * (high - low))


def test_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads as they are set, the processor and its cores, and versions of what is installed."""
    monkeypatch.setenv("MKL_NUM_THREADS", "5")
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    found: dict[str, Any] = timing.environment()
    assert found["threads"] | {"MKL_NUM_THREADS": "5", "OMP_NUM_THREADS": None} == found["threads"]
    assert found["processor"]
    assert found["cores_allowed"] == len(os.sched_getaffinity(0)) <= found["cores"]
    versions = found["versions"]
    for name in ("nipper-pin", "pin", "numpy", "scipy", "numba"):
        assert versions[name] == version(name)
