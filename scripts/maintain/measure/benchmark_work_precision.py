"""What does a digit cost? Wall time against error of this package's engines and of its peers.

Run: python scripts/maintain/measure/benchmark_work_precision.py [REPEATS]

Prints the two tables only; ``python -m benchmarks run`` measures costs and skips as well.
"""

from __future__ import annotations

import sys

from benchmarks.run_time.certified import certified
from benchmarks.run_time.peer_work import peer_rows
from benchmarks.run_time.reduced_work import reduced_work
from benchmarks.run_time.timing import environment
from benchmarks.run_time.work_precision import Row, direct_rows


def show(row: Row) -> None:
    """Print one row."""
    worst = "-" if row.error_worst is None else f"{row.error_worst:8.1e}"
    print(
        f"{row.engine.partition(' (')[0]:40.40s} {row.setting:24s} {row.wall_ms:10.4g} ms "
        f"(fastest {row.fastest_ms:9.4g}, spread {row.spread_ms:8.2g})   {worst}   "
        f"{'-' if row.evaluations is None else row.evaluations} evaluations"
    )


def main(repeats: int = 20) -> None:
    """Print the environment and the rows."""
    print(*(f"{name}: {value}" for name, value in environment().items()), sep="\n")
    reference = certified()
    for row in direct_rows(reference, quick=False, repeats=repeats):
        show(row)
    rows, summary = reduced_work(reference, quick=False, repeats=repeats)
    for row in rows:
        show(row)
    print(f"reduced engine: {summary}")
    rows, failed = peer_rows(reference, quick=True, repeats=repeats, say=lambda _: None)
    for row in rows:
        show(row)
    for line in failed:
        print(f"not measured: {line}")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
