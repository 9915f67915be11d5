"""``python -m benchmarks stress``."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from nipper_pin.cli.arguments import add_json, add_value, add_workers, output_folder, write_json
from nipper_pin.errors import InputError, SimulationError, one_line
from nipper_pin.extras import require

from . import hand_over, need_least

if TYPE_CHECKING:
    from ..stress import Campaign, Verdict

_CASES = 1000
_SEED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_value(parser, "--cases", "N", f"number of cases (default {_CASES})", int, _CASES)
    add_value(parser, "--seed", "S", f"seed of the random cases (default {_SEED})", int, _SEED)
    text = "number of the first case (default 0): one alone again, or those after an interrupt"
    add_value(parser, "--first", "N", text, int, 0)
    parser.add_argument(
        "--family",
        action="append",
        metavar="NAME",
        help="cases of this family alone, for example linkage; may be repeated",
    )
    add_workers(parser)
    text = "keep each verdict as it comes, a case file of each failure, and the report"
    add_value(parser, "--out", "DIR", text, output_folder)
    text = "seconds of the processor after which a case is a hang (default 600)"
    add_value(parser, "--time-limit", "S", text, default=600.0)
    add_json(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..stress import begin
    from ..views.stress_report import print_campaign

    _check(options)
    require("study", "numba", what="the stress campaign, which compares both engines,")
    if options.out is not None:
        begin(options.out)
    result = _campaign(options)
    hand_over(result, options, _write, print_campaign)
    _refuse_failures(result)


def _write(result: Campaign, folder: str) -> None:
    write_json(result.record(), str(Path(folder) / "stress.json"))


def _check(options: argparse.Namespace) -> None:
    need_least(options, cases=1, workers=1, seed=0, first=0)
    if options.time_limit <= 0.0:
        message = f"--time-limit {options.time_limit}: above 0"
        raise InputError(message, argument=options.time_limit)


def _campaign(options: argparse.Namespace) -> Campaign:
    """Run it; on a terminal show progress, after an interrupt say where the verdicts are."""
    from nipper_pin.view.progress import progress

    from ..stress import keep, run_campaign, trial

    cases, seed, families = options.cases, options.seed, tuple(options.family or ())
    words: Counter[str] = Counter()
    try:
        with progress("cases", cases) as tell:

            def advance(verdict: Verdict) -> None:
                if options.out is not None:
                    keep(trial(seed, verdict.number, families), verdict, options.out)
                words[verdict.word] += 1
                tell(words.total(), cases, f"cases, {words['wrong']} wrong")

            return run_campaign(
                cases, seed, options.workers, advance, options.time_limit, families, options.first
            )
    except KeyboardInterrupt:
        where = "lost: --out keeps them" if options.out is None else f"in {one_line(options.out)}"
        sys.stderr.write(
            f"nipper-pin: interrupted; {words.total():,} of {cases:,} verdicts are {where}\n"
        )
        raise


def _refuse_failures(result: Campaign) -> None:
    """Raise if a case is wrong, or a family is refused too often."""
    from ..stress import WRONG, excesses

    wrong = [item for item in result.verdicts if item.word == WRONG]
    if wrong:
        count = f"{len(wrong)} of {len(result.verdicts)} cases are wrong"
        message = f"{count}, the first one number {wrong[0].number}: {wrong[0].detail[:300]}"
        raise SimulationError(message, numbers=[item.number for item in wrong])
    if found := excesses(result.verdicts):
        worst = found[0]
        message = (
            f"{worst.refused} of {worst.cases} cases of the family {worst.family!r} are refused, "
            f"where {worst.share:.0%} may be: an engine that refuses what it should solve; "
            f"see 'errors' in the report for the reasons"
        )
        raise SimulationError(message, families=[item.family for item in found])
