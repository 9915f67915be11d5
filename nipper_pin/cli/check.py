"""``nipper-pin check``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..extras import require
from ..hybrid import START_INDEX
from ..outputs import check_file
from .arguments import (
    MODEL,
    add_model,
    check_outputs,
    load_mechanism,
    machine_words,
    refuse_beside,
    speed,
    write_json,
)
from .case_options import add_start


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    add_start(parser)
    parser.add_argument(
        "--drawing",
        metavar="FILE",
        help="draw the mechanism with the names of its parts: NAME.svg, NAME.png or NAME.pdf",
    )
    parser.add_argument(
        "--provenance", action="store_true", help="print where each number of the model comes from"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..study.check import check_model

    if options.json == "-":
        refuse_beside(
            options, "--json -, whose document holds all of it", {"provenance": "--provenance"}
        )
    check_outputs(None, options.json)
    if options.drawing is not None:
        require("view", "matplotlib", what="the drawing")
        check_file(options.drawing)
        from ..view.sketch import drawing_format

        drawing_format(Path(options.drawing))
    mechanism = load_mechanism(options)
    start = getattr(options, "start_index", START_INDEX)
    report = check_model(mechanism, speed(options, mechanism), start)
    if options.drawing is not None:
        from ..view.sketch import write_sketch

        write_sketch(mechanism, options.drawing)
    if options.json is not None:
        write_json(report.record(), options.json)
    if options.json != "-":
        from ..study.next_steps import next_steps
        from ..view.console import Terminal, paste
        from ..view.studies.check_report import print_report

        console = Terminal()
        begin = ["--start-index", f"{start:g}"] if hasattr(options, "start_index") else []
        steps = next_steps(report, options.model or MODEL, machine_words(options), begin)
        print_report(report, steps, console, provenance=options.provenance)
        if options.drawing is not None:
            paste(console, f"drawing: {options.drawing}")
