"""``python -m benchmarks stress``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from nipper_pin.cli.arguments import check_outputs, refuse_beside, write_json
from nipper_pin.errors import InputError, SimulationError, one_line
from nipper_pin.extras import require

if TYPE_CHECKING:
    from ..stress import Campaign, Verdict

_CASES = 1000
_SEED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "--cases", type=int, metavar="N", help=f"number of cases (default {_CASES})"
    )
    parser.add_argument(
        "--seed", type=int, metavar="S", help=f"seed of the random cases (default {_SEED})"
    )
    parser.add_argument(
        "--family",
        action="append",
        metavar="NAME",
        help="cases of this family alone, for example linkage; may be repeated",
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes (default: one a processor)"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="keep each verdict, a case file of each failure, and the report; what is there "
        "already is not judged again",
    )
    parser.add_argument(
        "--rerun", metavar="FILE", help="judge the one case of such a file again, and nothing else"
    )
    parser.add_argument(
        "--time-limit",
        type=float,
        default=600.0,
        metavar="S",
        help="seconds of the processor after which a case is a hang (default 600)",
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from nipper_pin.view.console import Terminal

    from ..views.stress_report import print_campaign, print_verdict

    _check(options)
    require("study", "numba", what="the stress campaign, which compares both engines,")
    result = _campaign(options) if options.rerun is None else _again(options)
    if options.json is not None:
        write_json(result.record(), options.json)
    if options.json != "-":
        if options.rerun is not None:
            print_verdict(result.verdicts[0], Terminal())
        else:
            print_campaign(result, Terminal())
    _refuse_failures(result, one=options.rerun is not None)


def _check(options: argparse.Namespace) -> None:
    for name in ("cases", "workers", "time_limit"):
        value = getattr(options, name)
        if value is not None and value <= 0:
            message = f"--{name.replace('_', '-')} {value}: above 0"
            raise InputError(message, argument=value)
    if options.seed is not None and options.seed < 0:
        message = f"--seed {options.seed}: at least 0"
        raise InputError(message, argument=options.seed)
    check_outputs(options.out, options.json)


def _again(options: argparse.Namespace) -> Campaign:
    """The one case of a file, judged again."""
    from ..stress import Campaign, judge, load_trial

    names = {name: f"--{name}" for name in ("cases", "seed", "family", "workers", "out")}
    refuse_beside(options, "--rerun, which judges one case here", names)
    trial = load_trial(options.rerun)
    verdict = judge(trial, options.time_limit)
    return Campaign(trial.seed, (verdict,), verdict.wall_s)


def _campaign(options: argparse.Namespace) -> Campaign:
    from ..stress import run_campaign

    cases = _CASES if options.cases is None else options.cases
    seed = _SEED if options.seed is None else options.seed
    with _progress(cases, options.out) as advance:
        result = run_campaign(
            cases,
            seed,
            options.workers,
            advance,
            options.time_limit,
            options.out,
            families=tuple(options.family or ()),
        )
    if options.out is not None:
        write_json(result.record(), str(Path(options.out) / "stress.json"))
    return result


def _refuse_failures(result: Campaign, *, one: bool) -> None:
    """Raise if a case is wrong or, of a campaign, a family is refused too often."""
    from ..stress import WRONG, excesses

    wrong = [item for item in result.verdicts if item.word == WRONG]
    if wrong:
        count = f"{len(wrong)} of {len(result.verdicts)} cases are wrong"
        message = f"{count}, the first one number {wrong[0].number}: {wrong[0].detail[:300]}"
        raise SimulationError(message, numbers=[item.number for item in wrong])
    # A single case repeated gives no share of refusals.
    if not one and (found := excesses(result.verdicts)):
        worst = found[0]
        message = (
            f"{worst.refused} of {worst.cases} cases of the family {worst.family!r} are refused, "
            f"where {worst.share:.0%} may be: an engine that refuses what it should solve; "
            f"see 'errors' in the report for the reasons"
        )
        raise SimulationError(message, families=[item.family for item in found])


@contextmanager
def _progress(cases: int, folder: str | None) -> Iterator[Callable[[Verdict], None]]:
    """Show progress on a terminal; after an interrupt report the finished trials."""
    from nipper_pin.view.progress import progress

    words: dict[int, str] = {}
    try:
        with progress("cases", cases) as tell:

            def advance(verdict: Verdict) -> None:
                words[verdict.number] = verdict.word
                wrong = list(words.values()).count("wrong")
                tell(len(words), cases, f"cases, {wrong} wrong")

            yield advance
    except KeyboardInterrupt:
        where = f"are in {one_line(str(folder))}: run the same command again for the others"
        sys.stderr.write(
            f"nipper-pin: interrupted; {len(words):,} of {cases:,} verdicts "
            f"{where if folder is not None else 'are lost: --out keeps them'}\n"
        )
        raise
