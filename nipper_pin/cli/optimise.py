"""``nipper-pin optimise``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import one_line
from ..extras import require
from .arguments import refuse_beside, write_json

_POINTS = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "study", metavar="STUDY.toml", help="what is free, what is to be small, what has to hold"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="folder of the results (default out/ and the name of the study); "
        "one that holds finished parts is completed",
    )
    parser.add_argument(
        "--seed", type=int, default=1, metavar="N", help="seed of the starts (default 1)"
    )
    parser.add_argument(
        "--starts", type=int, default=6, metavar="N", help="descents by each aim (default 6)"
    )
    parser.add_argument(
        "--points",
        type=int,
        metavar="N",
        help=f"points of the front of two aims (default {_POINTS})",
    )
    parser.add_argument(
        "--no-check",
        action="store_true",
        help="leave out the global check by differential evolution",
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes (default: one a processor)"
    )
    parser.add_argument(
        "--format", choices=["svg", "png"], help="of the figure of the front (default svg)"
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..outputs import complete_folder
    from ..study.optimise import RESULTS, optimise, read_problem, write

    problem = read_problem(options.study)
    if len(problem.aims) == 1:
        names = {"points": "--points", "format": "--format"}
        refuse_beside(options, "one aim, which has no front", names)
    else:
        require("study", "matplotlib", what="the figure of the front")
    folder = Path(options.out or Path("out") / Path(options.study).stem)
    with _progress(folder) as advance:
        optimum = optimise(
            problem,
            starts=options.starts,
            seed=options.seed,
            check=not options.no_check,
            points=_POINTS if options.points is None else options.points,
            workers=options.workers,
            folder=folder,
            progress=advance,
        )
    # The figure of another front must not stand beside a new result.
    with complete_folder(folder, RESULTS) as new:
        written = list(write(optimum, new))
        if len(optimum.front) > 1:
            from ..view.studies.front_plot import plot_front

            written.append(plot_front(optimum, new / f"front.{options.format or 'svg'}"))
    if options.json is not None:
        write_json(optimum.record(), options.json)
    if options.json != "-":
        from ..view.console import Terminal
        from ..view.studies.optimise_report import print_optimum

        sys.stdout.write("".join(f"{one_line(str(folder / path.name))}\n" for path in written))
        print_optimum(optimum, Terminal())
    if optimum.contradiction:
        from ..errors import SimulationError

        raise SimulationError(optimum.contradiction, folder=str(folder))


@contextmanager
def _progress(folder: Path) -> Iterator[Callable[[int, int], None]]:
    """Show progress on a terminal; after an interrupt report the finished parts."""
    from ..view.progress import progress

    kept = [0]
    try:
        # How many parts there are shows only as they are done: a share would go backwards.
        with progress("parts", alike=False) as tell:

            def advance(done: int, known: int) -> None:
                kept[0] = done
                tell(done, None, f"parts (at least {known:,})")

            yield advance
    except KeyboardInterrupt:
        sys.stderr.write(
            f"nipper-pin: interrupted; {kept[0]} finished parts are in {one_line(str(folder))}: "
            "run the same command again for the others\n"
        )
        raise
