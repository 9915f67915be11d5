"""``nipper-pin --print-completion SHELL``: how a shell completes commands, options and files."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import Any

from ..extras import require

SHELLS = ("bash", "zsh", "fish", "powershell", "tcsh")
_FILES = {"FILE", "MODEL", "A", "B", "NAME"}
_FOLDERS = {"DIR", "FOLDER"}


class PrintCompletion(argparse.Action):
    """Write the script of a shell to stdout, and end.

    Args:
        every: Makes the parser of all commands, whose modules are imported for a script alone.
    """

    def __init__(
        self, *args: Any, every: Callable[[], argparse.ArgumentParser], **more: Any
    ) -> None:
        """Keep what makes the parser."""
        super().__init__(*args, **more)
        self._every = every

    def __call__(self, parser: argparse.ArgumentParser, *given: Any) -> None:
        """Write the script of the shell that is given."""
        shell = given[1]
        require("completion", "shtab", what=f"--print-completion {shell}")
        import shtab

        every = self._every()
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
