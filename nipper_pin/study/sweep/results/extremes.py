"""The rows of a sweep with the smallest and the largest value of its first quantity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ....hybrid import START_INDEX
from ....hybrid.result.turns import INDICES
from ....mechanism import counted_from
from ....terms import named
from ..job import Job
from .tally import SUMMARY

if TYPE_CHECKING:
    import pyarrow as pa

# Rows that are kept, and the sign by which the value of each is the smallest.
_WORDS = {"smallest": 1.0, "largest": -1.0}


@dataclass(frozen=True, kw_only=True)
class Extreme:
    """One row.

    Attributes:
        scenario: Its number.
        value: Value of the quantity, in the unit of the results.
        numbers: Parameters of the row by name, in the units of the study.
    """

    scenario: int
    value: float
    numbers: Mapping[str, float]


class Extremes:
    """Smallest and largest value over all rows that were added.

    Args:
        job: The sweep; its first quantity counts.
    """

    def __init__(self, job: Job) -> None:
        """Know no row yet."""
        self._job = job
        self._name = job.quantities[0]
        self._found: dict[str, Extreme] = {}

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns that a summary of the sweep needs, these rows included."""
        names = (*SUMMARY, self._name, *(axis.name for axis in self._job.axes))
        return tuple(dict.fromkeys(names))

    def add(self, table: pa.Table) -> None:
        """Look at the rows of one chunk.

        Args:
            table: Its rows, at least :attr:`columns`.
        """
        values = np.asarray(table[self._name].to_numpy(), dtype=np.float64)
        known = np.flatnonzero(np.isfinite(values))
        if not len(known):
            return
        order = self._order(values[known])
        for word, sense in _WORDS.items():
            row = self._row(table, int(known[np.argmin(sense * order)]))
            self._found[word] = min(self._found.get(word, row), row, key=partial(self._rank, sense))

    def _rank(self, sense: float, row: Extreme) -> tuple[float, int]:
        """Chunks come in any order: of equal values the first scenario is told."""
        return sense * self._order(row.value), row.scenario

    def _order(self, value: Any) -> Any:
        """By what values are compared: of indices how far from the start of the turn they are."""
        return counted_from(START_INDEX, value) if self._name in INDICES else value

    def record(self) -> dict[str, Any]:
        """Both rows as plain data for JSON."""
        rows = {word: asdict(row) for word, row in self._found.items()}
        return {"quantity": self._name, **dict.fromkeys(_WORDS), **rows}

    def sentences(self) -> list[str]:
        """Both rows in words and in the units that people read."""
        return [self._sentence(word.capitalize(), row) for word, row in self._found.items()]

    def _sentence(self, word: str, item: Extreme) -> str:
        term = named(self._name, self._job.units.get(self._name, ""))
        numbers = ", ".join(f"{axis.name} {item.numbers[axis.name]:.6g}" for axis in self._job.axes)
        return (
            f"{word} {term.words}: {term.phrase(item.value)} (scenario {item.scenario}: {numbers})"
        )

    def _row(self, table: pa.Table, place: int) -> Extreme:
        return Extreme(
            scenario=int(table["scenario"][place].as_py()),
            value=float(table[self._name][place].as_py()),
            numbers={axis.name: float(table[axis.name][place].as_py()) for axis in self._job.axes},
        )
