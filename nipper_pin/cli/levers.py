"""``nipper-pin levers``."""

from __future__ import annotations

import argparse

from ..view.progress import progress
from .arguments import (
    add_model,
    command,
    load_mechanism,
    machine_words,
    write_document,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..study.levers import levers

    mechanism = load_mechanism(options)
    with progress("numbers") as tell:
        found = levers(mechanism, options.speed, tell)
    if not write_document(found.record, options.json):
        return
    from ..view.console import Terminal
    from ..view.studies.levers_report import print_levers

    again = command("compare", *machine_words(options))
    print_levers(found, Terminal(), again)
