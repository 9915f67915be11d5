"""``python -m benchmarks run``."""

from __future__ import annotations

import argparse

from nipper_pin.cli.arguments import add_flag, add_json, add_value, output_folder
from nipper_pin.errors import SimulationError
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
    text = "status 1 if a setting became slower than in the recorded run, by the peers of both"
    add_flag(parser, "--no-slower", text)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    # The reduced engine and the compiled peers are measured, and the work is drawn over the error.
    require("study", "numba", "matplotlib", what="the benchmark")
    from nipper_pin.view.console import Terminal

    from ..run_time.benchmark import benchmark
    from ..run_time.recorded import read_record, slower
    from ..views.benchmark_report import print_benchmark, print_slower, write_benchmark

    need_least(options, repeats=1)

    result = benchmark(quick=options.quick, repeats=options.repeats, say=tell)
    hand_over(result, options, write_benchmark, print_benchmark)
    worse = slower(result.record(), read_record())
    if options.json != "-":
        print_slower(worse, Terminal())
    if worse and options.no_slower:
        first = f"{worse[0].engine} at {worse[0].setting} takes {worse[0].ratio:.2f} times as long"
        message = f"settings that became slower: {len(worse)}; {first}"
        raise SimulationError(message, ratio=worse[0].ratio)
