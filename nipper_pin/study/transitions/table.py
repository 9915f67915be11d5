"""Columns of a table of transitions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import InputError
from ...frames import Column, data_frame
from ...hybrid.result.quantities import COLLISION, TRANSITION
from ...notebook import html
from ...reduced.results import CollisionRows
from ..case_table import CaseTable

FAILED = "failed"
REDUCED = "reduced"
"""Engine of a case that tables solve."""
TURN = "turn"
"""Engine of a case for which whole turns were simulated, since the premise does not hold."""
REDUCED_TURN = "reduced_turn"
"""Engine of a case whose whole turns were followed by tables, for the same reason."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class TransitionTable(CaseTable, CollisionRows):
    """Transitions of n cases; the rows have shape (n, most), NaN beyond the last collision.

    Attributes:
        model: Name of the model.
        why: Why the engine was chosen, and how many cases it left to the other one.
        engine: Engine of each case, "reduced" or "direct"; "reduced_turn" or "turn": the same on
            whole turns, because the premise of a transition does not hold, shape (n,).
        outcome: How each case ended: "at_rest"; "no_rest" or "too_many_collisions"; "failed"; and,
            if the reduced engine was forced, its ``nipper_pin.reduced.Status`` in lower case.
        message: For each case why it failed, or why the reduced engine left it to the direct one;
            empty for all others.
        speed_rpm: Cylinder speed of each case [r/min], shape (n,).
        restitution: e_N of the transition stop, shape (n,).
        stiffness: Spring rates, shape (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, shape (n, springs) [m or rad].
        collisions: Collisions of the transition stop that were computed, shape (n,).
        duration: Time from the first collision to rest [s], NaN without rest, shape (n,).
        duration_error: Stated error of it [s], shape (n,).
        first_two_share: Share of the first two rebounds in the duration, NaN with fewer,
            shape (n,).
        premise_holds: True or False: whether the machine arrives in its initial phase, as a
            transition assumes; None where it was not asked, shape (n,).
        table: All rows, shape (n, rows, most). The errors are bounds where the reduced engine
            computed and estimates where the direct one did; see ``docs/accuracy.md``.
        mechanism: The mechanism, with the values that no column changes.
    """

    restitution: FloatArray
    collisions: NDArray[np.int64]
    duration: FloatArray
    duration_error: FloatArray
    first_two_share: FloatArray
    premise_holds: NDArray[np.object_]
    table: FloatArray

    def _repr_html_(self) -> str:
        shown = {name: list(values) for name, values in self._columns(collisions=1).items()}
        rows = list(zip(*shown.values(), strict=True))
        title = f"{len(self):,} transitions of {self.model}"
        facts = {"outcomes": self._outcomes(), "engine": self.why}
        return html(title, facts, list(shown), rows)

    def to_frame(self, library: str | None = None, *, collisions: int = 2) -> Any:
        """All cases as a data frame: names and units of the JSON document and of study files.

        Args:
            library: "pandas", "polars" or "pyarrow"; by default the first that is installed.
            collisions: Number of collisions that have columns, ``approach_rate_1`` and so on.

        Raises:
            InputError: It is not installed, or a number is out of range.
        """
        return data_frame(self._columns(collisions), library)

    def _columns(self, collisions: int) -> dict[str, Column]:
        """Names of the JSON document, of collision K with _K behind.

        Returns:
            Numbers as arrays, shape (n,), NaN where a case has none; all else as lists.
        """
        if collisions < 0:
            message = f"collisions = {collisions}: at least 0"
            raise InputError(message, collisions=collisions)
        whole = self._cases({"restitution": self.restitution})
        for quantity in TRANSITION:
            values = getattr(self, quantity.column or quantity.name)
            whole[quantity.name] = values.tolist() if values.dtype == object else values
        nothing = np.full(len(self), np.nan)
        stop = self.mechanism.transition_stop
        # Of an impulse the name with the unit of the stop.
        each = {item.name: getattr(self, item.column) for item in COLLISION
                if item.column and item.fits(self.mechanism, stop)}  # fmt: skip
        return whole | {
            f"{name}_{place + 1}": rows[:, place] if place < rows.shape[1] else nothing
            for place in range(collisions)
            for name, rows in each.items()
        }
