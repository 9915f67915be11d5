"""``nipper-pin study``."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..extras import require
from .arguments import check_outputs, load_mechanism, write_json

if TYPE_CHECKING:
    from ..mechanism import Mechanism
    from ..study.paper import PaperStudy
    from ..study.paper.designer import Designer
    from .study_progress import Work

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
        help="the E62, another set of numbers for it, or another comber, on which the same is "
        "done without a comparison: a model's name, or a folder (default e62)",
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
    folder = options.out
    if folder is None and options.json is None:
        folder = _FOLDER
    check_outputs(folder, options.json)
    require("study", "numba", what="the published study")
    if folder is not None:
        require("study", "matplotlib", "jinja2", what="the report of the published study")
    document = None
    if options.identification is not None:
        if folder is None:
            message = "--identification goes into the report; give --out DIR as well"
            raise InputError(message, argument="--identification")
        from ..study.identify.record import read_identification

        document = read_identification(options.identification)
    mechanism = load_mechanism(options)

    if folder is None:
        result, found, report = _study(mechanism), None, None
    else:
        result, found, report = _with_report(mechanism, folder, document)
    if options.json is not None:
        write_json(result.record(), options.json)
    if options.json == "-":
        return
    from ..view.console import Terminal, paste
    from ..view.paper.summary import print_paper

    console = Terminal()
    print_paper(result, console, found)
    if report is not None:
        paste(console, f"report: {report}")


def _study(mechanism: Mechanism) -> PaperStudy:
    """Do the study alone."""
    from ..study.paper import paper_study
    from .study_progress import STAGES, Work, shown

    work = Work(STAGES, beside=False)
    with shown(work) as show:
        return paper_study(mechanism, _teller(work, show))


def _teller(work: Work, show: Callable[[], None]) -> Callable[[str], None]:
    def tell(stage: str) -> None:
        work.begin(stage)
        show()

    return tell


def _counter(work: Work, show: Callable[[], None], name: str) -> Callable[[int, int], None]:
    def count(done: int, total: int) -> None:
        work.part(name, done, total)
        show()

    return count


def _with_report(
    mechanism: Mechanism, folder: str, identification: Mapping[str, Any] | None
) -> tuple[PaperStudy, Designer | None, Path]:
    """Do the study, and write the report with sensitivities and any identification."""
    from ..study.paper import paper_study
    from ..study.paper.designer import designer, how_fast
    from ..study.paper.published import conditions
    from ..study.sensitivity import sensitivities
    from .study_progress import REPORT, SENSITIVITIES, STAGES, Work, shown

    work, first = Work({**STAGES, **REPORT}, beside=True), []
    # Sensitivities are half of the work and independent of the rest.
    with shown(work) as show, ThreadPoolExecutor(1) as beside:
        tell = _teller(work, show)
        found = beside.submit(
            sensitivities,
            mechanism,
            conditions(mechanism).common_speed_rpm,
            progress=_counter(work, show, SENSITIVITIES),
            workers=os.cpu_count() or 1,
        )
        result = paper_study(mechanism, tell)
        tell("turns at many speeds")
        fast = how_fast(mechanism)
        from ..view.paper.files import write_paper
        from ..view.paper.supplements import Supplements

        def added() -> Supplements:
            changes = found.result()
            tell("report")
            first.append(designer(mechanism, changes, fast))
            return Supplements(changes, identification, first[0])

        tell("groups of figures")
        files = write_paper(result, folder, added, _counter(work, show, "groups of figures"))
    return result, first[0] if first else None, files[0]
