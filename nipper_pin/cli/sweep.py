"""``nipper-pin sweep``."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import InputError, one_line
from ..view.progress import progress
from .arguments import (
    add_flag,
    add_json,
    add_value,
    add_workers,
    command,
    output_file,
    refuse_beside,
    write_document,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument("study", metavar="STUDY.toml", help="what to vary, and what to keep")
    text = (
        "folder of the results (default out/ and the name of the study); "
        "one that holds a part of them is completed"
    )
    add_value(parser, "--out", "DIR", text, str)
    add_workers(parser)
    text = "a Dask scheduler, for example tcp://host:8786"
    add_value(parser, "--scheduler", "ADDRESS", text, str)
    text = "only chunks A to B, counted from 0: a part of a sweep for each job of an array"
    add_value(parser, "--chunks", "A-B", text, str)
    text = (
        "check the study, and say what it, or --chunks of it, would compute and how long that "
        "takes here"
    )
    add_flag(parser, "--dry-run", text)
    add_value(parser, "--csv", "FILE", "write all rows that are stored as CSV", output_file)
    parser.add_argument(
        "--units", choices=("SI", "mm"), help="of --csv: SI (default), or mm and degrees"
    )
    add_json(parser, "report")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..study.sweep import estimate, read_plan, read_sweep, sweep
    from ..study.sweep.plan import chosen
    from ..terms import counted

    if options.dry_run:
        what = "--dry-run, which writes nothing and times scenarios here"
        refuse_beside(options, what, "--out", "--scheduler", "--csv")
    if options.units is not None and options.csv is None:
        message = "--units is that of the table that --csv FILE writes; give both"
        raise InputError(message, argument="--units")
    plan, bounds = read_plan(options.study), _bounds(options.chunks)
    size = f"{counted(plan.scenarios, 'scenario')} of {counted(plan.mechanisms, 'mechanism')}"
    if options.dry_run:
        whole = plan.chunks()
        asked = chosen(whole, bounds)
        scenarios = asked[-1].stop - asked[0].start
        expected = estimate.estimate(plan, options.workers, bounds)
        document = {
            "scenarios": scenarios,
            "mechanisms": plan.mechanisms,
            "chunks": len(asked),
            "hash": plan.hash,
            "estimate": expected.record(),
        }
        part = f"{size} in {counted(len(asked), 'chunk')}"
        if bounds is not None:
            part = f"{scenarios:,} of {size} in {len(asked):,} of {len(whole):,} chunks"
        said = [part, expected.sentence()]
        following = ["sweep", options.study]
    else:
        folder = Path(options.out or Path("out") / Path(options.study).stem)
        with _progress(folder) as tell:
            report = sweep(
                plan,
                folder,
                workers=options.workers,
                scheduler=options.scheduler,
                chunks=bounds,
                progress=tell,
            )
        document = report.record()
        if report.scenarios < plan.scenarios:
            size = f"{report.scenarios:,} of {size}"
        said = [
            f"{size} in {report.folder}: {report.found:,} were there, {report.computed:,} "
            f"computed in {report.wall_s:.3g} s",
            *report.sentences(),
            *report.extremes.sentences(),
        ]
        if options.csv is not None:
            read_sweep(folder).write_csv(options.csv, options.units or "SI")
        following = ["plot", str(folder)]
    if write_document(lambda: document, options.json):
        from ..view.console import ending, say, unbroken_console

        console = unbroken_console()
        for sentence in said:
            say(console, sentence)
        ending(console, command(*following), (options.csv, options.json))


def _bounds(text: str | None) -> tuple[int, int] | None:
    """First and last chunk of ``--chunks``; one number is one chunk."""
    if text is None:
        return None
    first, _, last = text.partition("-")
    try:
        return int(first), int(last or first)
    except ValueError as error:
        message = f"--chunks {text}: write A-B, such as 0-9, or the number of one chunk"
        raise InputError(message, argument=text) from error


@contextmanager
def _progress(folder: Path) -> Iterator[Callable[[int, int, int], None]]:
    """Progress, with the rate of new scenarios; an interrupt reports those that are stored."""
    began, stored = time.monotonic(), [0, 0]
    with progress("scenarios") as tell:

        def show(done: int, found: int, total: int) -> None:
            stored[:] = done, total
            seconds = time.monotonic() - began
            rate = f", {(done - found) / seconds:,.0f}/s" if done > found and seconds > 0.0 else ""
            tell(done, total, f"scenarios{rate}")

        try:
            yield show
        except KeyboardInterrupt:
            sys.stderr.write(
                f"nipper-pin: interrupted; {stored[0]:,} of {stored[1]:,} scenarios are in "
                f"{one_line(str(folder))}: run the same command again for the others\n"
            )
            raise
