"""Arguments of several commands: the model and changes of it, and JSON output."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, NipperError
from ..extras import require
from ..given import read_number
from ..mechanism import Mechanism, load, number_of
from ..written_units import number_in

MODEL = "e62"
"""Default model."""
SPEED = "cylinder speed (default: the model's rated speed)"
RESTITUTION = "restitution of the stop that the model's shortcut names"
STIFFNESS = "spring rate, or with a unit as 9N/mm; the preload length is kept"

_SHORT = ("restitution", "stiffness")
_PER_M = "_N_per_m"
# A softer spring than this part of the model's, without a unit, is more likely one in N/mm.
_TOO_SOFT = 100.0


class Once(argparse.Action):
    """Takes one value, and refuses another one behind it instead of forgetting the first."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Store the value."""
        before = getattr(namespace, "options", ())
        if option_string is not None and option_string in before:
            parser.error(f"argument {option_string}: given twice; leave one out")
        namespace.options = (*before, option_string)
        setattr(namespace, self.dest, values)


def add_model(parser: argparse.ArgumentParser, *, json_output: bool = True) -> None:
    """Define the arguments for a machine, its speed and the file of JSON output."""
    add_machine(parser)
    add_value(parser, "--speed", "RPM", SPEED, rpm)
    if json_output:
        add_json(parser)


def add_machine(parser: argparse.ArgumentParser) -> None:
    """Define the arguments for a model and changes of its numbers."""
    text = f"name of a model that comes with the package, or a folder (default {MODEL})"
    parser.add_argument("model", nargs="?", metavar="MODEL", help=text)
    add_set(parser)
    add_value(parser, "--restitution", "E", RESTITUTION)
    add_value(parser, "--stiffness", "N_PER_M", STIFFNESS, number_or_text)


def add_set(parser: argparse.ArgumentParser) -> None:
    """Define the argument that changes numbers of a model."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        help="change a number of the model by its path or shortcut, for example "
        "stops.steeve.restitution=0.1 or preload=9.25; may be repeated",
    )


def add_json(parser: argparse.ArgumentParser, what: str = "result") -> None:
    """Define the argument for the file of JSON output."""
    add_value(parser, "--json", "FILE", f"write the {what} as JSON; - for stdout", output_file)


def add_value(
    parser: argparse.ArgumentParser,
    option: str,
    letter: str,
    text: str,
    kind: Callable[[str], object] = float,
    default: object = None,
) -> None:
    """Define an option that takes a value, which help calls by a letter or a word."""
    parser.add_argument(option, type=kind, metavar=letter, help=text, default=default)


def add_flag(parser: argparse.ArgumentParser, option: str, text: str) -> None:
    """Define an option without a value."""
    parser.add_argument(option, action="store_true", help=text)


def output_folder(text: str) -> str:
    """A folder, refused before all work where it can neither be made nor written into."""
    from ..outputs import check_folder

    check_folder(text)
    return text


def output_file(text: str) -> str:
    """A file (- is stdout), refused before all work where it cannot be written."""
    from ..outputs import check_file

    if text != "-":
        check_file(text)
    return text


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Define the argument for the number of processes."""
    add_value(parser, "--workers", "N", "processes (default: one a processor)", int)


def add_look(parser: argparse.ArgumentParser) -> None:
    """Define the arguments for how a film is drawn."""
    text = "stretch time 1:N around events (default 1000, less for films above two minutes)"
    add_value(parser, "--slow", "N", text)
    text = "draw rebounds N times as large, 1 to 1000 (default: so that they are seen)"
    add_value(parser, "--exaggerate", "N", text)


def add_server(parser: argparse.ArgumentParser, port: int) -> None:
    """Define the arguments for where a page is served."""
    add_value(parser, "--port", "N", f"port to serve at (default {port})", int)
    add_flag(parser, "--no-browser", "serve without opening a browser")


def rpm(text: str) -> float:
    """A speed in r/min, which may be written with a unit."""
    try:
        return number_in(text, "rpm")
    except ValueError as error:
        message = f"{text!r} cannot be used: {error}"
        raise argparse.ArgumentTypeError(message) from None


def number_or_text(text: str) -> float | str:
    """A number; a text, that may have a unit, is read where its path is known."""
    try:
        return read_number(text)
    except ValueError:
        return text


