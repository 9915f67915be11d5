"""The text of TOML documents: read, whatever is wrong with it, and written of plain data."""

from __future__ import annotations

import re
from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from ...errors import ModelError


def plain(data: Any) -> Any:
    """The same tables and lists, their numbers and arrays being those of Python."""
    if isinstance(data, np.generic) or (isinstance(data, np.ndarray) and not data.ndim):
        return data.item()
    if isinstance(data, np.ndarray):
        # Places are members of sets.
        return tuple(plain(value) for value in data)
    if isinstance(data, Mapping):
        return {str(key): plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return type(data)(plain(value) for value in data)
    if isinstance(data, Real) and not isinstance(data, int | float):
        return float(data)
    return data


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


_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml(document: Mapping[str, Any]) -> str:
    """Write plain data as TOML; it reads back equal."""
    lines: list[str] = []
    _table(plain(document), (), lines)
    return "\n".join(lines) + "\n"


def _table(table: Mapping[str, Any], path: tuple[str, ...], lines: list[str]) -> None:
    """Values first: what follows a heading in TOML belongs to it."""
    inner: list[tuple[str, str, Mapping[str, Any]]] = []
    for key, value in table.items():
        heading = ".".join(map(_key, (*path, key)))
        if isinstance(value, Mapping):
            inner.append((key, f"[{heading}]", value))
        elif isinstance(value, list | tuple) and value and isinstance(value[0], Mapping):
            inner.extend((key, f"[[{heading}]]", item) for item in value)
        else:
            lines.append(f"{_key(key)} = {_value(value)}")
    for key, heading, item in inner:
        lines.extend(("", heading))
        _table(item, (*path, key), lines)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _quoted(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    return repr(value)


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
