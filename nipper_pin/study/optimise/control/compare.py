"""The control of an optimum: a simulated turn of the machine, held against what was reported.

The model is loaded by name with the overrides that the result gives out and simulated by the direct
engine until its turns repeat. A search evaluates transitions, kinematics and tables, so what these
got wrong shows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import NipperError
from ....hybrid.result.turns import INDICES
from ....mechanism import index_difference, load
from ..design import Design
from ..problem.problem import Limit, Problem, read_text
from .reading import ControlTurn, control_turn, read


@dataclass(frozen=True, kw_only=True)
class Row:
    """One quantity, as reported and in the simulated turn.

    Attributes:
        quantity: Its name.
        unit: Its unit, empty without one.
        reported: The reported value.
        turn: The value of the turn; None if it has none.
        allowed: By how much they may differ: the stated errors of both.
        breaks: Limits, in words, that the turn breaks by more than that.
        why: Why the turn has no value; empty if it has one.
    """

    quantity: str
    unit: str
    reported: float
    turn: float | None
    allowed: float
    breaks: tuple[str, ...] = ()
    why: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the turn has the reported value and keeps the limits."""
        if self.turn is None or self.breaks:
            return False
        if self.quantity == "stop_force_N" and self.turn == 0.0:
            # An open stop has no force; a force below zero means that the stop opens.
            return self.reported <= self.allowed
        return abs(_apart(self.quantity, self.reported, self.turn)) <= self.allowed

    def __str__(self) -> str:
        """Both numbers in words."""
        unit = f" {self.unit}" if self.unit else ""
        seen = f"none ({self.why})" if self.turn is None else f"{self.turn:.6g}{unit}"
        limits = f", which breaks {' and '.join(self.breaks)}" if self.breaks else ""
        return (
            f"{self.quantity} is {self.reported:.6g}{unit} as reported and {seen} in the simulated "
            f"turn{limits}"
        )


@dataclass(frozen=True, kw_only=True)
class Control:
    """Comparison of one design with simulated turns.

    Attributes:
        rows: The quantities that the problem asks for; empty if no turn could be simulated.
        turns: Turns that were computed.
        why: Why there is no turn, or none that repeats; empty otherwise.
    """

    rows: tuple[Row, ...]
    turns: int
    why: str

    @property
    def confirmed(self) -> bool:
        """Whether the turn has all that is reported."""
        return not self.why and all(row.agrees for row in self.rows)

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Differences as sentences; empty if the design is confirmed."""
        found = [str(row) for row in self.rows if not row.agrees]
        return (*([self.why] if self.why else []), *found)

    def record(self) -> dict[str, Any]:
        """The control as plain data for JSON."""
        return {
            "engine": "direct",
            "window": "cycle",
            "turns": self.turns,
            "confirmed": self.confirmed,
            "values": self.values,
            "allowed": {row.quantity: row.allowed for row in self.rows},
            "contradictions": list(self.contradictions),
        }

    @property
    def values(self) -> dict[str, float | None]:
        """Quantities of the turn by name."""
        return {row.quantity: row.turn for row in self.rows}


def control(text: bytes, design: Design) -> Control:
    """Simulate turns of a design, and compare them with what is reported of it."""
    problem, z = read_text(text), np.array(design.z)
    try:
        mechanism = load(problem.model, problem.overrides(z))
        turn = control_turn(mechanism, problem.speed(z), problem.rest_rate)
    except NipperError as error:
        return Control(rows=(), turns=0, why=f"no turn can be simulated: {error.message}")
    rows = tuple(
        _row(problem, turn, name, design.values[name], design.errors[name])
        for name in problem.quantities
    )
    why = "" if turn.repeats else f"{turn.computed} simulated turns do not repeat"
    return Control(rows=rows, turns=turn.computed, why=why)


def _row(problem: Problem, turn: ControlTurn, name: str, reported: float, error: float) -> Row:
    unit = problem.units[name]
    try:
        seen = read(turn, name)
    except NipperError as missing:
        return Row(
            quantity=name, unit=unit, reported=reported, turn=None, allowed=error,
            why=missing.message,
        )  # fmt: skip
    allowed = error + seen.error
    broken = tuple(
        str(limit)
        for limit in problem.limits
        if limit.quantity == name
        and _outside(limit, seen.value) > max(_outside(limit, reported), 0.0) + allowed
    )
    return Row(
        quantity=name, unit=unit, reported=reported, turn=seen.value, allowed=allowed,
        breaks=broken,
    )  # fmt: skip


def _outside(limit: Limit, value: float) -> float:
    """By how much a value is outside a limit; negative inside."""
    over = _apart(limit.quantity, value, limit.value)
    return over if limit.side == "high" else -over


def _apart(quantity: str, one: float, other: float) -> float:
    """Difference of two values; of two indices the short way around the turn."""
    return index_difference(one, other) if quantity in INDICES else one - other
