"""``nipper-pin speed-limit``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ..extras import require
from .arguments import (
    add_json,
    add_machine,
    add_value,
    check_figure,
    command,
    load_mechanism,
    machine_words,
    output_file,
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
    add_value(parser, "--from", "RPM", "least speed; half the rated", rpm)
    add_value(parser, "--to", "RPM", "largest speed; four times the rated", rpm)
    add_value(parser, "--speeds", "N", "number of speeds (default 241)", int, 241)
    add_value(parser, "--turns", "N", "most turns followed at a speed (default 400)", int, 400)
    text = "force above which the stop clamps [N] (default 0)"
    add_value(parser, "--least-force", "N", text, default=0.0)
    add_value(parser, "--plot", "FILE", "draw the turns by speed (PNG, SVG, PDF)", output_file)
    add_json(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    require("study", "numba", what="the speed limit")
    from ..study.speed_limit import speed_limit

    check_figure(options.plot, "study", "the figure of the speed limit")
    mechanism = load_mechanism(options)
    rated = mechanism.cylinder.rated_speed_rpm
    start = getattr(options, "from")
    result = speed_limit(
        mechanism,
        low_rpm=_SLOWEST * rated if start is None else start,
        high_rpm=_FASTEST * rated if options.to is None else options.to,
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
    turn = ("--speed", f"{speed:.5g}", "--window", "cycle")
    return command("simulate", *machine_words(options), *turn)
