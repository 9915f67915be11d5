"""``python -m benchmarks paper``."""

from __future__ import annotations

import argparse

from nipper_pin.cli.arguments import add_json, add_value, load_mechanism, output_folder
from nipper_pin.extras import require

from . import hand_over, tell


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "model", nargs="?", metavar="MODEL",
        help="the E62, another set of numbers for it, or another comber, on which the same is "
        "done without a comparison: a model's name, or a folder (default e62)",
    )  # fmt: skip
    parser.add_argument(
        "--set", action="append", default=[], metavar="PATH=VALUE",
        help="change a number of the model; may be repeated",
    )  # fmt: skip
    add_json(parser)
    text = "write JSON, table and plots into a folder"
    add_value(parser, "--out", "DIR", text, output_folder)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    require("study", "numba", "matplotlib", what="the published study")
    from ..paper.report import print_paper, write_paper
    from ..paper.study import paper_study

    hand_over(paper_study(load_mechanism(options), tell), options, write_paper, print_paper)
