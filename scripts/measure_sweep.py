"""What a scenario of a sweep costs here: time, bytes, memory. The table of docs/sweeps.md."""

import os

# One thread, as in the workers of a sweep; read when numpy is imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import resource
import tempfile
import time
from pathlib import Path

from nipper_pin.study.sweep import Plan, read_plan
from nipper_pin.study.sweep.chunks import run_chunk

HERE = Path(__file__).parent
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


def main() -> None:
    """Print the table."""
    for name in ("sweep_spring", "sweep_billion"):
        seconds, size, rows = cost(read_plan(str(HERE / f"{name}.toml")), 4)
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
