"""The command ``nipper-pin``: one file a subcommand."""

from __future__ import annotations

import argparse
import contextlib
import errno
import os
import select
import shutil
import sys
import textwrap
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple

# In several threads BLAS adds up in another order, so the last bits of a result would depend on the
# environment. BLAS reads this once, when numpy is imported.
if "numpy" not in sys.modules:
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
# Figures are files: no window is needed, nor a name of one that this matplotlib knows.
os.environ["MPLBACKEND"] = "agg"

from .. import __version__
from ..errors import InputError, NipperError, meant, one_line
from ..extras import require
from ..given import read_number, read_whole
from .arguments import Once
from .surroundings import interrupts, open_streams

_RIGHT = 0
_NOT_SIMULATED = 1
_UNUSABLE = 2
_INTERRUPTED = 130
_SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
_FILES = {"FILE", "MODEL", "A", "B", "NAME"}
_FOLDERS = {"DIR", "FOLDER"}


class Commands(NamedTuple):
    """The commands of a program.

    Attributes:
        program: What is written before a command.
        description: What it does.
        places: Module and short help of each command; modules by name, as one alone is imported.
    """

    program: str
    description: str
    places: Mapping[str, tuple[str, str]]


_PLACES = {
    "simulate": (".simulate", "simulate a transition or whole cycles"),
    "view": (".view", "show a run in the browser, or write it as one page"),
    "compare": (".compare", "two machines, settings or saved runs side by side"),
    "live": (".live", "a page with sliders whose numbers and picture follow them"),
    "new": (".new", "write a machine to start from: a drawing in mm, or of an exported URDF"),
    "export": (".export", "write a model, or a drawing, as a folder of URDF and TOML"),
    "check": (".check", "report what a model is, and what is wrong with it"),
    "levers": (".levers", "what bounces, and which changes calm it most"),
    "speed-limit": (".speed_limit", "how fast a machine can run: where it settles, turns repeat"),
    "identify": (".identify", "find numbers of a model from published ratios or measured rebounds"),
    "optimise": (".optimise", "find the least rebound or transition time inside limits"),
    "sweep": (".sweep", "compute many scenarios, on all processors or on a cluster"),
    "plot": (".plot", "draw the results of a sweep"),
}
NIPPER_PIN = Commands(
    "nipper-pin",
    "Simulate mechanisms whose stops are struck, and how they bounce to rest.",
    _PLACES,
)
"""The commands of the package."""


def main(arguments: Sequence[str] | None = None, commands: Commands = NIPPER_PIN) -> int:
    """Run the command.

    Args:
        arguments: Command-line arguments; those of the process by default.
        commands: The commands that there are.

    Returns:
        Exit status: 0 right, 1 the simulation could not be done, 2 unusable arguments or files.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    open_streams()
    with interrupts() as came:
        try:
            return _ended(words, commands)
        except Exception:
            if came:
                return _INTERRUPTED
            raise


def _ended(words: list[str], commands: Commands) -> int:
    """Run the command, and tell of whatever it runs into."""
    try:
        _run(words, commands)
        # While it can still be told that there is no space.
        sys.stdout.flush()
    except InputError as error:
        return _complain(error, _UNUSABLE)
    except NipperError as error:
        return _complain(error, _NOT_SIMULATED)
    except KeyboardInterrupt:
        return _INTERRUPTED
    except BrokenPipeError as error:
        return _broken(error)
    except OSError as error:
        return _unwritten(error)
    return _RIGHT


def _run(words: list[str], commands: Commands) -> None:
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
    if commands is NIPPER_PIN and words[:1] == ["study"]:
        message = (
            "there is no command 'study': nipper-pin speed-limit tells how fast a machine can run, "
            "and python -m benchmarks paper, in a checkout, does the published study again"
        )
        raise InputError(message, command="study")
    try:
        options = _options(words, commands)
    except SystemExit:
        sys.stdout.flush()
        raise
    options.words = words
    with warnings.catch_warnings():
        warnings.showwarning = _note
        options.run(options)


class _Parser(argparse.ArgumentParser):
    """Takes no option twice, names the nearest to one that is none, and reads numbers as files."""

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        # Python's own take 1_0 and digits of other scripts for numbers.
        self.register("type", float, read_number)
        self.register("type", int, read_whole)
        for stored in (None, "store"):
            self.register("action", stored, Once)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse what is left over where it is found: by the parser of the command."""
        found, left = super().parse_known_args(args, namespace)
        if left:
            near = meant(left[0].partition("=")[0], self._option_string_actions)
            self.error(f"unrecognized arguments: {' '.join(left)}; {near}-h lists the options")
        return found, left


