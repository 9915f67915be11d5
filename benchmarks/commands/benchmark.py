"""``python -m benchmarks run``."""

from __future__ import annotations

import argparse
import sys

from nipper_pin.cli.arguments import check_outputs, write_json
from nipper_pin.errors import InputError
from nipper_pin.extras import require


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

    if options.repeats is not None and options.repeats < 1:
        message = f"--repeats {options.repeats}: at least 1"
        raise InputError(message, argument=options.repeats)
    check_outputs(options.out, options.json)

    def say(text: str) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"{text} ...\n")

    result = benchmark(quick=options.quick, repeats=options.repeats, say=say)
    if options.out is not None:
        from ..views.benchmark_report import write_benchmark

        write_benchmark(result, options.out)
    if options.json is not None:
        write_json(result.record(), options.json)
    if options.json != "-":
        from nipper_pin.view.console import Terminal

        from ..views.benchmark_report import print_benchmark

        print_benchmark(result, Terminal())
