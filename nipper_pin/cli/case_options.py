"""Options of a case, for all commands that simulate.

None of them has a default of argparse, so that an option that is given can be told from one that is
not: beside a saved case only those that are given change it.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from ..dynamics import DriveMode
from ..errors import InputError
from ..given import read_number
from ..hybrid import START_INDEX, Case, Window
from ..mechanism import Mechanism, changed
from .arguments import add_value, load_mechanism, overrides, speed

LIMIT = "limit"
DRIVES = [item.value for item in DriveMode]
DRIVE_HELP = "held: impacts cannot change the shafts' speed; inertial: they can"
_OF_TURNS = {"cycles": "--cycles", "start_index": "--start-index", "reuse_cycles": "--no-reuse"}


def add_window(parser: argparse.ArgumentParser, default: Window) -> None:
    """Define the arguments of all simulations."""
    windows = [item.value for item in Window]
    text = f"transition: first collision to rest; cycle: whole turns (default {default.value})"
    parser.add_argument("--window", choices=windows, default=argparse.SUPPRESS, help=text)
    add_start(parser)


def add_start(parser: argparse.ArgumentParser) -> None:
    """Define the argument for the start of whole turns."""
    text = f"index at which the turns start, in the initial phase (default {START_INDEX:g})"
    add_value(parser, "--start-index", "INDEX", text, default=argparse.SUPPRESS)


def add_cycles(parser: argparse.ArgumentParser) -> None:
    """Define the argument for the number of turns."""
    add_value(parser, "--cycles", "N", "number of turns (default 1)", int, argparse.SUPPRESS)


def add_case(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the method: window, rest, tolerance, drive."""
    add_cycles(parser)
    parser.add_argument(
        "--drive", choices=DRIVES, default=argparse.SUPPRESS, help=f"{DRIVE_HELP} (default held)"
    )
    text = (
        "end a series of bounces at this separation rate (rad/s or m/s) instead of at its limit; "
        f"{LIMIT}: at its limit (default)"
    )
    add_value(parser, "--rest-rate", "RATE", text, _rest_rate, argparse.SUPPRESS)
    text = "relative accuracy (default 1e-12)"
    add_value(parser, "--tolerance", "TOL", text, default=argparse.SUPPRESS)
    parser.add_argument(
        "--reuse",
        action=argparse.BooleanOptionalAction,
        dest="reuse_cycles",
        default=argparse.SUPPRESS,
        help="copy turns that repeat exactly (default), or compute them again",
    )


def machine_and_case(
    options: argparse.Namespace, window: Window, saved: tuple[Mechanism, Case] | None = None
) -> tuple[Mechanism, Case]:
    """Return machine and case: of the arguments, or saved ones changed by the arguments.

    Args:
        window: Window of a new case without ``--window``.
    """
    if saved is None:
        mechanism = load_mechanism(options)
        case = Case(speed_rpm=speed(options, mechanism), window=window)
    else:
        changes, (mechanism, case) = overrides(options), saved
        mechanism = changed(mechanism, changes) if changes else mechanism
    return mechanism, changed_case(case, options)


def changed_case(case: Case, options: argparse.Namespace) -> Case:
    """Return a case with the changes of the arguments.

    Raises:
        InputError: A value is out of range, or an option has nothing to change.
    """
    given = given_settings(options)
    if "tolerance" in given:
        given["resolution"] = replace(case.resolution, tolerance=given.pop("tolerance"))
    found = replace(case, **given)
    if found.window is Window.TRANSITION:
        for name, written in _OF_TURNS.items():
            if name in given:
                message = (
                    f"{written} is about whole turns, and a transition has none: add "
                    f"--window cycle, or leave {written} out"
                )
                raise InputError(message, argument=written)
    return found


def given_settings(options: argparse.Namespace) -> dict[str, Any]:
    """Fields of a case that the arguments hold, the tolerance with them."""
    names = ("window", "start_index", "cycles", "drive", "rest_rate", "tolerance", "reuse_cycles")
    given = {name: getattr(options, name) for name in names if hasattr(options, name)}
    if options.speed is not None:
        given["speed_rpm"] = options.speed
    return given


def case_words(options: argparse.Namespace) -> list[str]:
    """Arguments that say what is simulated, as another command takes them."""
    names = ("window", "start_index", "cycles", "drive")
    given = [name for name in names if hasattr(options, name)]
    return [word for name in given
            for word in (f"--{name.replace('_', '-')}", f"{getattr(options, name)}")]  # fmt: skip


def _rest_rate(text: str) -> float | None:
    """A rate, or None for the limit."""
    return None if text == LIMIT else read_number(text)
