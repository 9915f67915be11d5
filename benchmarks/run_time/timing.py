"""Wall time of a function, and the machine that it was measured on."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import distributions
from math import inf
from pathlib import Path
from typing import Any

from nipper_pin.units import MS_PER_S

_PACKAGES = (
    "nipper-pin", "pin", "coal", "numpy", "scipy", "numba", "msgspec", "rich", "matplotlib",
    "mujoco",
)  # fmt: skip
# Least duration of all repeats [s]: the first repeats of a short run are slower, and ten of them
# would sample the machine for a hundredth of a second only.
_SHORTEST_S = 0.2
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Timing:
    """Wall time of repeated runs: the first, which pays for caches and compilation, and others.

    Of these the median ``wall_ms``, the fastest, which is what the machine can do when left alone,
    and the distance of the quartiles, zero with fewer than four.
    """

    first_ms: float
    wall_ms: float
    fastest_ms: float
    spread_ms: float
    runs: int


def timed(function: Callable[[], object], repeats: int, budget_s: float = inf) -> Timing:
    """Time a function, repeated at least so often; short ones for a fifth of a second.

    No further run starts when the budget of time has gone; one always does. The first is not
    counted, which may compile for longer than that.
    """
    times: list[float] = []
    begin = time.perf_counter()
    while True:
        start = time.perf_counter()
        begin = start if len(times) < 2 else begin
        elapsed = start - begin
        enough = len(times) > repeats and elapsed >= min(_SHORTEST_S, budget_s)
        if enough or (len(times) > 1 and elapsed > budget_s):
            break
        function()
        times.append(MS_PER_S * (time.perf_counter() - start))
    first, *others = times
    spread = 0.0
    if len(others) >= 4:
        low, _, high = statistics.quantiles(others, n=4)
        spread = high - low
    return Timing(first, statistics.median(others), min(others), spread, len(others))


def environment() -> dict[str, Any]:
    """Return versions of what is installed, the processor, its load and threads."""
    installed = {item.name: item.version for item in distributions()}
    return {
        "date": datetime.now(tz=UTC).isoformat(timespec="seconds"),
        "platform": platform.platform(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "cores_allowed": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None,
        "load_average": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
        "threads": {name: os.environ.get(name) for name in _THREADS},
        "python": platform.python_version(),
        "versions": {name: installed[name] for name in _PACKAGES if name in installed},
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
