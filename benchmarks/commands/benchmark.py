"""``python -m benchmarks run``."""

from __future__ import annotations

import argparse

from nipper_pin.cli.arguments import check_outputs
from nipper_pin.extras import require

from . import hand_over, need_least, tell


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "--quick", action="store_true", help="fewer settings and repeats: less than a minute"
    )
    parser.add_argument(
        "--repeats",
        type=int,
        metavar="N",
        help="runs of each setting after the first (default 30, quick 10)",
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")
    parser.add_argument("--out", metavar="DIR", help="write JSON, tables and a plot into a folder")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    # The reduced engine and the compiled peers are measured, and the work is drawn over the error.
    require("study", "numba", "matplotlib", what="the benchmark")
    from ..run_time.benchmark import benchmark
    from ..views.benchmark_report import print_benchmark, write_benchmark

    need_least(options, repeats=1)
    check_outputs(options.out, options.json)

    result = benchmark(quick=options.quick, repeats=options.repeats, say=tell)
    hand_over(result, options, write_benchmark, print_benchmark)