def load_mechanism(options: argparse.Namespace) -> Mechanism:
    """Load the mechanism of the arguments."""
    given, model = overrides(options), options.model or MODEL
    mechanism = load(model, given)
    _ask_back(mechanism, model, given)
    return mechanism


def _ask_back(mechanism: Mechanism, model: str, given: Mapping[str, object]) -> None:
    """Refuse a stiffness that reads like N/mm: a bare number far below that of the model."""
    for name, value in given.items():
        path, number = mechanism.shortcuts.get(name, name), number_or_text(str(value))
        if not path.endswith(_PER_M) or isinstance(number, str):
            continue
        try:
            before = number_of(load(model), path)
        except NipperError:
            # Only the new values make it a machine, so that there is no number to compare with.
            return
        if 0.0 < number <= before / _TOO_SOFT:
            message = (
                f"{name} = {number:g} without a unit is {number:g} N/m, and the model has "
                f"{before:g} N/m: write {number:g}N/mm, or {number:g}N/m if that is meant"
            )
            raise InputError(message, argument=name)


def overrides(options: argparse.Namespace) -> dict[str, object]:
    """Numbers of the model that the arguments change, by path or shortcut.

    Raises:
        InputError: A ``--set`` is not PATH=VALUE, or a number is given twice.
    """
    short = {name: getattr(options, name, None) for name in _SHORT}
    given = [f"{name}={value}" for name, value in short.items() if value is not None]
    found: dict[str, object] = {}
    for item in (*options.set, *given):
        path, equals, value = (part.strip() for part in item.partition("="))
        if not equals:
            message = f"--set {item}: write PATH=VALUE, for example stops.jaw.restitution=0.1"
            raise InputError(message, argument=item)
        if path in found:
            message = f"{path} is given twice, {found[path]} and {value}; leave one out"
            raise InputError(message, argument=item)
        found[path] = value
    return found


def machine_words(options: argparse.Namespace) -> list[str]:
    """The model, and what changes it and its speed, as another command takes them."""
    words = [options.model or MODEL, *(word for item in options.set for word in ("--set", item))]
    for name in (*_SHORT, "speed"):
        value = getattr(options, name, None)
        if value is not None:
            words += [f"--{name}", value if isinstance(value, str) else f"{value!r}"]
    return words


def command(*words: str) -> str:
    """A command line of this program, ready to be pasted into a shell."""
    return shlex.join(["nipper-pin", *words])


def speed(options: argparse.Namespace, mechanism: Mechanism) -> float:
    """Cylinder speed of the arguments, or the model's rated speed [r/min]."""
    if options.speed is not None:
        return float(options.speed)
    return mechanism.cylinder.rated_speed_rpm


def refuse_beside(options: argparse.Namespace, what: str, *names: str) -> None:
    """Refuse options that have no effect beside another one.

    Args:
        options: The arguments; one that was not given is None, False or not there.
        what: The other option and why there is nothing for them to change, for the message.
        names: How they are written on the command line; of an argument its name, and what it is.
    """
    for written in names:
        value = getattr(options, written.lstrip("-").replace("-", "_").split()[0].lower(), None)
        if value is not None and value is not False and value != []:
            message = f"{written} changes nothing beside {what}; leave one of them out"
            raise InputError(message, argument=written)


def need_suffix(option: str, file: str | None, suffix: str) -> None:
    """Refuse a file whose name says that it is of another kind, or that cannot be written."""
    if file is None:
        return
    if Path(file).suffix.lower() != suffix:
        message = f"{option} {file}: such a file is called NAME{suffix}"
        raise InputError(message, argument=option)
    output_file(file)


def check_figure(file: str | None, extra: str, what: str) -> None:
    """Refuse a figure that cannot be drawn, or a file of none, before anything is computed."""
    if file is not None:
        require(extra, "matplotlib", what=what)
        from ..view.figure_file import figure_format

        figure_format(file)


def write_document(document: Callable[[], dict[str, Any]], target: str | None) -> bool:
    """Write a document that is asked for; return whether stdout is left for people."""
    if target is not None:
        write_json(document(), target)
    return target != "-"


def write_json(document: dict[str, Any], target: str) -> None:
    """Write a document to a file, which appears only when it is complete, or to stdout."""
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    if target == "-":
        sys.stdout.write(text)
        return
    from ..outputs import complete_file

    with complete_file(Path(target)) as partial:
        partial.write_text(text, encoding="utf-8")
