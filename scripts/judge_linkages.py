"""Machines run by the package and by the planar solver of the tests, one line each.

    python scripts/judge_linkages.py FOLDER... [--speed RPM ...] [--drive held inertial] [--turns N]
    python scripts/judge_linkages.py --gallery [--speed-factor 0.5 1 2] [--drive held inertial]
    python scripts/judge_linkages.py --random 500 [--first 0] [--seed 421]

A line holds the worst differences of event times [s], and relative ones of rates, of impulses and
energies, and of the forces of stops and drives; or why one of the two does not run the machine. The
status is 1 if a machine differs by more than 1e-10 s or 1e-8, or only one of the two refuses it.
Random linkages are those of `nipper-pin stress --family linkage`, with their own speed and drive.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

TESTS = Path(__file__).resolve().parents[1] / "tests"


class Run(NamedTuple):
    """What is compared: a model folder, speed [r/min], drive and number of turns."""

    folder: Path
    speed_rpm: float
    drive: str
    turns: int


def main() -> int:
    """Compare the machines of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, metavar="FOLDER")
    parser.add_argument("--gallery", action="store_true", help="all machines of the gallery")
    parser.add_argument("--random", type=int, metavar="N", help="so many random linkages")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--seed", type=int, default=421, help="of the random linkages")
    parser.add_argument("--speed", nargs="+", type=float, metavar="RPM", help="default: rated")
    parser.add_argument("--speed-factor", nargs="+", type=float, default=[1.0], metavar="F",
                        help="speeds by the rated one")  # fmt: skip
    parser.add_argument("--drive", nargs="+", choices=("held", "inertial"), default=["held"])
    parser.add_argument("--turns", type=int, default=1)
    parser.add_argument("--start-index", type=float, default=24.0)
    options = parser.parse_args()
    sys.path.insert(0, str(TESTS))
    compare: Any = import_module("judged_runs").compare
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as home:
        for run in _runs(options, Path(home)):
            began = time.perf_counter()
            report = compare(*run, start_index=options.start_index)
            counts[report.verdict] += 1
            spent = time.perf_counter() - began
            print(f"{report.line()}; {run.speed_rpm:g} r/min, {run.drive}, {spent:.0f} s",
                  flush=True)  # fmt: skip
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 0 if set(counts) <= {"agree", "refused by both"} else 1


def _runs(options: argparse.Namespace, home: Path) -> Iterator[Run]:
    folders = list(options.folders)
    if options.gallery:
        from nipper_pin.mechanism.drawing import write_drawing
        from nipper_pin.mechanism.gallery import GALLERY

        folders += [write_drawing(draw(), home / name) for name, draw in GALLERY.items()]
    for folder in folders:
        for speed in options.speed or [factor * _rated(folder) for factor in options.speed_factor]:
            for drive in options.drive:
                yield Run(folder, speed, drive, options.turns)
    if options.random:
        from nipper_pin.study.stress.linkages import write_linkage

        for number in range(options.first, options.first + options.random):
            folder = home / f"linkage_{number}"
            case = write_linkage(options.seed, number, folder)
            yield Run(folder, case["speed_rpm"], case["drive"], case["cycles"])


def _rated(folder: Path) -> float:
    """Rated speed of a model [r/min]."""
    document = tomllib.loads((folder / f"{folder.resolve().name}.toml").read_text("utf-8"))
    return float(document["cylinder"]["rated_speed_rpm"])


if __name__ == "__main__":
    sys.exit(main())
