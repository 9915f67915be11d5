"""``nipper-pin simulate``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import nullcontext

from ..errors import InputError
from ..extras import require
from ..hybrid import Case, Window, need_sound, simulate
from ..hybrid.result.json_document import record
from ..mechanism import Mechanism
from ..view.progress import progress
from .arguments import (
    add_flag,
    add_model,
    add_value,
    command,
    machine_words,
    output_folder,
    refuse_beside,
    write_document,
)
from .case_options import add_case, add_window, machine_and_case

# Options with a value that the command of another run does not take over.
_OF_THIS_RUN = ("--window", "--out", "--json")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    add_window(parser, Window.TRANSITION)
    add_case(parser)
    add_flag(parser, "--forces", "add clamping and stop forces to the table")
    text = "write CSV tables, the solution, the case and plots into a folder"
    add_value(parser, "--out", "DIR", text, output_folder)
    parser.add_argument(
        "--units",
        choices=("SI", "mm"),
        help="units of the CSV tables of --out: SI (default), or mm and degrees",
    )
    text = (
        "repeat the run of a case.json that --out wrote, its machine included; numbers and "
        "settings beside it change that run, a MODEL beside it is refused"
    )
    add_value(parser, "--case", "FILE", text, str)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if options.json == "-":
        refuse_beside(options, "--json -, which writes no table", "--forces")
    if options.units is not None and options.out is None:
        message = "--units is that of the CSV tables that --out DIR writes; give both"
        raise InputError(message, argument="--units")
    if options.out is not None:
        require("view", "matplotlib", what="simulate --out, which draws plots,")
    mechanism, case = _asked(options)
    if options.out is not None:
        from ..view.run.export import export, need_own_folder

        need_own_folder(options.out, mechanism.name)
    many = case.window is Window.CYCLE and case.cycles > 2
    with progress("turns", case.cycles) if many else nullcontext() as tell:
        solution = simulate(mechanism, case, tell)
    need_sound(solution)
    if options.out is not None:
        export(solution, options.out, options.units or "SI")
    if write_document(lambda: record(solution), options.json):
        from ..view.console import Terminal, ending
        from ..view.run import print_solution

        console, turns = Terminal(), _whole_turns(options.words)
        print_solution(solution, console, with_forces=options.forces, turns=turns)
        following = turns if case.window is Window.TRANSITION else _view(options, mechanism)
        ending(console, following, (options.out, options.json))


def _whole_turns(words: Sequence[str]) -> str:
    """Return the command line of the same run for whole turns; it writes over no file of this."""
    kept, rest = list[str](), iter(words)
    for word in rest:
        option, equals, _ = word.partition("=")
        if option not in _OF_THIS_RUN:
            kept.append(word)
        elif not equals:
            next(rest, None)
    return command(*kept, "--window", "cycle")


def _asked(options: argparse.Namespace) -> tuple[Mechanism, Case]:
    """Return machine and case: of the arguments, or saved ones changed by the arguments."""
    if options.case is None:
        return machine_and_case(options, Window.TRANSITION)
    held = f"--case {options.case}, which holds its own machine"
    refuse_beside(options, held, f"MODEL {options.model}")
    from ..hybrid.files.npz import load_case

    return machine_and_case(options, Window.TRANSITION, load_case(options.case))


def _view(options: argparse.Namespace, mechanism: Mechanism) -> str:
    """Return the command line that shows the same machine; empty for a case of a file."""
    if options.case is not None:
        return ""
    return command("view", *machine_words(options), "--html", f"{mechanism.name}.html")
