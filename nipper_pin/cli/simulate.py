"""``nipper-pin simulate``."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ..dynamics.system import DriveMode
from ..hybrid.case import Case, Resolution, Window
from ..hybrid.record import record
from ..hybrid.simulate import simulate
from ..hybrid.solution import Solution
from .arguments import add_model, load_mechanism, speed, write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    parser.add_argument(
        "--window",
        choices=[item.value for item in Window],
        default=Window.TRANSITION.value,
        help="transition: first collision to rest; cycle: whole turns",
    )
    parser.add_argument("--cycles", type=int, default=1, metavar="N", help="number of turns")
    parser.add_argument(
        "--start-index",
        type=float,
        default=24.0,
        metavar="INDEX",
        help="index at which the turns start (default 24, foremost)",
    )
    parser.add_argument(
        "--drive",
        choices=[item.value for item in DriveMode],
        default=DriveMode.HELD.value,
        help="held: impacts cannot change the shafts' speed; inertial: they can",
    )
    parser.add_argument(
        "--rest-rate",
        type=float,
        metavar="RATE",
        help="end a series of bounces at this separation rate (rad/s or m/s) "
        "instead of at its limit",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e-12,
        metavar="TOL",
        help="relative accuracy (default 1e-12)",
    )
    parser.add_argument(
        "--no-reuse", action="store_true", help="compute turns that repeat exactly again"
    )
    parser.add_argument(
        "--forces", action="store_true", help="add clamping and stop forces to the table"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="write CSV tables, the solution, the case and plots into a folder",
    )
    parser.add_argument(
        "--case", metavar="FILE", help="repeat the run of a case.json that --out wrote"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if options.case is not None:
        from ..hybrid.storage import load_case

        mechanism, case = load_case(options.case)
    else:
        mechanism = load_mechanism(options)
        case = Case(
            speed_rpm=speed(options, mechanism),
            window=Window(options.window),
            cycles=options.cycles,
            start_index=options.start_index,
            drive=DriveMode(options.drive),
            rest_rate=options.rest_rate,
            resolution=Resolution(tolerance=options.tolerance),
            reuse_cycles=not options.no_reuse,
        )
    with _progress(case) as advance:
        solution = simulate(mechanism, case, advance)
    if options.out is not None:
        from ..view.export import export

        export(solution, options.out)
    if options.json is not None:
        write_json(record(solution), options.json)
    if options.json != "-":
        _print(solution, forces=options.forces, turns=_whole_turns(options.words))


def _whole_turns(words: Sequence[str]) -> str:
    """The command of the user for whole turns, ready to be pasted."""
    kept = shlex.join(["nipper-pin", *words])
    for given in ("--window transition", "--window=transition"):
        kept = kept.replace(f" {given}", "")
    return f"{kept} --window cycle"


def _print(solution: Solution, *, forces: bool, turns: str) -> None:
    from rich.console import Console

    from ..view.table import print_solution

    print_solution(solution, Console(), forces=forces, turns=turns)


@contextmanager
def _progress(case: Case) -> Iterator[Any]:
    """Progress of many turns, on a terminal only."""
    if case.window is not Window.CYCLE or case.cycles < 3 or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("turns", total=case.cycles)
        yield lambda done, total: bar.update(task, completed=done, total=total)
