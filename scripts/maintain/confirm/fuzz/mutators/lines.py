"""Changes of the lines of a text: TOML and CSV."""

from __future__ import annotations

import random

from .words import NUMBERS, TEXTS, other_text

# How many changes there are.
_CHANGES = (1, 1, 1, 1, 2, 2, 3)
_VALUES = (
    "[]", "{}", "[[]]", '""', "true", "1979-05-27", "[1, 2]", '["x"]', "{ low = 1.0, high = 2.0 }",
    "'''", "[nan]", "{ law = 'falling', fast = 0.0, scale = 1.0 }", "not toml", "[" * 200,
)  # fmt: skip


def change_lines(data: bytes, chance: random.Random) -> bytes:
    """Change values, lose, double and move lines.

    Args:
        data: The text.
        chance: Source of chance.
    """
    lines = data.decode("utf-8", "replace").splitlines() or [""]
    for _ in range(chance.choice(_CHANGES)):
        place = chance.randrange(len(lines))
        kind = chance.random()
        if kind < 0.75:
            told = [at for at, line in enumerate(lines) if "=" in line or "," in line]
            place = chance.choice(told or [place])
            lines[place] = _value(lines[place], chance)
        elif kind < 0.8:
            lines[place] = other_text(lines[place], chance)
        elif kind < 0.87:
            del lines[place]
        elif kind < 0.92:
            lines.insert(chance.randrange(len(lines) + 1), lines[place])
        elif kind < 0.99:
            lines.insert(place, lines.pop(chance.randrange(len(lines))))
        else:
            lines = lines[: place + 1]
        lines = lines or [""]
    return "\n".join(lines).encode("utf-8", "replace") + b"\n"


def _value(line: str, chance: random.Random) -> str:
    """Another value behind the sign of equality, or another key before it."""
    key, sign, value = line.partition("=")
    if not sign:
        return other_text(line, chance)
    kind = chance.random()
    if kind < 0.6 and any(letter.isdigit() for letter in value):
        return f"{key}={other_text(value, chance)}"
    if kind < 0.8 and '"' in value:
        return f'{key}= "{chance.choice(TEXTS)}"'
    if kind < 0.85:
        return f"{key}= {chance.choice(_VALUES)}"
    if kind < 0.95:
        return f"{key}= {chance.choice(NUMBERS)}"
    return f"{chance.choice(TEXTS)} = {value}"
