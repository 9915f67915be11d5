"""Counts over the rows of a sweep: engines, outcomes, and their reasons."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, Any

from ....errors import without_numbers
from ...transitions import FAILED
from ..job import NO_MODEL
from .chunk_file import about

if TYPE_CHECKING:
    import pyarrow as pa

SUMMARY = ("scenario", "engine", "outcome", "message", "premise_holds")
"""Columns that a summary is made of."""


class Tally:
    """Counts over all rows that were added.

    Attributes:
        outcomes: Rows by outcome.
        engines: Rows by engine.
        direct: Rows of the direct engine by the reason why it served.
        premise: Rows by whether the premise of a transition holds: "true", "false", or "null" where
            that is not known.
    """

    def __init__(self) -> None:
        """Count nothing yet."""
        self.rows = 0
        self.outcomes: Counter[str] = Counter()
        self.engines: Counter[str] = Counter()
        self.direct: Counter[str] = Counter()
        self.premise: Counter[str] = Counter()
        # Reasons that differ in their numbers alone count together; one of them is told.
        self._failed: Counter[str] = Counter()
        self._told: dict[str, str] = {}

    def add(self, table: pa.Table) -> None:
        """Count the rows of one chunk.

        Args:
            table: Its rows, at least the columns :data:`SUMMARY`, with their metadata.
        """
        self.rows += len(table)
        self.direct.update(about(table).get("direct", {}))
        held = table["premise_holds"].value_counts().to_pylist()
        self.premise.update({json.dumps(item["values"]): item["counts"] for item in held})
        counted = table.group_by(["engine", "outcome", "message"]).aggregate([([], "count_all")])
        for row in counted.to_pylist():
            count = row["count_all"]
            self.outcomes[row["outcome"]] += count
            self.engines[row["engine"]] += count
            if row["outcome"] in (FAILED, NO_MODEL):
                kind = without_numbers(row["message"])
                self._failed[kind] += count
                self._told.setdefault(kind, row["message"])

    @property
    def without_result(self) -> int:
        """Rows that have no result."""
        return self.outcomes[FAILED] + self.outcomes[NO_MODEL]

    @property
    def most_frequent(self) -> tuple[str, int]:
        """The most frequent reason why a row has no result, and of how many rows it is."""
        kind, count = self._failed.most_common(1)[0]
        return self._told[kind], count

    def record(self) -> dict[str, Any]:
        """The counts as plain data for JSON."""
        return {
            "outcomes": dict(self.outcomes),
            "engines": dict(self.engines),
            "direct": dict(self.direct),
            "premise_holds": dict(self.premise),
            "without_result": self.without_result,
        }
