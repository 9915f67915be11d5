"""Is this version slower than another checkout, and does it give the same bits?

    python scripts/maintain/measure/compare_versions.py OTHER --rounds 30 --speed 650 --in-a-row 1

OTHER is the folder of another checkout (`git worktree add ../before COMMIT`). Both run here and now
with the libraries of this environment, in turns: a transition and a turn of e62 in a process that
has run them once, and `nipper-pin simulate` as a whole process. Times are seconds of the processor,
each the least of its rounds; the median of the ratios of each round, with their quartiles, tells
what the least could hide. Then the events of both are compared: times by the length of a turn,
coordinates and rates by the largest of their event, or by one rad or rad/s. Of a rest, times alone.

Of one run after another process both find their memory cold, as a single command does; of several
in a row, the mean of which counts, as in a batch, they find it warm.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import IO, Any

import numpy as np

HERE = Path(__file__).resolve().parents[3]
WINDOWS = ("transition", "cycle")
COMMAND = "import sys; from nipper_pin.cli import main; sys.exit(main())"
# Runs a window on request and answers with the seconds it took; "events" lists the numbers of both.
WORKER = """
import gc, json, sys, time
import nipper_pin as nip
mechanism = nip.load("e62")
cases = {w: nip.Case(speed_rpm=float(sys.argv[1]), window=nip.Window(w)) for w in sys.argv[3:]}
runs = {w: nip.simulate(mechanism, case) for w, case in cases.items()}
print(json.dumps(nip.__file__), flush=True)
gc.disable()
for line in sys.stdin:
    name = line.strip()
    if name == "events":
        answer = [[e.kind.value, e.t / run.shaft.period, *([] if e.kind.value == "rest" else
                   [list(e.q), list(e.v_before), list(e.v_after)])]
                  for run in runs.values() for e in run.events]
    else:
        began = time.process_time()
        for _ in range(int(sys.argv[2])):
            nip.simulate(mechanism, cases[name])
        answer = (time.process_time() - began) / int(sys.argv[2])
        gc.collect()
    print(json.dumps(answer), flush=True)
"""


class Version:
    """A checkout, and a process that runs it."""

    def __init__(self, root: Path, speed_rpm: float, in_a_row: int = 1) -> None:
        """Start the process.

        Raises:
            SystemExit: The process runs another checkout.
        """
        self._speed = f"{speed_rpm:g}"
        self._environment = {**os.environ, "PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"}
        # With cached bytecode, as in an installation.
        self._environment.pop("PYTHONDONTWRITEBYTECODE", None)
        self._process = subprocess.Popen(
            [sys.executable, "-c", WORKER, self._speed, str(in_a_row), *WINDOWS],
            env=self._environment, cwd=root, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        found = Path(self._read())
        if not found.is_relative_to(root):
            sys.exit(f"{root} was to be measured, and {found} runs")
        self.command()

    def _read(self) -> Any:
        stream: IO[str] = self._process.stdout  # type: ignore[assignment]
        return json.loads(stream.readline())

    def ask(self, name: str) -> Any:
        """Seconds of a window, or the numbers of all events."""
        stream: IO[str] = self._process.stdin  # type: ignore[assignment]
        stream.write(f"{name}\n")
        stream.flush()
        return self._read()

    def command(self) -> float:
        """Seconds of the processor of `nipper-pin simulate e62`."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, "-c", COMMAND, "simulate", "e62", "--speed", self._speed],
            env=self._environment, cwd="/", check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    """Measure in turns; status 1 if the events differ."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("other", type=Path)
    parser.add_argument("--rounds", type=int, default=30)
    parser.add_argument("--speed", type=float, default=650.0, help="r/min")
    parser.add_argument(
        "--in-a-row", type=int, default=1, help="runs of a round, the mean of which counts"
    )
    options = parser.parse_args()
    roots = HERE, options.other.resolve()
    this, other = (Version(root, options.speed, options.in_a_row) for root in roots)
    for name in (*WINDOWS, "process"):
        pairs = []
        for number in range(options.rounds):
            order = (this, other) if number % 2 else (other, this)
            seconds = {v: v.command() if name == "process" else v.ask(name) for v in order}
            pairs.append((seconds[this], seconds[other]))
        low, middle, high = np.quantile([a / b for a, b in pairs], (0.25, 0.5, 0.75))
        ours, theirs = (min(column) for column in zip(*pairs, strict=True))
        print(
            f"{name:10}  this {1e3 * ours:8.2f} ms, other {1e3 * theirs:8.2f} ms, "
            f"{ours / theirs:.3f}; median {middle:.3f} ({low:.3f} to {high:.3f})",
            flush=True,
        )
    return _compared(this.ask("events"), other.ask("events"))


def _compared(mine: list[Any], theirs: list[Any]) -> int:
    """Print how far events lie apart; status 1 if they are others, or beyond 1e-13."""
    if [item[0] for item in mine] != [item[0] for item in theirs]:
        print(f"{len(mine)} events and {len(theirs)}, not the same ones")
        return 1
    if mine == theirs:
        print(f"{len(mine)} events: the same bits")
        return 0
    times, share = 0.0, 0.0
    for one, two in zip(mine, theirs, strict=True):
        times = max(times, abs(one[1] - two[1]))
        for here, there in zip(one[2:], two[2:], strict=True):
            apart = max(abs(x - y) for x, y in zip(here, there, strict=True))
            share = max(share, apart / max(1.0, *map(abs, there)))
    print(f"{len(mine)} events: times {times:.1e} of a turn, coordinates and rates {share:.1e}")
    return 0 if max(times, share) <= 1e-13 else 1


if __name__ == "__main__":
    sys.exit(main())
