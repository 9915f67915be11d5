"""Numbers that are typed: taken, or refused in plain words with the range that is allowed."""

from __future__ import annotations

import re

from .settings import Knob

# Thousands may be set apart by commas; a comma in another place is no decimal point.
_NUMBER = re.compile(
    r"[+-]?(?:(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?", re.ASCII
)
LONGEST = 40
"""Most letters of a field that are read."""


def field_text(value: float) -> str:
    """A number as it stands in a field."""
    return f"{value:.12g}"


def typed(knob: Knob, text: str) -> float | None:
    """The number that a text in a field means; None if it cannot be used."""
    if not _NUMBER.fullmatch(text.strip()):
        return None
    value = float(text.replace(",", ""))
    return value if knob.low <= value <= knob.high else None


def refusal(knob: Knob, text: str, shown: float) -> str:
    """Why a text cannot be used, what can, and what is shown instead."""
    found = text.strip()
    reason = f"“{found}” is no number"
    if not found:
        reason = "the field is empty"
    elif _NUMBER.fullmatch(found):
        high = float(found.replace(",", "")) > knob.high
        reason = f"{found} is too {'large' if high else 'small'}"
    elif re.fullmatch(r"[+-]?\d+,\d+", found):
        reason = f"“{found}”: decimals follow a point"
    now = f"{field_text(shown)} {knob.unit}".rstrip()
    return f"{knob.name}: {_range(knob)}. Refused: {reason}. Shown: {now}."


def _range(knob: Knob) -> str:
    return f"{knob.low:,.12g} to {knob.high:,.12g} {knob.unit}".rstrip()
