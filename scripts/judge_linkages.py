"""Model folders run by the package and by the planar solver of the tests, one line each.

    python scripts/judge_linkages.py FOLDER... [--speed RPM ...] [--drive held inertial] [--turns N]

A line holds the worst differences of event times [s], and relative ones of rates, of impulses and
energies, and of the forces of stops and drives; or why one of the two does not run the machine. The
status is 1 if a machine differs by more than 1e-10 s or 1e-8, or only one of the two refuses it.
"""

from __future__ import annotations

import argparse
import sys
import time
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

TESTS = Path(__file__).resolve().parents[1] / "tests"


def main() -> int:
    """Compare the models of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--speed", nargs="+", type=float, metavar="RPM", help="default: rated")
    parser.add_argument("--drive", nargs="+", choices=("held", "inertial"), default=["held"])
    parser.add_argument("--turns", type=int, default=1)
    parser.add_argument("--start-index", type=float, default=24.0)
    options = parser.parse_args()
    sys.path.insert(0, str(TESTS))
    compare: Any = import_module("judged_runs").compare
    counts: dict[str, int] = {}
    for folder in options.folders:
        for speed in options.speed or [rated(folder)]:
            for drive in options.drive:
                began = time.perf_counter()
                report = compare(
                    folder, speed, drive, options.turns, start_index=options.start_index
                )
                counts[report.verdict] = counts.get(report.verdict, 0) + 1
                spent = time.perf_counter() - began
                print(f"{report.line()}; {speed:g} r/min, {drive}, {spent:.0f} s", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 0 if set(counts) <= {"agree", "refused by both"} else 1


def rated(folder: Path) -> float:
    """Rated speed of a model [r/min]."""
    document = tomllib.loads((folder / f"{folder.resolve().name}.toml").read_text("utf-8"))
    return float(document["cylinder"]["rated_speed_rpm"])


if __name__ == "__main__":
    sys.exit(main())
