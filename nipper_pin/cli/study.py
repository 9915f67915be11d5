"""``nipper-pin study``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from .arguments import load_mechanism, write_json

if TYPE_CHECKING:
    from ..study.paper import PaperStudy

_FOLDER = "out/paper"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    studies = parser.add_subparsers(dest="study", required=True, metavar="STUDY")
    paper = studies.add_parser(
        "paper",
        help="the published study of the E62 nipper, compared, and what it leaves open",
    )
    paper.add_argument(
        "model",
        nargs="?",
        default="e62",
        metavar="MODEL",
        help="the E62 or another set of numbers for it: a model's name, or a folder",
    )
    paper.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        help="change a number of the model; may be repeated",
    )
    paper.add_argument(
        "--out",
        metavar="DIR",
        help="folder of the report, its figures (SVG, PDF) and tables (CSV); "
        f"{_FOLDER} if neither this nor --json is given",
    )
    paper.add_argument(
        "--identification",
        metavar="FILE",
        help="show what `nipper-pin identify --json FILE` wrote in the report",
    )
    paper.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")
    # Restitution and spring rate are what the study varies.
    paper.set_defaults(run=_run, restitution=None, stiffness=None)


def _run(options: argparse.Namespace) -> None:
    from ..study.paper import paper_study

    def say(text: str) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"{text} ...\n")

    folder = options.out
    if folder is None and options.json is None:
        folder = _FOLDER
    mechanism = load_mechanism(options)
    result = paper_study(mechanism, say)
    if folder is not None:
        report = _write(result, folder, options.identification, say)
    if options.json is not None:
        write_json(result.record(), options.json)
    if options.json == "-":
        return
    from rich.console import Console

    from ..view.paper.summary import print_paper

    console = Console()
    print_paper(result, console)
    if folder is not None:
        console.print(f"report: {report}", soft_wrap=True)


def _write(
    result: PaperStudy, folder: str, identification: str | None, say: Callable[[str], None]
) -> Path:
    """Write the report with sensitivities, and with an identification if there is one."""
    from ..study.sensitivity import sensitivities
    from ..view.paper.files import write_paper
    from ..view.paper.supplements import Supplements, read_identification

    document = None if identification is None else read_identification(identification)
    say("sensitivities")
    found = sensitivities(result.mechanism, result.published.common_speed_rpm)
    say("figures")
    return write_paper(result, folder, Supplements(found, document))[0]
