"""``nipper-pin compare``."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import Any

from ..dynamics import DriveMode
from ..errors import InputError
from ..extras import require
from ..given import read_number
from ..hybrid import Window
from ..study.compare import Comparison, compare
from ..written_units import number_in
from .arguments import (
    MODEL,
    RESTITUTION,
    check_outputs,
    need_suffix,
    refuse_again,
    refuse_beside,
    write_json,
)
from .case_options import DRIVE_HELP, DRIVES, add_cycles, add_window
from .compare_sides import simulated, sources, told_drive, told_machine, told_settings, told_window

# Settings that take one value for both, or one for A and one for B.
_PAIRED = {
    "speed": ("RPM", "cylinder speed (default: the model's rated speed)"),
    "restitution": ("E", RESTITUTION),
    "stiffness": ("N_PER_M", "spring rate; the preload length is kept"),
}
# What is proposed where nothing differs: the speed of B by that of A.
_QUICKER = 1.1


class _OneOrTwo(argparse.Action):
    """Takes one value for both, or two; words behind them are A and B again."""

    refusal = "invalid float value: {!r}"

    @staticmethod
    def value(word: str) -> Any:
        """A word as a value.

        Raises:
            ValueError: It is none.
        """
        return read_number(word)

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        refuse_again(parser, namespace, option_string)
        found: list[Any] = []
        for word in values[:2]:
            try:
                found.append(self.value(word))
            except ValueError:
                break
        if not found:
            parser.error(f"argument {option_string}: {self.refusal.format(values[0])}")
        if len(values) > len(found) == 2 and self._fits(values[2]):
            many = " ".join(values)
            parser.error(f"argument {option_string}: one for both or two, and these are {many}")
        setattr(namespace, self.dest, found)
        namespace.behind = [*getattr(namespace, "behind", []), *values[len(found) :]]

    def _fits(self, word: str) -> bool:
        try:
            self.value(word)
        except ValueError:
            return False
        return True


class _Speeds(_OneOrTwo):
    """The same of speeds, which may have a unit."""

    @staticmethod
    def value(word: str) -> float:
        """A word as a speed in r/min.

        Raises:
            ValueError: It is none.
        """
        return number_in(word, "rpm")


class _Drives(_OneOrTwo):
    """The same of drives."""

    refusal = f"invalid drive: {{!r}} (write {' or '.join(DRIVES)}, for both or one each)"

    @staticmethod
    def value(word: str) -> str:
        """A word as a drive.

        Raises:
            ValueError: It is none.
        """
        return DriveMode(word).value


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
    for name, (metavar, text) in _PAIRED.items():
        parser.add_argument(
            f"--{name}", nargs="+", action=_Speeds if name == "speed" else _OneOrTwo,
            metavar=metavar,
            help=f"{text}: of both, or of A and of B",
        )  # fmt: skip
    for name, whose in (("--set", "both"), ("--set-a", "A alone"), ("--set-b", "B alone")):
        parser.add_argument(
            name, action="append", default=[], metavar="PATH=VALUE",
            help=f"change a number of {whose} by its path or shortcut, or speed; may be repeated",
        )  # fmt: skip
    add_window(parser, Window.CYCLE)
    add_cycles(parser)
    parser.add_argument(
        "--drive", nargs="+", action=_Drives, metavar="DRIVE",
        help=f"{DRIVE_HELP}; of both (default held), or of A and of B",
    )  # fmt: skip
    parser.add_argument("--html", metavar="FILE", help="write both in one film, as one page")
    parser.add_argument(
        "--browser", action="store_true", help="show that page in the browser, until Ctrl-C"
    )
    parser.add_argument(
        "--slow", type=float, metavar="N",
        help="stretch time of the film 1:N around events (default 1000, less for films above two "
        "minutes)",
    )  # fmt: skip
    parser.add_argument(
        "--exaggerate", type=float, metavar="N",
        help="draw rebounds of the film N times as large, 1 to 1000 (default: so that they are "
        "seen)",
    )  # fmt: skip
    parser.add_argument("--out", metavar="DIR", help="write the table (CSV) and the curves")
    parser.add_argument("--json", metavar="FILE", help="write the table as JSON; - for stdout")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    pictured = options.html is not None or options.browser
    _check(options, pictured=pictured)
    one, other = sources(options)
    comparison = compare(simulated(one, options), simulated(other, options))
    if options.html is not None or options.browser:
        from ..view.scene import Look
        from ..view.show import shown_page, write_page

        look = Look(slow=options.slow, exaggerate=options.exaggerate)
    if options.out is not None:
        from ..view.compare.files import write_files

        write_files(comparison, options.out)
    if options.json is not None:
        write_json(comparison.record(), options.json)
    if options.html is not None:
        write_page(comparison, Path(options.html), look)
    if options.json != "-":
        _print(comparison, options)
    if options.browser:
        from ..view.scene.server import serve

        serve(shown_page(comparison, look), 0, browser=True)


def _check(options: argparse.Namespace, *, pictured: bool) -> None:
    """Refuse what cannot be done before anything is computed."""
    if options.json == "-" and options.browser:
        message = "--json - needs stdout to itself, and so does the server of --browser"
        raise InputError(message, argument="--json -")
    if pictured:
        require("view", "meshcat", "umsgpack", what="a page of the viewer")
    else:
        look = {"slow": options.slow is not None, "exaggerate": options.exaggerate is not None}
        refuse_beside(
            argparse.Namespace(**look),
            "a table; add --html FILE or --browser",
            {"slow": "--slow", "exaggerate": "--exaggerate"},
        )
    if options.out is not None:
        require("view", "matplotlib", what="compare --out, which draws curves,")
    check_outputs(options.out, options.json)
    need_suffix("--html", options.html, ".html")
    check_outputs(None, options.html)


def _print(comparison: Comparison, options: argparse.Namespace) -> None:
    from ..view.compare.table import print_comparison
    from ..view.console import Terminal

    written = {"table and curves": options.out, "film": options.html, "document": options.json}
    print_comparison(
        comparison,
        Terminal(),
        written=[f"{what}: {place}" for what, place in written.items() if place is not None],
        following=_next(options, comparison),
    )


def _next(options: argparse.Namespace, comparison: Comparison) -> str:
    """The command to run next: one with a difference, the film, or the second machine alone."""
    one, other = sources(options)
    if one == other:
        rpm = comparison.b.case.speed_rpm
        return shlex.join([
            "nipper-pin", "compare", *told_machine(one), *told_window(options), *told_drive(one),
            "--speed", f"{rpm:g}", f"{_QUICKER * rpm:g}",
        ])  # fmt: skip
    if options.html is None and not options.browser:
        return shlex.join(["nipper-pin", *options.words, "--html", "compare.html"])
    window = [] if hasattr(options, "window") else ["--window", Window.CYCLE.value]
    return shlex.join(["nipper-pin", *told_settings(other, [*window, *told_window(options)])])
