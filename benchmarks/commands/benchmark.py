"""``python -m benchmarks run``."""

from __future__ import annotations

import argparse

from nipper_pin.cli.arguments import add_flag, add_json, add_value, output_folder
from nipper_pin.extras import require

from . import hand_over, need_least, tell


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_flag(parser, "--quick", "fewer settings and repeats: less than a minute")
    text = "runs of each setting after the first (default 30, quick 10)"
    add_value(parser, "--repeats", "N", text, int)
    add_json(parser)
    text = "write JSON, tables and a plot into a folder"
    add_value(parser, "--out", "DIR", text, output_folder)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    # The reduced engine and the compiled peers are measured, and the work is drawn over the error.
    require("study", "numba", "matplotlib", what="the benchmark")
    from ..run_time.benchmark import benchmark
    from ..views.benchmark_report import print_benchmark, write_benchmark

    need_least(options, repeats=1)

    result = benchmark(quick=options.quick, repeats=options.repeats, say=tell)
    hand_over(result, options, write_benchmark, print_benchmark)
