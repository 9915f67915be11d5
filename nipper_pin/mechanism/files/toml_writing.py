"""Plain data as the text of a TOML document."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from .plain import plain

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
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
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
