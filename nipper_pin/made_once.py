"""What is made once for an object, and kept as long as the object lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar, TypeVarTuple
from weakref import WeakKeyDictionary

Of = TypeVar("Of")
Rest = TypeVarTuple("Rest")
Made = TypeVar("Made")


def made_once(make: Callable[[Of, *Rest], Made]) -> Callable[[Of, *Rest], Made]:
    """Keep what a function makes of an object, known by identity, and of further values.

    Args:
        make: The function. What it returns must not hold the object, which would never go then.
    """
    known: WeakKeyDictionary[Of, dict[tuple[object, ...], Made]] = WeakKeyDictionary()

    @wraps(make)
    def found(of: Of, *rest: *Rest) -> Made:
        made = known.setdefault(of, {})
        if rest not in made:
            made[rest] = make(of, *rest)
        return made[rest]

    return found
