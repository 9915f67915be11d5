"""An optimisation on disk: what it is of, and each finished part, complete or not there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ...errors import InputError
from ...hybrid.storage import complete_file
from .problem import Problem

_FORMAT = 1
_PROBLEM, _PARTS = "problem.json", "parts"
PartT = TypeVar("PartT")


class Store:
    """The folder of one optimisation; without one nothing is kept.

    Args:
        folder: The folder, made if it does not exist; or None.
        problem: The problem whose parts it holds.
        settings: Settings that the parts depend on.

    Raises:
        InputError: It cannot be written, or holds another problem.
    """

    def __init__(
        self, folder: str | Path | None, problem: Problem, settings: dict[str, int]
    ) -> None:
        """Open the folder, and take up what is there if it belongs to the problem."""
        self._parts = None if folder is None else Path(folder) / _PARTS
        if self._parts is None:
            return
        try:
            self._parts.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            message = f"{folder}: cannot be made a folder ({error.strerror})"
            raise InputError(message, folder=str(folder)) from error
        here = {"format": _FORMAT, "hash": problem.hash, **settings, "title": problem.title}
        file = Path(folder or "") / _PROBLEM
        if file.exists():
            _check_same(file, here)
            return
        with complete_file(file) as partial:
            partial.write_text(json.dumps(here, indent=1) + "\n", encoding="utf-8")

    def get(self, name: str, kind: type[PartT]) -> PartT | None:
        """A finished part, or None if it is not there or not whole.

        Args:
            name: Its name.
            kind: Its type.
        """
        if self._parts is None:
            return None
        try:
            return msgspec.json.decode((self._parts / f"{name}.json").read_bytes(), type=kind)
        except (OSError, msgspec.MsgspecError):
            return None

    def put(self, name: str, part: object) -> None:
        """Keep a finished part; its file appears only when it is complete.

        Args:
            name: Its name.
            part: Plain data.
        """
        if self._parts is None:
            return
        with complete_file(self._parts / f"{name}.json") as partial:
            partial.write_bytes(msgspec.json.encode(part))


def _check_same(file: Path, here: dict[str, Any]) -> None:
    """Refuse to mix parts of two problems."""
    try:
        stored = json.loads(file.read_text(encoding="utf-8"))
        other = [key for key in here if stored.get(key) != here[key]]
    except (OSError, ValueError, AttributeError) as error:
        message = f"{file}: not the problem of an optimisation, or a damaged one ({error})"
        raise InputError(message, file=str(file)) from error
    if other:
        words = ", ".join({"hash": "problem or versions"}.get(key, key) for key in other)
        message = (
            f"{file.parent}: holds the results of another optimisation (they differ in: "
            f"{words}); give another folder with --out, or remove this one"
        )
        raise InputError(message, folder=str(file.parent), differences=other)
