"""Report of a run of a sweep."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import SimulationError
from ...hybrid import Outcome
from ..transitions import REDUCED_TURN, TURN
from .results import Tally
from .results.extremes import Extremes


@dataclass(frozen=True, kw_only=True)
class SweepReport:
    """Report of a run of a sweep.

    Attributes:
        folder: Where the results are.
        scenarios: Scenarios of the chunks that were asked for, all of which are stored.
        found: Those that were stored before.
        computed: Those that this run computed.
        chunks: Chunks that were asked for.
        damaged: Names of chunks that were damaged, and are computed anew.
        workers: Local processes, or the address of the scheduler.
        wall_s: Time of this run [s].
        tally: What the rows say together.
        extremes: Rows with the smallest and the largest value of the first quantity.
    """

    folder: Path
    scenarios: int
    found: int
    computed: int
    chunks: int
    damaged: tuple[str, ...]
    workers: int | str
    wall_s: float
    tally: Tally
    extremes: Extremes

    def record(self) -> dict[str, Any]:
        """The report as plain data for JSON."""
        return {
            "folder": str(self.folder),
            "scenarios": self.scenarios,
            "found": self.found,
            "computed": self.computed,
            "chunks": self.chunks,
            "damaged": list(self.damaged),
            "workers": self.workers,
            "wall_s": self.wall_s,
            **self.tally.record(),
            "extremes": self.extremes.record(),
        }

    def check(self) -> None:
        """Refuse a sweep without any result.

        Raises:
            SimulationError: No scenario has one.
        """
        if self.tally.without_result < self.scenarios:
            return
        reason, count = self.tally.most_frequent
        message = (
            f"none of {self.scenarios:,} scenarios has a result, {count:,} of them because: "
            f"{reason} (rows are in {self.folder}, each with its message)"
        )
        raise SimulationError(message, scenarios=self.scenarios, reason=reason)

    def sentences(self) -> list[str]:
        """Sentences about rows that need care: failures, doubtful premises, other engines."""
        tally, found = self.tally, []
        if self.damaged:
            found.append(f"damaged, and computed anew: {', '.join(self.damaged)}")
        for reason, count in tally.direct.most_common(3):
            found.append(f"{count:,} by the direct engine: {reason}")
        if tally.premise["false"]:
            found.append(
                f"{tally.premise['false']:,} do not arrive in the initial phase (premise_holds is "
                f"false); {tally.engines[TURN] + tally.engines[REDUCED_TURN]:,} of them were "
                "computed by whole turns"
            )
        ended = tally.outcomes[Outcome.TOO_MANY_COLLISIONS.name.lower()]
        if ended:
            found.append(
                f"{ended:,} ended at their largest number of collisions; what they did not come to "
                "is empty: raise max_collisions in [case], or give a rest_rate"
            )
        if tally.without_result:
            reason, count = tally.most_frequent
            found.append(f"{tally.without_result:,} without a result, {count:,} because: {reason}")
        return found
