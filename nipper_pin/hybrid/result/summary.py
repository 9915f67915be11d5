"""A solution in one line, as a notebook shows it, and its collisions as columns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...frames import Column
from ...notebook import html
from ...terms.shown import counted
from ...units import MS_PER_S
from ..event import EventKind

if TYPE_CHECKING:
    from .simulated import Simulated

_SHOWN = ("number", "stop", "time_s", "index", "approach_rate", "separation_rate", "energy_lost_J",
          "rebound_amplitude", "rebound_time_s")  # fmt: skip


def line(solution: Simulated) -> str:
    """One line; nothing is computed for it."""
    hits = (event for event in solution.events if event.kind is EventKind.COLLISION)
    count = sum(len(event.struck(solution.mechanism)) for event in hits)
    return (
        f"<Solution of {solution.mechanism.name}: {_case(solution)}, "
        f"{counted(count, 'collision')}, {solution.outcome.name.lower()}>"
    )


def page(solution: Simulated) -> str:
    """HTML: the case, how the run ended, and its collisions."""
    facts = {"case": _case(solution), "outcome": solution.outcome.value}
    if solution.transitions:
        facts["transition"] = f"{MS_PER_S * solution.transitions[0].duration:.6g} ms"
    table = columns(solution)
    shown = {name: table[name] for name in _SHOWN if name in table}
    rows = list(zip(*shown.values(), strict=True))
    return html(solution.mechanism.title or solution.mechanism.name, facts, list(shown), rows)


def columns(solution: Simulated) -> dict[str, Column]:
    """Collisions as columns, by the names of the JSON document (docs/json.md).

    Returns:
        Numbers as arrays, shape (collisions,), NaN where the document has none; names as lists.
        Without collisions nothing.
    """
    from .json_document import record

    hits = record(solution)["collisions"]
    names = dict.fromkeys(name for hit in hits for name in hit)
    return {name: _column([hit.get(name) for hit in hits]) for name in names}


def _column(values: list[Any]) -> Column:
    if any(isinstance(value, str | int) for value in values):
        return values
    return np.array([np.nan if value is None else value for value in values])


def _case(solution: Simulated) -> str:
    case = solution.case
    turns = f"{case.cycles} turn{'' if case.cycles == 1 else 's'}"
    window = turns if case.window.value == "cycle" else case.window.value
    return f"{case.speed_rpm:g} r/min, {window}, {case.drive.value} drive"
