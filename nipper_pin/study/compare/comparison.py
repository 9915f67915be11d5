"""The comparison of two runs: a table of quantities, what differs, and what cannot be compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from ...errors import InputError
from ...hybrid import Solution, Window, need_sound
from ...hybrid.result.turns import INDICES
from ...mechanism import Mechanism, index_difference
from .changes import Change, changes
from .readings import Reading, reading

_WINDOWS = {Window.TRANSITION: "a transition", Window.CYCLE: "whole turns"}


@dataclass(frozen=True)
class Row:
    """One quantity of both runs.

    Attributes:
        name: Its name in files, such as ``duration_s`` or ``rebound_amplitude_1``.
        unit: SI unit, empty without one.
        a: In A; None if A does not have it.
        b: In B.
    """

    name: str
    unit: str
    a: float | None
    b: float | None

    @property
    def difference(self) -> float | None:
        """B less A, of indices the short way around; None if one of them does not have it."""
        if self.a is None or self.b is None:
            return None
        return index_difference(self.b, self.a) if self.name in INDICES else self.b - self.a

    @property
    def percent(self) -> float | None:
        """Difference by the size of A [%]; None if A is zero and B is not, and of indices."""
        if self.a is None or self.difference is None or self.name in INDICES:
            return None
        if self.difference == 0.0:
            return 0.0
        return 100.0 * self.difference / abs(self.a) if self.a else None


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Two runs side by side.

    Attributes:
        a: One run.
        b: The other one.
        rows: Quantities that both can have.
        changes: What differs in setting and machine.
        notes: What cannot be compared and why, one sentence each.
    """

    a: Solution
    b: Solution
    rows: tuple[Row, ...]
    changes: tuple[Change, ...]
    notes: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether every quantity is the same in both, to the last bit."""
        return all(row.a == row.b for row in self.rows)

    def row(self, name: str) -> Row:
        """One quantity.

        Args:
            name: Its name in files.

        Raises:
            InputError: There is none of this name.
        """
        found = next((item for item in self.rows if item.name == name), None)
        if found is None:
            known = ", ".join(item.name for item in self.rows)
            message = f"{name} is none of the quantities that are compared: {known}"
            raise InputError(message, name=name)
        return found

    def record(self) -> dict[str, Any]:
        """As plain data: names of files, SI units."""
        return {
            "a": _run_record(self.a),
            "b": _run_record(self.b),
            "rows": [
                {
                    **asdict(row),
                    "difference": row.difference,
                    "difference_percent": row.percent,
                }
                for row in self.rows
            ],
            "changes": [asdict(item) for item in self.changes],
            "notes": list(self.notes),
        }

    def __repr__(self) -> str:
        """One line."""
        names = f"{self.a.mechanism.name} and {self.b.mechanism.name}"
        return f"<Comparison of {names}: {len(self.rows)} quantities, {len(self.changes)} changes>"

    def _repr_html_(self) -> str:
        from ...notebook import html

        facts = {"A": repr(self.a), "B": repr(self.b), "note": " ".join(self.notes) or "none"}
        rows = [(row.name, row.unit, row.a, row.b, row.percent) for row in self.rows]
        return html("Comparison", facts, ("quantity", "unit", "A", "B", "%"), rows, len(rows))


def compare(a: Solution, b: Solution) -> Comparison:
    """Compare two runs of the same window.

    Args:
        a: One run.
        b: The other one; differences are B less A.

    Returns:
        The table, what differs in machine and setting, and what cannot be compared.

    Raises:
        InputError: One of them is no run, or their windows differ.
        SelfCheckError: A run does not meet its closures or its energy balance.
    """
    for name, run in (("A", a), ("B", b)):
        if not isinstance(run, Solution):
            message = f"compare takes two runs, and {name} is {run!r}: nip.simulate(...)"
            raise InputError(message, run=run)
        need_sound(run)
    if a.case.window is not b.case.window:
        message = (
            f"A is a run of {_WINDOWS[a.case.window]} (window {a.case.window.value}) and B of "
            f"{_WINDOWS[b.case.window]} (window {b.case.window.value}), which have no times in "
            "common: simulate both with the same --window"
        )
        raise InputError(message, a=a.case.window.value, b=b.case.window.value)
    one, other = reading(a), reading(b)
    rows = tuple(
        Row(name, unit, value, other.values[name][1])
        for name, (unit, value) in one.values.items()
        if name in other.values and other.values[name][0] == unit
    )
    return Comparison(a, b, rows, changes(a, b), tuple(_notes(a, b, one, other)))


def _run_record(run: Solution) -> dict[str, Any]:
    return {"model": run.mechanism.name, **asdict(run.case), "outcome": run.outcome.value}


def _notes(a: Solution, b: Solution, one: Reading, other: Reading) -> Iterator[str]:
    """What cannot be compared, and what only looks alike."""
    yield from _alone(a.mechanism, b.mechanism)
    first, second = a.mechanism.transition_stop, b.mechanism.transition_stop
    if first and second and first != second:
        yield f"The transition is that of the {first} in A and of the {second} in B."
    if any(
        name in other.values and other.values[name][0] != unit
        for name, (unit, _) in one.values.items()
    ):
        yield (
            f"The {first} of A and the {second} of B have other units, because one turns and the "
            "other slides: gaps and amplitudes are left out."
        )
    for side, read in (("A", one), ("B", other)):
        if read.missing:
            yield f"Not all can be read off {side}: {read.missing}."
    for side, run in (("A", a), ("B", b)):
        if run.case.window is Window.TRANSITION and run.premise_holds is False:
            yield f"No turn has the transition of {side}: {run.premise.why}"


def _alone(a: Mechanism, b: Mechanism) -> Iterator[str]:
    """Parts that one machine alone has."""
    parts: list[tuple[str, list[str], list[str]]] = [
        ("links", list(a.links), list(b.links)),
        ("stops", [stop.name for stop in a.stops], [stop.name for stop in b.stops]),
    ]
    if set(a.links) == set(b.links):
        parts.insert(1, ("joints", _joints(a), _joints(b)))
    for kind, one, other in parts:
        for side, own, others in (("A", one, other), ("B", other, one)):
            left = [name for name in own if name not in others]
            if left:
                noun = kind if len(left) > 1 else kind.removesuffix("s")
                verb = "are" if len(left) > 1 else "is"
                yield f"Only {side} has the {noun} {', '.join(left)}, which {verb} not compared."


def _joints(mechanism: Mechanism) -> list[str]:
    return [f"{item.name} ({item.kind})" for item in mechanism.joints]
