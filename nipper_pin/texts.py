"""Text files of other people: read as a whole, and not if they are too large."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .errors import InputError

MOST_TEXT = 4 * 2**20
"""Most that is read of a URDF, a TOML file or a manifest [byte]: two hundred times the E62's."""
MOST_TABLE = 16 * 2**20
"""Most that is read of a CSV file [byte]: a hundred thousand rows of 160 characters."""
MOST_JSON = 16 * 2**20
"""Most that is read of a JSON file [byte]: a case with four tables of a hundred thousand rows. Its
objects take twenty times as much as its text."""
# Of a path and of a name in it, everywhere [byte].
_LONGEST_PATH, _LONGEST_NAME = 2000, 255


def is_path(text: str) -> bool:
    """Whether a file may have this path; systems end with an error of their own otherwise.

    Args:
        text: The path.
    """
    whole = text.encode("utf-8", "replace")
    longest = max(map(len, whole.split(b"/")))
    return b"\0" not in whole and len(whole) <= _LONGEST_PATH and longest <= _LONGEST_NAME


def read_text(file: Path, most: int, encoding: str | Callable[[bytes], str] = "utf-8-sig") -> str:
    """Return the text of a file, without a byte order mark.

    Args:
        file: The file.
        most: Most bytes that it may have.
        encoding: Its encoding, or what tells that from its bytes.

    Raises:
        InputError: It is larger.
        OSError: It cannot be read.
        UnicodeError: It is no such text.
        LookupError: There is no such encoding.
    """
    # One byte more than allowed tells, also of a pipe, which has no size.
    with file.open("rb") as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        message = f"{file.name}: larger than {most / 2**20:g} MiB, the most that is read of it"
        raise InputError(message, file=str(file), most=most)
    text = content.decode(encoding if isinstance(encoding, str) else encoding(content))
    return text.replace("\r\n", "\n").replace("\r", "\n")
