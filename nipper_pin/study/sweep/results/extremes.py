"""The rows of a sweep with the smallest and the largest value of its first quantity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
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

    Attributes:
        smallest: The row with the smallest value; None as long as no row has one.
        largest: The row with the largest value.
    """

    def __init__(self, job: Job) -> None:
        """Know no row yet."""
        self._job = job
        self._name = job.quantities[0]
        self.smallest: Extreme | None = None
        self.largest: Extreme | None = None

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
        low = self._row(table, int(known[np.argmin(order)]))
        high = self._row(table, int(known[np.argmax(order)]))
        # Chunks come in any order: of equal values the first scenario is told.
        self.smallest = min(
            (item for item in (self.smallest, low) if item),
            key=lambda x: (self._order(x.value), x.scenario),
        )
        self.largest = min(
            (item for item in (self.largest, high) if item),
            key=lambda x: (-self._order(x.value), x.scenario),
        )

    def _order(self, value: Any) -> Any:
        """By what values are compared: of indices how far from the start of the turn they are."""
        return counted_from(START_INDEX, value) if self._name in INDICES else value

    def record(self) -> dict[str, Any]:
        """Both rows as plain data for JSON."""
        return {
            "quantity": self._name,
            "smallest": None if self.smallest is None else asdict(self.smallest),
            "largest": None if self.largest is None else asdict(self.largest),
        }

    def sentences(self) -> list[str]:
        """Both rows in words and in the units that people read."""
        pairs = (("Smallest", self.smallest), ("Largest", self.largest))
        return [self._sentence(word, item) for word, item in pairs if item is not None]

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
