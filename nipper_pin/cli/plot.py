"""``nipper-pin plot``."""

from __future__ import annotations

import argparse
import sys

from ..errors import one_line
from ..extras import require


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument("folder", metavar="DIR", help="folder of a sweep")
    parser.add_argument(
        "--quantity",
        action="append",
        metavar="NAME",
        help="what to draw (default: the first quantity of the study); may be repeated",
    )
    parser.add_argument("--x", metavar="NAME", help="parameter across, of the level lines")
    parser.add_argument("--y", metavar="NAME", help="parameter upwards, of the level lines")
    parser.add_argument(
        "--format",
        choices=["svg", "png", "pdf"],
        default="svg",
        help="of the figures (default svg)",
    )
    parser.add_argument("--out", metavar="DIR", help="folder of the figures (default DIR/plots)")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    require("study", "matplotlib", "pyarrow", what="a plot of a sweep")
    from ..view.studies.sweep_plots import plot_sweep

    written = plot_sweep(
        options.folder,
        quantities=options.quantity,
        across=options.x,
        upwards=options.y,
        kind=options.format,
        target=options.out,
    )
    for path in written:
        sys.stdout.write(f"{one_line(str(path))}\n")
