"""Reading of TOML text, whatever is wrong with it, and which texts may stand in it."""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import ModelError

_FORMULA = ("=", "+", "-", "@")
_LINES = str.maketrans("", "", "\n\t")
NAMES = (
    "a name that is not empty, without line breaks and control characters, and does not begin with "
    "= + - or @, which programs for tables take for a formula"
)
"""What a name may be: it is printed on terminals and written into tables."""


def read_toml(text: str, file: str) -> dict[str, object]:
    """Return a TOML document as plain data.

    Raises:
        ModelError: It is no well-formed TOML, nests too deeply or has a number that is too long.
    """
    import tomllib

    try:
        return tomllib.loads(text)
    except RecursionError as error:
        wrong, allowed = "too deep", "lists and tables that do not nest so deeply"
        raise ModelError(file=file, key="TOML", value=wrong, allowed=allowed) from error
    except tomllib.TOMLDecodeError as error:
        allowed = "a well-formed TOML document"
        raise ModelError(file=file, key="TOML", value=str(error), allowed=allowed) from error
    except ValueError as error:
        wrong, allowed = "a number too long", "whole numbers of at most some thousand digits"
        raise ModelError(file=file, key="TOML", value=wrong, allowed=allowed) from error


def is_name(text: str) -> bool:
    """Return whether a text may be the name of a part: see :data:`NAMES`."""
    return bool(text) and text.isprintable() and not text.startswith(_FORMULA)


def need_plain_text(document: object, file: str, where: str = "") -> None:
    """Refuse keys that are no names, and texts with control characters.

    A terminal would obey them: it would be cleared, or its title changed.

    Args:
        document: A TOML document as plain data, or a part of it.
        where: Path of the part.

    Raises:
        ModelError: Names such a text.
    """
    if isinstance(document, Mapping):
        for key, value in document.items():
            if isinstance(key, str) and not is_name(key):
                raise ModelError(file=file, key=where or "key", value=key, allowed=NAMES)
            need_plain_text(value, file, f"{where}.{key}" if where else str(key))
    elif isinstance(document, list | tuple):
        for value in document:
            if not isinstance(value, float):
                need_plain_text(value, file, where)
    elif isinstance(document, str) and not document.translate(_LINES).isprintable():
        allowed = "text without control characters"
        raise ModelError(file=file, key=where, value=document, allowed=allowed)
