"""An optimisation on disk: its problem, and each finished part, written atomically."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import msgspec

from ...errors import InputError
from ...outputs import complete_file
from ...texts import MOST_JSON, read_bytes
from ..folders import claim, make_folder
from .problem.problem import Problem

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
        here = {"format": _FORMAT, "hash": problem.hash, **settings, "title": problem.title}
        work, names = "optimisation", {"hash": "problem or versions"}
        claim(self._parts.parent, _PROBLEM, here, work, names)
        make_folder(self._parts)

    def get(self, name: str, kind: type[PartT]) -> PartT | None:
        """A finished part, or None if it is not there or not whole.

        Args:
            name: Its name.
            kind: Its type.
        """
        if self._parts is None:
            return None
        try:
            content = read_bytes(self._parts / f"{name}.json", MOST_JSON)
            return msgspec.json.decode(content, type=kind)
        except (OSError, InputError, msgspec.MsgspecError):
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
