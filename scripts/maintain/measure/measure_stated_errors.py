"""True over stated error of the E62-class model, against a solution that shares nothing with it.

    python scripts/maintain/measure/measure_stated_errors.py --cases 200 [--turns | --dimensions]

Random machines (speed, restitution, spring, also touch angles at which the jaw touches slowly) are
solved in 80-bit arithmetic by tests/reference/extended.py, and by both engines at many tolerances,
transitions and whole turns, in processes with other BLAS kernels, of which each case has one. With
--turns all are whole turns, of the reduced engine, with their quantities; with --dimensions all
numbers of the machine differ, by up to ten per cent. The folder (--folder) keeps each case that is
done: the same command goes on where it was stopped, and a larger --cases adds to it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from stated_errors.ratios import judged
from stated_errors.truth import solved, trial

# Values of OPENBLAS_CORETYPE; with and without AVX-512, and without AVX2.
KERNELS = ("SkylakeX", "Haswell", "Sandybridge")
_CASES_OF_A_KERNEL = 30


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    """Whole lines of a file of results."""
    if path.exists():
        for line in path.read_text().splitlines():
            yield json.loads(line)


def _append(path: Path, row: dict[str, Any]) -> None:
    with path.open("a") as file:
        file.write(json.dumps(row) + "\n")


def solve(folder: Path, seed: int, count: int, **kind: bool) -> None:
    """Independent solutions of all cases."""
    path = folder / "truth.jsonl"
    done = {row["trial"]["number"] for row in _lines(path)}
    for number in range(count):
        if number not in done:
            _append(path, solved(trial(seed, number, **kind)))


def judge(folder: Path, kernel: str, count: int, *, direct: bool) -> None:
    """Both engines with one BLAS kernel."""
    path = folder / f"{kernel}.jsonl"
    done = {row["number"] for row in _lines(path)}
    for row in _lines(folder / "truth.jsonl"):
        number = row["trial"]["number"]
        own = KERNELS[number // _CASES_OF_A_KERNEL % len(KERNELS)] == kernel
        if own and number < count and number not in done:
            _append(path, judged(row, direct=direct))


def report(folder: Path, count: int) -> None:
    """Print quantiles of all ratios, and how many cases could not be compared."""
    values: dict[tuple[str, str, str, float], list[float]] = {}
    notes = cases = 0
    worst: list[tuple[float, str]] = []
    for kernel in KERNELS:
        for row in _lines(folder / f"{kernel}.jsonl"):
            if row["number"] >= count:
                continue
            cases += 1
            notes += bool(row["notes"])
            for engine, window, what, tolerance, ratio in row["rows"]:
                values.setdefault((engine, window, what, tolerance), []).append(ratio)
                if ratio > 1.0:
                    label = f"case {row['number']} {kernel} {engine} {window} {what} {tolerance:g}"
                    worst.append((ratio, label))
    pooled: dict[tuple[str, str, str, float], list[float]] = {}
    for (engine, window, what, _), ratios in values.items():
        pooled.setdefault((engine, window, what, math.inf), []).extend(ratios)
    columns = ("tolerance", "number", "5 %", "median", "95 %", "most")
    print(f"{'':<44}" + "".join(f"{name:>10}" for name in columns))
    for (engine, window, what, tolerance), ratios in sorted((values | pooled).items()):
        quantiles = np.quantile(ratios, (0.05, 0.5, 0.95), method="lower")
        numbers = "".join(f"{x:>10.2g}" for x in (*quantiles, max(ratios)))
        label = "all" if tolerance == math.inf else f"{tolerance:.0e}"
        print(f"{engine:<8}{window:<12}{what:<24}{label:>10}{len(ratios):>10}{numbers}")
    print(f"{cases} cases, {notes} of them compared in part or not at all")
    print(f"{len(worst)} of {sum(map(len, values.values()))} ratios above 1")
    for ratio, label in sorted(worst, reverse=True)[:20]:
        print(f"  {ratio:8.3g}  {label}")


def main() -> None:
    """Solve, judge with every kernel, report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=19)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--turns", action="store_true", help="turns of the reduced engine only")
    parser.add_argument("--dimensions", action="store_true", help="machines of other dimensions")
    parser.add_argument("--kernel", choices=KERNELS, help="judge with this one, no report")
    given = parser.parse_args()
    if given.folder is None:
        kind = "turns" if given.turns else "dimensions" if given.dimensions else "errors"
        given.folder = Path("build") / f"stated_{kind}"
    given.folder.mkdir(parents=True, exist_ok=True)
    if given.kernel:
        judge(given.folder, given.kernel, given.cases, direct=not given.turns)
        return
    solve(given.folder, given.seed, given.cases, turns=given.turns, dimensions=given.dimensions)
    for kernel in KERNELS:
        command = [sys.executable, __file__, "--kernel", kernel, "--cases", str(given.cases)]
        command += ["--turns"] if given.turns else []
        environment = os.environ | {"OPENBLAS_CORETYPE": kernel}
        subprocess.run([*command, "--folder", str(given.folder)], env=environment, check=True)
    report(given.folder, given.cases)


if __name__ == "__main__":
    main()
