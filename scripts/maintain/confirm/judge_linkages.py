"""Machines run by the package and by the planar solver of the tests, one line each.

    cd scripts/maintain/confirm
    python judge_linkages.py FOLDER... [--speed RPM ...] [--drive held inertial] [--turns N]
    python judge_linkages.py --gallery [--speed-factor 0.5 1 2] [--drive held inertial]
    python judge_linkages.py --random 500 [--first 0] [--seed 421] [--workers 2]

A machine agrees in part if round-off decides on its motion from some time on (the line says when).
A line holds the worst differences of event times [s], and relative ones of rates, of impulses and
energies, and of the forces of stops and drives; or why one of the two does not run the machine. The
status is 1 if a machine differs by more than 1e-10 s or 1e-8 (where the package states a larger
error of an event: by more than that), if only one of the two refuses it, or if the two together
need more than --time-limit.
Random linkages are those of `python -m benchmarks stress --family linkage`, with their own speed
and drive.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

TESTS = Path(__file__).resolve().parents[3] / "tests"


class Run(NamedTuple):
    """What is compared: a folder, speed [r/min], drive, turns, start, events, time limit [s]."""

    folder: Path
    speed_rpm: float
    drive: str
    turns: int
    start_index: float
    most: int
    time_limit_s: float


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
    parser.add_argument("--most", type=int, default=20_000, metavar="N",
                        help="events of a machine that are compared at most")  # fmt: skip
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--time-limit", type=float, default=600.0, metavar="S",
                        help="seconds of the processor for one machine")  # fmt: skip
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    with (
        tempfile.TemporaryDirectory() as home,
        get_context("spawn").Pool(options.workers, maxtasksperchild=20) as pool,
    ):
        for verdict, line in pool.imap(_judged, _runs(options, Path(home))):
            counts[verdict] += 1
            print(line, flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 0 if set(counts) <= {"agree", "agree in part", "refused by both"} else 1


def _judged(run: Run) -> tuple[str, str]:
    """Verdict and line of one machine."""
    sys.path.insert(0, str(TESTS))
    compare: Any = import_module("judged_runs").compare
    began = time.process_time()
    signal.signal(signal.SIGPROF, _too_long)
    signal.setitimer(signal.ITIMER_PROF, run.time_limit_s)
    try:
        report = compare(
            run.folder, run.speed_rpm, run.drive, run.turns, start_index=run.start_index,
            most=run.most,
        )  # fmt: skip
        report.model = run.folder.name
        verdict, line = report.verdict, report.line()
    except TimeoutError:
        verdict = "not judged in time"
        line = f"{run.folder.name}: {verdict}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    spent = time.process_time() - began
    return verdict, f"{line}; {run.speed_rpm:g} r/min, {run.drive}, {spent:.0f} s"


def _too_long(*_: object) -> None:
    """The time of a machine has passed."""
    raise TimeoutError


def _runs(options: argparse.Namespace, home: Path) -> Iterator[Run]:
    folders, more = (
        list(options.folders),
        (
            options.start_index,
            options.most,
            options.time_limit,
        ),
    )
    if options.gallery:
        from nipper_pin import export
        from nipper_pin.mechanism.gallery import GALLERY, drawn

        folders += [export(drawn(name).mechanism(), home / name) for name in GALLERY]
    for folder in folders:
        for speed in options.speed or [factor * _rated(folder) for factor in options.speed_factor]:
            for drive in options.drive:
                yield Run(folder, speed, drive, options.turns, *more)
    if options.random:
        from benchmarks.stress.linkages import write_linkage

        for number in range(options.first, options.first + options.random):
            folder = home / f"linkage_{number}"
            case = write_linkage(options.seed, number, folder)
            yield Run(folder, case["speed_rpm"], case["drive"], case["cycles"], *more)


def _rated(folder: Path) -> float:
    """Rated speed of a model [r/min]."""
    document = tomllib.loads((folder / f"{folder.resolve().name}.toml").read_text("utf-8"))
    return float(document["cylinder"]["rated_speed_rpm"])


if __name__ == "__main__":
    sys.exit(main())
