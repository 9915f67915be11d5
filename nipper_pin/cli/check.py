"""``nipper-pin check``."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from ..errors import NipperError
from ..hybrid import START_INDEX
from ..mechanism.model_files import find_files
from .arguments import (
    MODEL,
    add_flag,
    add_model,
    add_value,
    check_figure,
    load_mechanism,
    machine_words,
    output_file,
    refuse_beside,
    speed,
    write_document,
)
from .case_options import add_start

_PAUSE_S = 0.3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    add_start(parser)
    text = "draw the mechanism with the names of its parts: NAME.svg, NAME.png or NAME.pdf"
    add_value(parser, "--drawing", "FILE", text, output_file)
    add_flag(parser, "--provenance", "print where each number of the model comes from")
    text = "check, and draw, again whenever a file of the model is saved; Ctrl-C ends"
    add_flag(parser, "--watch", text)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if options.watch:
        _watch(options)
    else:
        _check(options)


def _watch(options: argparse.Namespace) -> None:
    """Check now, and whenever a file of the model is saved."""
    from ..view.console import Terminal, say

    if options.json == "-":
        refuse_beside(options, "--json -, which is one document", "--watch")
    files, seen = find_files(options.model or MODEL), dict[Path, float]()
    while True:
        there = [files.toml, *files.folder.glob("*.csv")]
        there += [] if files.urdf is None else [files.urdf]
        # A program may save by writing another file in its place.
        saved = {file: file.stat().st_mtime for file in there if file.is_file()}
        if files.toml in saved and saved != seen:
            seen = saved
            try:
                _check(options)
            except NipperError as error:
                say(Terminal(), error.message)
            say(Terminal(), "Watching: it is checked again when it is saved; Ctrl-C ends.")
            sys.stdout.flush()
        time.sleep(_PAUSE_S)


def _check(options: argparse.Namespace) -> None:
    from ..study.check import check

    if options.json == "-":
        refuse_beside(options, "--json -, whose document holds all of it", "--provenance")
    check_figure(options.drawing, "view", "the drawing")
    mechanism = load_mechanism(options)
    start = getattr(options, "start_index", START_INDEX)
    report = check(mechanism, speed(options, mechanism), start)
    if options.drawing is not None:
        from ..view.sketch import write_sketch

        write_sketch(mechanism, options.drawing)
    if write_document(report.record, options.json):
        from ..study.next_steps import next_steps
        from ..view.console import Terminal, ending
        from ..view.studies.check_report import print_report

        console = Terminal()
        begin = ["--start-index", f"{start:g}"] if hasattr(options, "start_index") else []
        model, *changes = machine_words(options)
        steps = next_steps(report, model, changes, begin)
        print_report(report, steps, console, provenance=options.provenance)
        ending(console, written=(options.drawing, options.json))