class _PrintCompletion(argparse.Action):
    """Write the script of a shell, which completes commands, options and files, and end."""

    def __call__(self, parser: argparse.ArgumentParser, *given: Any) -> None:
        shell = given[1]
        require("completion", "shtab", what=f"--print-completion {shell}")
        import shtab

        every = _parser()
        kinds = dict.fromkeys(_FILES, shtab.FILE) | dict.fromkeys(_FOLDERS, shtab.DIRECTORY)
        _mark(every, kinds)
        sys.stdout.write(shtab.complete(every, shell))
        parser.exit()


def _mark(parser: argparse.ArgumentParser, kinds: dict[str, Any]) -> None:
    """Say of each argument whether it is a file or a folder, as shtab asks for it."""
    for action in parser._actions:
        if isinstance(action.choices, dict):
            for command in action.choices.values():
                _mark(command, kinds)
        elif action.metavar in kinds:
            action.complete = kinds[str(action.metavar)]  # type: ignore[attr-defined]


def _options(words: list[str], commands: Commands) -> argparse.Namespace:
    """The arguments of a command; one that does not exist names the nearest."""
    named = words[0] if words and words[0] in commands.places else None
    parser = _parser(named, commands)
    if words and named is None and not words[0].startswith("-"):
        there = f"{meant(words[0], commands.places)}There are {', '.join(commands.places)}"
        parser.error(f"there is no command {words[0]!r}; {there}")
    options = parser.parse_args(words)
    if options.command is None:
        parser.error("the following arguments are required: COMMAND")
    return options


def _unwritten(error: OSError) -> int:
    """Tell of an output that is full, or of another failure of the system that nobody expected."""
    place = "the output" if error.filename is None else error.filename
    message = f"{place}: cannot be written or read ({error.strerror or error}); is there space?"
    if error.errno == errno.EBADF:
        message = "the output is closed, so that nothing can be printed; > /dev/null discards it"
    status = _complain(InputError(message), _UNUSABLE)
    try:
        sys.stdout.flush()
    except OSError:
        # What is still in its buffer cannot be written; Python would complain of it at the end.
        with contextlib.suppress(OSError):
            sys.stdout.close()
    return status


def _broken(error: BrokenPipeError) -> int:
    """Tell the reader of the output, who may stop early, from a process that has died."""
    if _unread():
        # Python would complain of it when it ends.
        sys.stderr.close()
        return _RIGHT
    _say(f"another process ended before its work was done ({error})")
    return _NOT_SIMULATED


def _unread() -> bool:
    """Return whether nobody reads the output any more."""
    try:
        poll = select.poll()
        poll.register(sys.stdout.fileno(), 0)
    except (AttributeError, OSError, ValueError):
        # No such call on this system, or an output that is no file.
        return True
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in poll.poll(0))


def _note(message: Warning | str, *_: object, **__: object) -> None:
    _say(one_line(f"note: {message}"))


def _complain(error: NipperError, status: int) -> int:
    _say(error.message)
    return status


def _say(text: str) -> None:
    """Write one line to stderr; on a terminal it is broken between words."""
    line = f"nipper-pin: {text}"
    if sys.stderr.isatty():
        width = shutil.get_terminal_size().columns
        line = textwrap.fill(line, width, break_long_words=False, break_on_hyphens=False)
    sys.stderr.write(f"{line}\n")


def _parser(command: str | None = None, commands: Commands = NIPPER_PIN) -> argparse.ArgumentParser:
    """Return the parser of one command or of all; only the modules of that command are imported."""
    parser = _Parser(prog=commands.program, description=commands.description)
    if commands is NIPPER_PIN:
        parser.add_argument("--version", action="version", version=f"nipper-pin {__version__}")
        parser.add_argument(
            "--print-completion", action=_PrintCompletion, choices=_SHELLS,
            metavar="SHELL", help=f"print how a shell completes: {', '.join(_SHELLS)}",
        )  # fmt: skip
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
    for name, (place, text) in commands.places.items():
        of_command = subparsers.add_parser(name, help=text)
        if command in (None, name):
            import_module(place, __package__).add_arguments(of_command)
    return parser
