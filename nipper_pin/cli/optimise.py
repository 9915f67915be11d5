"""``nipper-pin optimise``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import SimulationError
from ..extras import require
from ..view.progress import progress
from .arguments import (
    add_flag,
    add_json,
    add_value,
    add_workers,
    refuse_beside,
    write_document,
)

_POINTS = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    text = "what is free, what is to be small, what has to hold"
    parser.add_argument("study", metavar="STUDY.toml", help=text)
    text = "folder of the results (default out/ and the name of the study)"
    add_value(parser, "--out", "DIR", text, str)
    add_value(parser, "--seed", "N", "seed of the starts (default 1)", int, 1)
    add_value(parser, "--starts", "N", "descents by each aim (default 6)", int, 6)
    text = f"points of the front of two aims (default {_POINTS})"
    add_value(parser, "--points", "N", text, int)
    add_flag(parser, "--no-check", "leave out the global check by differential evolution")
    add_workers(parser)
    parser.add_argument(
        "--format", choices=["svg", "png"], help="of the figure of the front (default svg)"
    )
    add_json(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..outputs import check_folder, complete_folder
    from ..study.optimise import RESULTS, optimise, read_problem, write

    problem = read_problem(options.study)
    if len(problem.aims) == 1:
        refuse_beside(options, "one aim, which has no front", "--points", "--format")
    else:
        require("study", "matplotlib", what="the figure of the front")
    folder = Path(options.out or Path("out") / Path(options.study).stem)
    check_folder(folder)
    # How many parts there are shows only as they are done, so no share is told.
    with progress("parts", alike=False) as tell:
        optimum = optimise(
            problem,
            starts=options.starts,
            seed=options.seed,
            check=not options.no_check,
            points=_POINTS if options.points is None else options.points,
            workers=options.workers,
            progress=lambda done, known: tell(done, None, f"parts (at least {known:,})"),
        )
    # The figure of another front must not stand beside a new result.
    with complete_folder(folder, RESULTS) as new:
        written = list(write(optimum, new))
        if len(optimum.front) > 1:
            from ..view.figure_file import write_figure
            from ..view.studies.front_plot import front_figure

            file = new / f"front.{options.format or 'svg'}"
            written.append(write_figure(front_figure(optimum), file))
    if write_document(optimum.record, options.json):
        from ..view.console import Terminal
        from ..view.studies.optimise_report import print_optimum

        print_optimum(optimum, Terminal(), [str(folder / path.name) for path in written])
    if optimum.contradiction:
        raise SimulationError(optimum.contradiction, folder=str(folder))
