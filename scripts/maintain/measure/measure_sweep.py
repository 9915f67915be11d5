"""Time, bytes and memory of a scenario of a sweep: the table of docs/sweeps_cluster.md.

With the word ``turns`` it says instead from how many cases on the reduced engine pays for turns.
"""

import os

# One thread, as in the workers of a sweep; read when numpy is imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from nipper_pin import load, transition_table, turn_table
from nipper_pin.study.sweep import Plan, read_plan
from nipper_pin.study.sweep.chunks import run_chunk

STUDIES = Path(__file__).parents[2]
MACHINES = """
format = 1
quantities = ["duration_s", "rebound_amplitude_1"]
[samples]
method = "sobol"
count = 256
[parameters."drives.tension.ratio"]
low = 2.0
high = 2.4
[parameters."points.eccentric_pin.radius_mm"]
low = 4.0
high = 6.0
"""
SPEEDS = "[parameters.speed_rpm]\nlow = 400.0\nhigh = 700.0\npoints = 100\n"


def cost(plan: Plan, chunks: int) -> tuple[float, float, int]:
    """Least processor time of a chunk after the first [s], bytes of a row, rows of a chunk."""
    text, times = plan.job.text(), []
    for chunk, rows in plan.rows(plan.chunks()[: chunks + 1]):
        begin = time.process_time()
        content = run_chunk(text, chunk.start, rows)
        times.append((time.process_time() - begin) / len(rows))
    return len(rows) * min(times[1:]), len(content) / len(rows), len(rows)


def pays(table: Callable[..., Any]) -> None:
    """Print from how many cases on the reduced engine pays.

    Only what is measured first in a process loads compiled code.
    """

    def seconds(engine: Literal["direct", "reduced"], cases: int, ratio: float) -> float:
        mechanism = load("e62", {"drives.tension.ratio": ratio})
        speeds = np.linspace(450.0, 640.0, cases)
        begin = time.process_time()
        table(mechanism, speed_rpm=speeds, engine=engine)
        return time.process_time() - begin

    # What both engines load; then what the reduced one alone does.
    seconds("direct", 2, 2.0)
    first = seconds("reduced", 2, 2.0)
    direct = min(seconds("direct", 16, 2.01 + 0.01 * k) for k in range(5)) / 16.0
    tables = min(seconds("reduced", 2, 2.01 + 0.01 * k) for k in range(5))
    print(
        f"{table.__name__}: a direct case {1e3 * direct:.3g} ms; tables of a machine "
        f"{tables / direct:.3g} and compiled code {(first - tables) / direct:.3g} times that: the "
        "reduced engine pays from "
        f"{first / direct:.0f} cases on, and from {tables / direct:.0f} where the code is loaded"
    )


def main() -> None:
    """Print the table."""
    if sys.argv[1:] == ["turns"]:
        pays(turn_table)
        return
    pays(transition_table)
    for name in ("sweep_spring", "sweep_billion"):
        seconds, size, rows = cost(read_plan(str(STUDIES / f"{name}.toml")), 4)
        print(
            f"{name}: {1e6 * seconds / rows:.3g} us a scenario, {seconds:.3g} s a chunk of {rows}, "
            f"{size:.3g} bytes a row"
        )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "machines.toml"
        for text, what in ((MACHINES, "one speed"), (MACHINES + SPEEDS, "100 speeds")):
            file.write_text(text, encoding="utf-8")
            plan = read_plan(str(file))
            seconds, _, rows = cost(plan, 3)
            machines = rows * plan.mechanisms / plan.scenarios
            print(f"machines with {what}: {1e3 * seconds / machines:.3g} ms each")
    # Kilobytes on Linux.
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"memory: {memory:.0f} MB")


if __name__ == "__main__":
    main()
