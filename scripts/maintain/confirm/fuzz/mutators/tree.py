"""Changes of a tree of plain data: JSON and MessagePack."""

from __future__ import annotations

import json
import random
from typing import Any

import msgspec

from .lines import change_lines
from .words import NUMBERS, TEXTS, other_text
from .xml import change_xml

# How many changes there are.
_CHANGES = (1, 1, 1, 1, 2, 3)
_FACTORS = (-1.0, 0.0, 0.5, 2.0, 1.0 + 1e-9, 0.99, 1e6, 1e-6, 1e300, float("nan"))
# Part of the messages that ask for a value of a control.
_ASKED = 0.5
_CONTROLS = ("speed", "restitution", "steeve.stiffness", "steeve.preload", "play")
_LARGEST_BITS = 63


def change_json(data: bytes, chance: random.Random) -> bytes:
    """Change a JSON text.

    Args:
        data: The text.
        chance: Source of chance.
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return change_lines(data, chance)
    return json.dumps(change_tree(document, chance)).encode("utf-8", "replace")


def change_packed(data: bytes, chance: random.Random) -> bytes:
    """Change a message in MessagePack.

    Args:
        data: The message.
        chance: Source of chance.
    """
    try:
        document = msgspec.msgpack.decode(data)
        if chance.random() < _ASKED:
            document = {
                "type": "GuiUpdateMessage",
                "uuid": chance.choice(_CONTROLS),
                "updates": {"value": chance.choice((_scalar(chance), chance.gauss(0.0, 1e3)))},
            }
            if chance.random() < _ASKED:
                return msgspec.msgpack.encode(document)
        return msgspec.msgpack.encode(change_tree(document, chance))
    except (ValueError, TypeError, OverflowError, RecursionError):
        return data[: chance.randrange(len(data) + 1)] + bytes([chance.randrange(256)])


def change_tree(document: Any, chance: random.Random) -> Any:
    """The document with some of its values replaced, removed, doubled or exchanged.

    Args:
        document: Plain data; it is changed.
        chance: Source of chance.
    """
    for _ in range(chance.choice(_CHANGES)):
        holders = list(_holders(document))
        if not holders:
            return _scalar(chance)
        holder = chance.choice(holders)
        key = chance.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
        kind = chance.random()
        if kind < 0.75:
            holder[key] = _like(holder[key], chance)
        elif kind < 0.83:
            holder[key] = _scalar(chance)
        elif kind < 0.87:
            other = chance.choice(holders)
            holder[key] = json.loads(json.dumps(other, default=str))
        elif kind < 0.94:
            del holder[key]
        elif isinstance(holder, list):
            holder.insert(chance.randrange(len(holder) + 1), holder[key])
        else:
            holder[chance.choice(TEXTS)] = holder[key]
    return document


def _holders(value: Any) -> Any:
    """Tables and lists that are not empty."""
    if isinstance(value, dict | list) and value:
        yield value
        for item in value.values() if isinstance(value, dict) else value:
            yield from _holders(item)


def _like(value: Any, chance: random.Random) -> Any:
    """Another value of the same type, more or less."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + chance.choice((-1, 1, -value, value, 2**31, 2**53, -(2**62)))
    if isinstance(value, float):
        return value * chance.choice(_FACTORS)
    if isinstance(value, str):
        if value.lstrip().startswith("<"):
            return change_xml(value.encode(), chance).decode()
        return other_text(value, chance)
    if isinstance(value, list):
        return value[: chance.randrange(len(value) + 1)] * chance.choice((1, 1, 2))
    return _scalar(chance)


def _scalar(chance: random.Random) -> Any:
    kind = chance.randrange(7)
    if kind == 0:
        return chance.choice((None, True, False, [], {}, [[]], [None], {"a": 1}))
    if kind == 1:
        return chance.choice((-1, 1)) * chance.getrandbits(chance.randint(1, _LARGEST_BITS))
    if kind == 2:
        return chance.choice(TEXTS)
    if kind == 3:
        return [float(chance.randrange(5)) for _ in range(chance.randrange(6))]
    try:
        return float(chance.choice(NUMBERS))
    except ValueError:
        return 0.5
