"""A table of transitions in one line, as a notebook shows it, and as columns."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..frames import Column
from ..hybrid.result.quantities import COLLISION, TRANSITION, coordinate_unit
from ..notebook import html
from .cases import SPRING_KEYS

if TYPE_CHECKING:
    from .transitions import TransitionTable
    from .turns import TurnTable


def line(table: TransitionTable) -> str:
    """One line."""
    count = len(table)
    cases = f"{count:,} case{'' if count == 1 else 's'}"
    return f"<TransitionTable of {table.model}: {cases}, {outcomes(table)}; {table.why}>"


def page(table: TransitionTable) -> str:
    """HTML: how the cases ended, and the first of them."""
    shown = {name: list(values) for name, values in columns(table, collisions=1).items()}
    rows = list(zip(*shown.values(), strict=True))
    title = f"{len(table):,} transitions of {table.model}"
    return html(title, {"outcomes": outcomes(table), "engine": table.why}, list(shown), rows)


def columns(table: TransitionTable, collisions: int = 2) -> dict[str, Column]:
    """A table as columns: names of the JSON document, of collision K with _K behind.

    Args:
        collisions: Number of collisions that have columns.

    Returns:
        Numbers as arrays, shape (n,), NaN where a case has none; all else as lists.

    Raises:
        InputError: The number of collisions is below 0.
    """
    if collisions < 0:
        message = f"collisions = {collisions}: at least 0"
        raise InputError(message, collisions=collisions)
    whole: dict[str, Column] = {
        "engine": table.engine.tolist(),
        "outcome": table.outcome.tolist(),
        "message": list(table.message),
        "speed_rpm": table.speed_rpm,
        "restitution": table.restitution,
        **spring_columns(table),
    }
    for quantity in TRANSITION:
        name = quantity.column or quantity.name
        values = getattr(table, name)
        whole[quantity.name] = values.tolist() if values.dtype == object else values
    nothing = np.full(len(table), np.nan)
    each = {
        f"{name}_{place + 1}": rows[:, place] if place < rows.shape[1] else nothing
        for place in range(collisions)
        for name, rows in _rows(table)
    }
    return {**whole, **each}


def spring_columns(table: TransitionTable | TurnTable) -> dict[str, Column]:
    """Rates and preloads by their paths in the model, in the units of its file."""
    return {
        f"springs.{spring.name}.{key}": getattr(table, row)[:, place] / scale
        for place, spring in enumerate(table.mechanism.springs)
        for key, (unit, row, scale, _) in SPRING_KEYS.items()
        if unit == coordinate_unit(table.mechanism, spring.index)
    }


def _rows(table: TransitionTable) -> list[tuple[str, Any]]:
    """Rows of collisions by name; of an impulse, the name with the unit of the stop."""
    stop = table.mechanism.transition_stop
    return [
        (item.name, getattr(table, item.column))
        for item in COLLISION
        if item.column and item.fits(table.mechanism, stop)
    ]


def outcomes(table: TransitionTable | TurnTable) -> str:
    """How the cases of a table ended, and how many so."""
    found = Counter(table.outcome.tolist())
    return ", ".join(f"{count:,} {word.replace('_', ' ')}" for word, count in found.most_common())
