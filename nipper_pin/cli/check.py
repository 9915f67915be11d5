"""``nipper-pin check``."""

from __future__ import annotations

import argparse

from .arguments import MODEL, add_model, check_outputs, load_mechanism, speed, write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..study.check import check_model

    check_outputs(None, options.json)
    mechanism = load_mechanism(options)
    report = check_model(mechanism, speed(options, mechanism))
    if options.json is not None:
        write_json(report.record(), options.json)
    if options.json != "-":
        from rich.console import Console

        from ..study.next_steps import next_steps
        from ..view.report import print_report

        console = Console()
        print_report(report, console)
        console.print("Next", style="bold")
        for step in next_steps(report, options.model or MODEL):
            console.print(step, markup=False, highlight=False, soft_wrap=True)
