"""``nipper-pin identify``."""

from __future__ import annotations

import argparse

from ..errors import InputError
from ..view.progress import progress
from .arguments import (
    add_json,
    add_value,
    add_workers,
    command,
    output_folder,
    refuse_beside,
    write_document,
)

_SEED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    text = "free numbers, targets and limits (default: the published ratios, model e62)"
    parser.add_argument("problem", nargs="?", metavar="PROBLEM.toml", help=text)
    add_value(parser, "--seed", "N", f"seed of the starts (default {_SEED})", int)
    add_value(parser, "--starts", "N", "number of starts (default 4)", int, 4)
    text = "profile likelihoods of the N numbers that are determined best (default 2)"
    add_value(parser, "--profiles", "N", text, int, 2)
    add_workers(parser)
    add_value(parser, "--out", "DIR", "write the identified model into a folder", output_folder)
    add_json(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..mechanism.model_files import check_new_folder
    from ..study.identify import Profile, identify, profile, read_problem, record, write_model

    if options.profiles < 0:
        message = f"--profiles {options.profiles}: at least 0"
        raise InputError(message, argument=options.profiles)
    if options.starts == 1:
        refuse_beside(options, "--starts 1, the model's own numbers", "--seed")
    problem = read_problem(options.problem)
    if options.out is not None:
        check_new_folder(options.out)
    # Some starts take ten times as long as others, so no time left is told.
    with progress("starts", alike=False) as tell:
        fit = identify(
            problem,
            starts=options.starts,
            seed=_SEED if options.seed is None else options.seed,
            workers=options.workers,
            progress=lambda done, all_, cost: tell(done, all_, f"starts (least cost {cost:.4g})"),
        )
    known, judged = fit.known, fit.goodness
    chosen = [path for path, _ in known.ranked()][: options.profiles]
    profiles = list[Profile]()
    with progress("profiles", len(chosen), alike=False) as tell:
        for path in chosen:
            profiles.append(profile(fit, path, workers=options.workers))
            tell(len(profiles), len(chosen))
    # The folder last: once it is there, the same command is refused.
    free = write_document(lambda: record(fit, judged, known, profiles), options.json)
    if options.out is not None:
        write_model(fit, judged, options.out)
    if free:
        from ..view.console import Terminal, ending
        from ..view.studies.identify_report import print_fit

        console = Terminal()
        print_fit(fit, judged, known, profiles, console)
        again = command(*options.words, "--out", "identified")
        following = again if options.out is None else command("check", options.out)
        ending(console, following, (options.out, options.json))
    # The result is written, but the fit contradicts the data.
    fit.check()
