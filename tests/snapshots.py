"""Reviewed texts: plain files in the folder __snapshots__ beside a test.

`make snapshots` writes them anew; read what `git diff` says of them before they are committed.
"""

from __future__ import annotations

import re
from itertools import groupby
from pathlib import Path
from typing import NamedTuple, Protocol

from syrupy.extensions.single_file import SingleFileSnapshotExtension, WriteMode

# What differs from one processor, or from one moment, to the next: sizes of round-off (and other
# small numbers), how much work it was, and times of the clock.
_OF_THE_MACHINE = re.compile(
    r"\b\d(\.\d+)?e-\d+\b"
    r"|\b[\d,]+(?= evaluations of| points in| by the \w+ engine| by whole turns)"
    r"|(?<=the dynamics, )[\d.]+|(?<= in )[\d.]+(?= s$)",
    re.M,
)


class Words(Protocol):
    """Says that a text is the reviewed one: masked, without what depends on its computer."""

    def __call__(self, text: str, *, masked: bool = True) -> None: ...


class Text(SingleFileSnapshotExtension):
    """A file for each text."""

    _write_mode = WriteMode.TEXT
    file_extension = "txt"


def without_the_machine(text: str) -> str:
    """The text with # for what depends on its computer; of numbers with all digits twelve stay."""
    rounded = re.sub(r"\d+\.\d{13,}", lambda found: repr(float(f"{float(found[0]):.12g}")), text)
    return _OF_THE_MACHINE.sub("#", rounded)


class Block(NamedTuple):
    """A name of a reviewed text and its edits, and both as they stand there."""

    name: str
    edits: list[str]
    text: str


def blocks(test: str, name: str) -> list[Block]:
    """Of the reviewed text of a test, which says what is asked and, below that, what is answered.

    Each name is a line; below it stand old lines with -, new ones with +, and the answers. Names
    are added in the file, and `make snapshots` adds the answers.
    """

    def kind(line: str) -> str:
        return next((start for start in ("- ", "+ ", "    ") if f"{line} ".startswith(start)), "")

    file = Path(test).with_name("__snapshots__") / Path(test).stem / f"{name}.txt"
    found = list[Block]()
    for start, lines in groupby(file.read_text(encoding="utf-8").splitlines(), kind):
        written = [*lines]
        piece = "\n".join(line[len(start) :] for line in written)
        if not start:
            found.append(Block(piece, [], ""))
        if start.strip():
            found[-1].edits.append(piece)
        if start != "    ":
            found[-1] = found[-1]._replace(text=found[-1].text + "\n".join(written) + "\n")
    return found
