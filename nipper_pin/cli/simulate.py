"""``nipper-pin simulate``."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ..errors import InputError
from ..extras import require
from ..hybrid import Case, Solution, Window, need_sound, simulate
from ..hybrid.result.json_document import record
from ..mechanism import Mechanism
from .arguments import (
    MODEL,
    add_model,
    check_outputs,
    load_mechanism,
    machine_words,
    need_own_folder,
    overrides,
    refuse_beside,
    write_json,
)
from .case_options import add_case, add_window, changed_case, new_case

# Options with a value that the command of another run does not take over.
_OF_THIS_RUN = ("--window", "--out", "--json")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    add_window(parser, Window.TRANSITION)
    add_case(parser)
    parser.add_argument(
        "--forces", action="store_true", help="add clamping and stop forces to the table"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="write CSV tables, the solution, the case and plots into a folder",
    )
    parser.add_argument(
        "--units",
        choices=("SI", "mm"),
        help="units of the CSV tables of --out: SI (default), or mm and degrees",
    )
    parser.add_argument(
        "--case",
        metavar="FILE",
        help="repeat the run of a case.json that --out wrote, its machine included; numbers and "
        "settings beside it change that run, a MODEL beside it is refused",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if options.json == "-":
        refuse_beside(options, "--json -, which writes no table", {"forces": "--forces"})
    if options.units is not None and options.out is None:
        message = "--units is that of the CSV tables that --out DIR writes; give both"
        raise InputError(message, argument="--units")
    if options.out is not None:
        require("view", "matplotlib", what="simulate --out, which draws plots,")
    mechanism, case = _asked(options)
    check_outputs(options.out, options.json)
    need_own_folder(options.out, mechanism.name)
    with _progress(case) as advance:
        solution = simulate(mechanism, case, advance)
    need_sound(solution)
    if options.out is not None:
        from ..view.run.export import export

        export(solution, options.out, options.units or "SI")
    if options.json is not None:
        write_json(record(solution), options.json)
    if options.json != "-":
        _print(solution, options)


def _whole_turns(words: Sequence[str]) -> str:
    """Return the command line of the same run for whole turns; it writes over no file of this."""
    kept, rest = ["nipper-pin"], iter(words)
    for word in rest:
        option, equals, _ = word.partition("=")
        if option not in _OF_THIS_RUN:
            kept.append(word)
        elif not equals:
            next(rest, None)
    return shlex.join([*kept, "--window", "cycle"])


def _asked(options: argparse.Namespace) -> tuple[Mechanism, Case]:
    """Return machine and case: of the arguments, or saved ones changed by the arguments.

    Raises:
        InputError: Arguments contradict one another, or a file or value cannot be used.
    """
    if options.case is None:
        mechanism = load_mechanism(options)
        return mechanism, new_case(options, mechanism, Window.TRANSITION)
    if options.model is not None:
        message = (
            f"{options.model} names a model, and --case {options.case} holds its own; leave one "
            "of them out"
        )
        raise InputError(message, argument=options.model)
    from ..hybrid.files.npz import load_case
    from ..mechanism import changed

    mechanism, case = load_case(options.case)
    changes = overrides(options)
    return (changed(mechanism, changes) if changes else mechanism), changed_case(case, options)


def _print(solution: Solution, options: argparse.Namespace) -> None:
    from ..view.console import Terminal
    from ..view.run import print_solution

    turns = _whole_turns(options.words)
    print_solution(
        solution,
        Terminal(),
        with_forces=options.forces,
        turns=turns,
        written=(options.out, options.json),
        following=turns if solution.case.window is Window.TRANSITION else _view(options, solution),
    )


def _view(options: argparse.Namespace, solution: Solution) -> str:
    """Return the command line that shows the same machine; empty for a case of a file."""
    if options.case is not None:
        return ""
    words = ["view", options.model or MODEL, *machine_words(options)]
    return shlex.join(["nipper-pin", *words, "--html", f"{solution.mechanism.name}.html"])


@contextmanager
def _progress(case: Case) -> Iterator[Any]:
    """Progress of many turns."""
    if case.window is not Window.CYCLE or case.cycles < 3:
        yield None
        return
    from ..view.progress import progress

    with progress("turns", case.cycles) as tell:
        yield tell
