"""Numbers of the page with their words, and how far they are from those of another setting."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ...mechanism import index_difference
from ..compare.words import index_text, percent_text


class Number(NamedTuple):
    """One row of the page.

    Attributes:
        key: Its name in the page.
        label: What it is, with its unit.
        text: What is shown.
        value: The value itself, from which differences are computed; None without one.
        on_scale: Whether it is a place on the comber's scale, whose difference is in indices.
    """

    key: str
    label: str
    text: str
    value: float | None = None
    on_scale: bool = False


Rows = tuple[Number, ...]
"""Rows of a table."""


def difference(now: Number, other: Number | None) -> str:
    """The difference of a number to that of another setting, if that has one: per cent, or indices.

    Returns:
        With its sign; empty where there is nothing to compare, or no number of which it is a part.
    """
    if other is None or now.value is None or other.value is None:
        return ""
    if not (math.isfinite(now.value) and math.isfinite(other.value)):
        return ""
    if now.value == other.value:
        return "0"
    if now.on_scale:
        return index_text(index_difference(now.value, other.value))
    return "" if other.value == 0.0 else percent_text(100.0 * (now.value / other.value - 1.0))


def told(rows: Sequence[Number], others: Sequence[Number] = ()) -> list[tuple[str, ...]]:
    """Key, label, text and difference of each row, to those of another setting."""
    known = {item.key: item for item in others}
    return [
        (item.key, item.label, item.text, difference(item, known.get(item.key))) for item in rows
    ]
