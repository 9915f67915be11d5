"""``nipper-pin plot``."""

from __future__ import annotations

import argparse

from ..extras import require
from .arguments import add_value


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument("folder", metavar="DIR", help="folder of a sweep")
    text = "what to draw (default: the first quantity of the study); may be repeated"
    parser.add_argument("--quantity", action="append", metavar="NAME", help=text)
    add_value(parser, "--x", "NAME", "parameter across, of the level lines", str)
    add_value(parser, "--y", "NAME", "parameter upwards, of the level lines", str)
    text = "of the figures (default svg)"
    parser.add_argument("--format", choices=("svg", "png", "pdf"), default="svg", help=text)
    add_value(parser, "--out", "DIR", "folder of the figures (default DIR/plots)", str)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    require("study", "matplotlib", "pyarrow", what="a plot of a sweep")
    from ..view.console import ending, unbroken_console
    from ..view.studies.sweep_plots import plot_sweep

    written = plot_sweep(
        options.folder,
        quantities=options.quantity,
        across=options.x,
        upwards=options.y,
        kind=options.format,
        target=options.out,
    )
    ending(unbroken_console(), written=map(str, written))
