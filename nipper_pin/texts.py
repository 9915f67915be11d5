"""Files of other people: regular ones alone, read as a whole, and not if they are too large."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable
from io import BufferedReader
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


def followed(path: str | Path) -> Path:
    """A path with its links followed, whole and absolute; links in a circle stay in it.

    `Path.resolve` refuses a circle up to Python 3.12, and no longer from 3.13 on.

    Args:
        path: The path; nothing need be there.
    """
    return Path(os.path.realpath(path))


def no_file(path: Path) -> str:
    """What stands in the place of a file, in words; empty for a file, and where nothing stands.

    Args:
        path: The path; links are followed.
    """
    try:
        return _kind(os.stat(path).st_mode)
    except FileNotFoundError:
        return "a link that leads nowhere" if path.is_symlink() else ""
    except OSError as error:
        return "links in a circle" if error.errno == errno.ELOOP else ""
    except ValueError:
        # A name with a null character, that no file has.
        return ""


def _kind(mode: int) -> str:
    """Kind of what is no file, by its mode; empty for a file."""
    kinds = {stat.S_IFREG: "", stat.S_IFDIR: "a folder", stat.S_IFIFO: "a named pipe"}
    return kinds.get(stat.S_IFMT(mode), "a device or a socket")


def opened(file: Path) -> BufferedReader:
    """Open a file for reading; what is no file may never end, or never begin.

    Args:
        file: The file.

    Raises:
        OSError: It cannot be read, or is a pipe, a device or a folder.
    """

    def at_once(path: str, flags: int) -> int:
        return os.open(path, flags | os.O_NONBLOCK)

    stream = open(file, "rb", opener=at_once)  # noqa: SIM115
    kind = _kind(os.fstat(stream.fileno()).st_mode)
    if kind:
        stream.close()
        message = f"it is {kind}, and only files are read"
        raise OSError(message)
    return stream


def read_bytes(file: Path, most: int) -> bytes:
    """Return the content of a file.

    Args:
        file: The file.
        most: Most bytes that it may have.

    Raises:
        InputError: It is larger.
        OSError: It cannot be read.
    """
    # One byte more than allowed tells, also of a file that grows.
    with opened(file) as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        message = f"{file.name}: larger than {most / 2**20:g} MiB, the most that is read of it"
        raise InputError(message, file=str(file), most=most)
    return content


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
    content = read_bytes(file, most)
    text = content.decode(encoding if isinstance(encoding, str) else encoding(content))
    return text.replace("\r\n", "\n").replace("\r", "\n")
