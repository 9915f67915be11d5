"""Reviewed texts: plain files in the folder __snapshots__ beside a test.

`make snapshots` writes them anew; read what `git diff` says of them before they are committed.
"""

from __future__ import annotations

import re
from typing import Protocol

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
