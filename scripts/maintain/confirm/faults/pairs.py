"""Two processes that write the same output at once."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from arena import Arena, Fault
from field import Field, Seen
from verdicts import NEW, WRONG, Content, content, leftovers, split

OTHER = "other"


def racing_pairs(
    field: Field, second: Arena, number: int, rng: np.random.Generator
) -> Iterator[Seen]:
    """Start two commands, the second one up to a tenth of a run later.

    Args:
        field: The command.
        second: What runs the second process.
        number: Number of pairs.
        rng: Source of the delays.
    """
    words = field.command.pair or field.command.words
    others = field.other(words)
    for turn in range(number):
        place = field.fresh()
        delay = float(rng.uniform(-0.1, 0.1) * field.wall_s) if turn % 2 else 0.0
        first, both = (field.command.words, words) if delay >= 0.0 else (words, field.command.words)
        field.arena.begin(field.words(first), place, Fault())
        time.sleep(abs(delay))
        second.begin(field.words(both), place, Fault())
        ends = [field.arena.ended(), second.ended()]
        found = [content(place / name) for name in field.command.targets]
        states = tuple(
            _whose(*item, field.command.parts)
            for item in zip(found, field.new, others, strict=True)
        )
        refused = [item for item in ends if item.status != 0]
        seen = Seen(fault=Fault(), ended=(refused or ends)[0], states=states)
        left = leftovers(place)
        for bad, why in (
            (WRONG in states, "neither of one nor of the other"),
            (len(refused) == 2, f"both refused: {[item.said for item in refused]}"),
            (refused and not _sentence(refused[0].said), f"no sentence: {refused[0:1]}"),
            (left, f"left {left}"),
        ):
            if bad and not seen.wrong:
                seen = replace(seen, wrong=f"{why} ({place})")
        if not seen.wrong:
            shutil.rmtree(place.parent)
        yield seen


def _whose(found: Content, new: Content, other: Content, parts: str) -> str:
    """Which of the two a result is of; what is finished part by part may be of both."""
    kept, rest = split(found, parts)
    right = all(data in (new.get(name), other.get(name)) for name, data in kept.items())
    if right and rest == split(new, parts)[1]:
        return NEW
    return OTHER if right and rest == split(other, parts)[1] else WRONG


def _sentence(said: str) -> bool:
    return said.startswith("nipper-pin: ") and said.count("\n") == 1
