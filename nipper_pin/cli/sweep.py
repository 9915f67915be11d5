"""``nipper-pin sweep``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .arguments import write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument("study", metavar="STUDY.toml", help="what to vary, and what to keep")
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="folder of the results (default out/ and the name of the study); "
        "one that holds a part of them is completed",
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes (default: one a processor)"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler, for example tcp://host:8786"
    )
    parser.add_argument(
        "--dry-run", action="store_true", help="check the study and say what it would compute"
    )
    parser.add_argument("--json", metavar="FILE", help="write a report as JSON; - for stdout")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..study.sweep import read_plan, run_sweep

    plan = read_plan(options.study)
    kinds = plan.mechanisms
    size = f"{plan.scenarios:,} scenarios of {kinds:,} mechanism{'s' if kinds > 1 else ''}"
    if options.dry_run:
        document: dict[str, object] = {
            "scenarios": plan.scenarios,
            "mechanisms": plan.mechanisms,
            "chunks": len(plan.chunks()),
            "hash": plan.hash,
        }
        text = f"{size} in {document['chunks']:,} chunks"
    else:
        folder = Path(options.out or Path("out") / Path(options.study).stem)
        with _progress(folder) as advance:
            report = run_sweep(
                plan,
                folder,
                workers=options.workers,
                scheduler=options.scheduler,
                progress=advance,
            )
        document = report.record()
        new = report.scenarios - report.found
        text = f"{size} in {report.folder}: {report.found:,} were there, {new:,} computed in "
        text += f"{report.wall_s:.3g} s"
    if options.json is not None:
        write_json(document, options.json)
    if options.json != "-":
        sys.stdout.write(text + "\n")


@contextmanager
def _progress(folder: Path) -> Iterator[Callable[[int, int, int], None]]:
    """A bar on a terminal; in any case a word about what is kept after an interrupt."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    stored = [0, 0]
    bar = Progress(
        TextColumn("scenarios"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        disable=not sys.stderr.isatty(),
    )
    task = bar.add_task("scenarios", total=None, rate="")

    def advance(done: int, found: int, total: int) -> None:
        stored[:] = done, total
        seconds = bar.tasks[0].elapsed or 0.0
        rate = f"{(done - found) / seconds:,.0f}/s" if done > found and seconds > 0.0 else ""
        bar.update(task, completed=done, total=total, rate=rate)

    try:
        with bar:
            yield advance
    except KeyboardInterrupt:
        sys.stderr.write(
            f"nipper-pin: interrupted; {stored[0]:,} of {stored[1]:,} scenarios are in {folder}: "
            "run the same command again for the others\n"
        )
        raise
