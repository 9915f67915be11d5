"""A table of turns in one line, as a notebook shows it, and as columns."""

from __future__ import annotations

from ...frames import Column
from ...hybrid.result.turns import turn_names
from ...notebook import html
from ..table_summary import outcomes, spring_columns
from .table import TurnTable

# Columns that a notebook shows beside parameters and outcome.
_SHOWN = ("turns", "repeats_after", "clamped_share", "closing_index", "rest_index", "opening_index")


def line(table: TurnTable) -> str:
    """One line."""
    count = len(table)
    cases = f"{count:,} case{'' if count == 1 else 's'}"
    return f"<TurnTable of {table.model}: {cases}, {outcomes(table)}; {table.why}>"


def page(table: TurnTable) -> str:
    """HTML: how the cases ended, and the first of them."""
    every = columns(table)
    head = ("engine", "outcome", "message", "speed_rpm", *_SHOWN)
    rows = list(zip(*(list(every[name]) for name in head), strict=True))
    title = f"Turns of {table.model}: {len(table):,} cases"
    return html(title, {"outcomes": outcomes(table), "engine": table.why}, head, rows)


def columns(table: TurnTable) -> dict[str, Column]:
    """A table as columns: parameters by their paths in the model, quantities by their names.

    Returns:
        Numbers as arrays, shape (n,), NaN where a case has none; all else as lists.
    """
    return {
        "engine": table.engine.tolist(),
        "outcome": table.outcome.tolist(),
        "message": list(table.message),
        "speed_rpm": table.speed_rpm,
        **{f"stops.{name}.restitution": e_N for name, e_N in table.restitution.items()},
        **spring_columns(table),
        "turns": table.turns,
        "repeats_after": table.repeats_after,
        **{
            name: table.quantity(name)
            for name in turn_names(table.mechanism, drives=bool(table.largest_torque))
            if name != "repeats_after"
        },
    }
