"""``nipper-pin compare``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from ..errors import InputError
from ..extras import require
from ..given import read_number
from ..hybrid import Window
from ..study.compare import Comparison, compare
from ..view import show
from ..written_units import number_in
from .arguments import (
    MODEL,
    RESTITUTION,
    SPEED,
    STIFFNESS,
    Once,
    add_flag,
    add_json,
    add_look,
    add_value,
    command,
    machine_words,
    need_suffix,
    number_or_text,
    output_folder,
    refuse_beside,
    write_document,
)
from .case_options import DRIVE_HELP, DRIVES, add_cycles, add_window, case_words
from .compare_sides import sides, simulated

# What is proposed where nothing differs: the speed of B by that of A.
_QUICKER = 1.1


class _OneOrTwo(Once):
    """Takes one value for both, or two; words behind them are A and B again.

    Args:
        kind: Makes a value of a word; a ValueError says what may stand there.
    """

    def __init__(self, *args: Any, kind: Callable[[str], object], **how: Any) -> None:
        super().__init__(*args, **how)
        self._kind = kind

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        found: list[object] = []
        try:
            for word in values:
                found.append(self._kind(word))
        except ValueError as error:
            if not found:
                parser.error(f"argument {option_string}: {values[0]!r} cannot be used: {error}")
        if len(found) > 2:
            many = " ".join(values)
            parser.error(f"argument {option_string}: one for both or two, and these are {many}")
        super().__call__(parser, namespace, found, option_string)
        namespace.behind = [*getattr(namespace, "behind", []), *values[len(found) :]]


def _drive(word: str) -> str:
    if word not in DRIVES:
        message = f"write {' or '.join(DRIVES)}, for both or one each"
        raise ValueError(message)
    return word


def _rate(word: str) -> float | str:
    """Of a spring along a slide or on a hinge; its unit is read where its path is known."""
    number_in(word, "N m/rad" if word.endswith(("rad", "deg")) else "N/m")
    return number_or_text(word)


# Settings that take one value for both, or one for A and one for B.
_PAIRED: tuple[tuple[str, Callable[[str], object], str, str], ...] = (
    ("--speed", lambda word: number_in(word, "rpm"), "RPM", SPEED),
    ("--restitution", read_number, "E", RESTITUTION),
    ("--stiffness", _rate, "N_PER_M", STIFFNESS),
    ("--drive", _drive, "DRIVE", f"{DRIVE_HELP} (default held)"),
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.epilog = (
        "for example: compare e62 my_e62   compare e62 --speed 450 520   "
        "compare e62 --set-b preload=9.25   compare before.npz after.npz --html compare.html"
    )
    parser.add_argument(
        "a", nargs="?", metavar="A",
        help="a model (name, folder or TOML file), a saved run (solution.npz) or a folder of "
        f"simulate --out (default {MODEL})",
    )  # fmt: skip
    parser.add_argument("b", nargs="?", metavar="B", help="another one (default: the same as A)")
    for name, kind, metavar, text in _PAIRED:
        parser.add_argument(
            name, nargs="+", action=_OneOrTwo, kind=kind, metavar=metavar,
            help=f"{text}; of both, or of A and of B",
        )  # fmt: skip
    for name, whose in (("--set", "both"), ("--set-a", "A alone"), ("--set-b", "B alone")):
        parser.add_argument(
            name, action="append", default=[], metavar="PATH=VALUE",
            help=f"change a number of {whose} by its path or shortcut, or speed; may be repeated",
        )  # fmt: skip
    add_window(parser, Window.CYCLE)
    add_cycles(parser)
    add_value(parser, "--html", "FILE", "write both in one film, as one page", str)
    add_flag(parser, "--browser", "show that page in the browser, until Ctrl-C")
    add_look(parser)
    add_value(parser, "--out", "DIR", "write the table (CSV) and the curves", output_folder)
    add_json(parser, "table")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    _check(options)
    comparison = compare(*map(simulated, sides(options)))
    if options.out is not None:
        from ..view.compare.files import write_files

        write_files(comparison, options.out)
    look = {"slow": options.slow, "exaggerate": options.exaggerate}
    if options.html is not None:
        show.view(comparison, options.html, **look)
    if write_document(comparison.record, options.json):
        from ..view.compare.words import print_comparison
        from ..view.console import Terminal, ending

        console = Terminal()
        print_comparison(comparison, console)
        written = (options.out, options.html, options.json)
        ending(console, _next(options, comparison), written)
    if options.browser:
        show.view(comparison, port=0, **look)


def _check(options: argparse.Namespace) -> None:
    """Refuse what cannot be done before anything is computed."""
    if options.json == "-" and options.browser:
        message = "--json - needs stdout to itself, and so does the server of --browser"
        raise InputError(message, argument="--json -")
    if options.html is None and not options.browser:
        refuse_beside(options, "a table; add --html FILE or --browser", "--slow", "--exaggerate")
    else:
        show.need_libraries()
        from ..view.scene import Look

        Look(slow=options.slow, exaggerate=options.exaggerate)
    if options.out is not None:
        require("view", "matplotlib", what="compare --out, which draws curves,")
    need_suffix("--html", options.html, ".html")


def _next(options: argparse.Namespace, comparison: Comparison) -> str:
    """The command to run next: one with a difference, the film, or the second machine alone."""
    one, other = sides(options)
    if (one.model, vars(one)) == (other.model, vars(other)):
        rpm = comparison.b.case.speed_rpm
        one.speed = None
        speeds = ("--speed", f"{rpm:g}", f"{_QUICKER * rpm:g}")
        return command("compare", *machine_words(one), *case_words(one), *speeds)
    if options.html is None and not options.browser:
        return command(*options.words, "--html", "compare.html")
    if other.saved:
        return command("view", "--solution", other.saved)
    window = [] if hasattr(options, "window") else ["--window", Window.CYCLE.value]
    model, *changes = machine_words(other)
    return command("simulate", model, *window, *case_words(other), *changes)
