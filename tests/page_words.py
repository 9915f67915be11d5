"""What a page of a film writes, as text that can be reviewed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

# Letters of the longest text that people read.
_LONG = 2000


def film_of(page: str) -> dict[str, Any]:
    """All that it writes, as plain data."""
    (text,) = re.findall(r'<script id="film" type="application/json">(.*?)</script>', page, re.S)
    found: dict[str, Any] = json.loads(text)
    return found


def said(page: str) -> str:
    """A line for each part of it; of many marks the first ones."""
    return "\n".join(_lines(film_of(page))) + "\n"


def _lines(film: dict[str, Any]) -> Iterator[str]:
    for key, value in film.items():
        if isinstance(value, list) and value and isinstance(value[0], dict | list):
            yield from (f"{key}: {_told(item)}" for item in value[:25])
            if len(value) > 25:
                yield f"{key}: {len(value)} in all"
        else:
            yield f"{key}: {_told(value)}"


def _told(value: Any) -> str:
    """A value in a line; of many numbers how many there are."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {_told(item)}" for key, item in value.items())
    if isinstance(value, str) and len(value) > _LONG:
        # What moves the machine: its last bits are those of the processor.
        return "..."
    if isinstance(value, list):
        if len(value) > 8:
            return f"({len(value)})"
        return f"({', '.join(map(_told, value))})"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
