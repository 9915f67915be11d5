"""Numbers that are typed, as the command line takes them: taken, or refused in plain words."""

from __future__ import annotations

import math

from ...written_units import number_in
from .settings import Knob

LONGEST = 40
"""Most letters of a field that are read."""


def field_text(value: float) -> str:
    """A number as it stands in a field."""
    return f"{value:.12g}"


def typed(knob: Knob, text: str, shown: float) -> tuple[float | None, str]:
    """The number that a text in a field means, or why there is none.

    Args:
        text: The text; the number may have a unit of its own.
        shown: The number that is shown instead.

    Returns:
        The number, or None; why it cannot be used, what can, and what is shown: empty of a number.
    """
    found = text.strip()
    value, reason = None, "the field is empty"
    if found:
        try:
            value = number_in(found, knob.shown.unit)
            side = "too large" if value > knob.high else "too small"
            reason = f"{found} is {'no number' if math.isnan(value) else side}"
        except ValueError as error:
            reason = f"“{found}” is not {error}"
    if value is not None and knob.low <= value <= knob.high:
        return value, ""
    now, low, high = (field_text(item) for item in (shown, knob.low, knob.high))
    unit = f" {knob.shown.unit}".rstrip()
    words = f"{knob.shown.words}: {low} to {high}{unit}. Refused: {reason}. Shown: {now}{unit}."
    return None, words
