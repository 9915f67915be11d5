"""``nipper-pin speed-limit``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ..extras import require
from .arguments import (
    MODEL,
    add_json,
    add_machine,
    add_number,
    check_figure,
    check_outputs,
    command,
    load_mechanism,
    machine_words,
    rpm,
    write_document,
)

if TYPE_CHECKING:
    from ..study.speed_limit import SpeedLimit

# Speeds by the rated one where none are given.
_SLOWEST, _FASTEST = 0.5, 4.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_machine(parser)
    parser.add_argument(
        "--from", dest="low", type=rpm, metavar="RPM", help="least speed; half the rated"
    )
    parser.add_argument(
        "--to", dest="high", type=rpm, metavar="RPM", help="largest speed; four times the rated"
    )
    add_number(parser, "--speeds", "N", "number of speeds (default 241)", int, 241)
    add_number(parser, "--turns", "N", "most turns followed at a speed (default 400)", int, 400)
    text = "force above which the stop clamps [N] (default 0)"
    add_number(parser, "--least-force", "N", text, default=0.0)
    parser.add_argument("--plot", metavar="FILE", help="draw the turns by speed (PNG, SVG, PDF)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Follow the turns, and tell how fast the machine can run."""
    check_outputs(None, options.json)
    require("study", "numba", what="the speed limit")
    check_figure(options.plot, "study", "the figure of the speed limit")
    mechanism = load_mechanism(options)
    rated = mechanism.cylinder.rated_speed_rpm

    from ..study.speed_limit import speed_limit

    result = speed_limit(
        mechanism,
        low_rpm=_SLOWEST * rated if options.low is None else options.low,
        high_rpm=_FASTEST * rated if options.high is None else options.high,
        speeds=options.speeds,
        turns=options.turns,
        least_force=options.least_force,
    )
    if options.plot is not None:
        from ..view.figure_file import write_figure
        from ..view.studies.speed_limit_plot import speed_limit_figure

        write_figure(speed_limit_figure(result), options.plot)
    if not write_document(result.record, options.json):
        return
    from ..view.console import Terminal, ending
    from ..view.studies.speed_limit_report import print_speed_limit

    console = Terminal()
    print_speed_limit(result, console)
    ending(console, _next(options, result), (options.plot, options.json))


def _next(options: argparse.Namespace, result: SpeedLimit) -> str:
    """Command line of a turn where the stop first ceases to rest, or at the least speed."""
    from ..study.speed_limit import Verdict

    ends = (part.high_rpm for part in result.settled if part.verdict is Verdict.YES)
    speed = next(ends, float(result.speed_rpm[0]))
    machine = (options.model or MODEL, *machine_words(options))
    return command("simulate", *machine, "--speed", f"{speed:.5g}", "--window", "cycle")
