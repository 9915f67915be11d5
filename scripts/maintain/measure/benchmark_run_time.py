"""How long do a load, a transition and a cycle take, and the command as a whole process?

Run: python scripts/maintain/measure/benchmark_run_time.py [REPEATS]
"""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import nipper_pin as nip


def timed(function: Callable[[], object], repeats: int) -> str:
    """First run apart, then minimum, median and maximum of the others [ms]."""
    times = []
    for _ in range(repeats + 1):
        begin = time.perf_counter()
        function()
        times.append(1e3 * (time.perf_counter() - begin))
    first, *rest = times
    return (
        f"first {first:8.2f}   min {min(rest):8.2f}   median {statistics.median(rest):8.2f}   "
        f"max {max(rest):8.2f} ms"
    )


def main(repeats: int = 30) -> None:
    """Print the environment and the times."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("pin", "coal", "numpy", "scipy"))
    print(f"{platform.platform()}, Python {platform.python_version()}, {os.cpu_count()} cores")
    print(f"nipper-pin {nip.__version__}, {packages}")
    mechanism = nip.load("e62")
    print(f"load e62                 {timed(lambda: nip.load('e62'), repeats)}")
    for speed in (450.0, 650.0):
        case = nip.Case(speed_rpm=speed)
        work = nip.simulate(mechanism, case).evaluations
        line = timed(lambda case=case: nip.simulate(mechanism, case), repeats)  # type: ignore[misc]
        print(f"transition {speed:.0f} r/min     {line}   {work} evaluations")
        case = nip.Case(speed_rpm=speed, window=nip.Window.CYCLE)
        work = nip.simulate(mechanism, case).evaluations
        line = timed(lambda case=case: nip.simulate(mechanism, case), repeats)  # type: ignore[misc]
        print(f"cycle      {speed:.0f} r/min     {line}   {work} evaluations")
    command = [str(Path(sys.executable).with_name("nipper-pin")), "simulate", "--speed", "650"]
    process = timed(
        lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL), min(repeats, 5)
    )
    print(f"process, table           {process}")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
