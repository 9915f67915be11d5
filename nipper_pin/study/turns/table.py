"""Quantities of the turns of many cases."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...frames import Column, data_frame
from ...hybrid.result.turns import of_turn, turn_names
from ...notebook import html
from ..case_table import CaseTable

# Columns that a notebook shows beside parameters and outcome.
_SHOWN = ("turns", "repeats_after", "clamped_share", "closing_index", "rest_index", "opening_index")
FOLLOWED = "followed"
"""Outcome of a case whose turns were followed to the last one, or until they repeat."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class TurnTable(CaseTable):
    """One turn of each of n cases: the first that repeats an earlier one, or the last followed.

    A turn that repeats the one before stands for all that follow. Arrays have shape (n,), NaN where
    a turn has no such event or a case no result. The transition stop is the one that clamps.
    Indices are from 0 to below 40; forces act at the contact point of the stop, or along the joint
    of one without.

    Attributes:
        model: Name of the model.
        why: Why the engine was chosen, and how many cases it left to the other one.
        engine: Engine of each case, "reduced" or "direct".
        outcome: How each case ended: "followed", "too_many_collisions" or "failed"; and, if the
            reduced engine was forced, its ``nipper_pin.reduced.turns.TurnStatus`` in lower case.
        message: For each case why it failed, or why the reduced engine left it to the direct one;
            empty for all others.
        speed_rpm: Cylinder speed [r/min].
        restitution: e_N of each stop by its name.
        stiffness: Spring rates, shape (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, shape (n, springs) [m or rad].
        turns: Number of the turn, the first being 1; 0 without a result.
        repeats_after: After how many turns it repeats an earlier one; 0 if it does not.
        clamped_time: Time with the stop closed and its force above the given one [s].
        clamped_share: The same by the time of a turn.
        clamped_time_error: Its stated error [s]; the direct engine states none.
        closing_index: Index of its first collision.
        rest_index: Index of its first rest.
        loss_index: Index at which its force falls to zero.
        opening_index: Index at which a collision of another stop throws it open.
        closing_index_error: Stated error; those of the other indices are called likewise.
        least_clamping_force: Smallest force while it is closed [N or N m].
        largest_clamping_force: Largest force.
        clamping_force_error: Bound on the errors of both; the direct engine states none.
        largest_gap: Largest gap of its rebounds [rad or m].
        largest_gap_error: Its stated error.
        energy_lost: Kinetic energy lost in all collisions [J].
        energy_lost_error: Its stated error [J].
        collisions: By stop: collisions that were computed.
        impulse_sum: By stop: sum of impulses [N s or N m s].
        impulse_sum_error: By stop: its stated error.
        largest_impulse: By stop: largest impulse.
        largest_impulse_error: By stop: its stated error.
        largest_torque: By drive, empty unless asked for: largest magnitude of the torque between
            events [N m]; of a drive along a slide [N].
        largest_torque_error: By drive: its stated error; the direct engine states none.
        mechanism: The mechanism, with the values that no column changes.
    """

    restitution: Mapping[str, FloatArray]
    turns: NDArray[np.int64]
    repeats_after: NDArray[np.int64]
    clamped_time: FloatArray
    clamped_share: FloatArray
    closing_index: FloatArray
    rest_index: FloatArray
    loss_index: FloatArray
    opening_index: FloatArray
    clamped_time_error: FloatArray
    closing_index_error: FloatArray
    rest_index_error: FloatArray
    loss_index_error: FloatArray
    opening_index_error: FloatArray
    least_clamping_force: FloatArray
    largest_clamping_force: FloatArray
    clamping_force_error: FloatArray
    largest_gap: FloatArray
    largest_gap_error: FloatArray
    energy_lost: FloatArray
    energy_lost_error: FloatArray
    collisions: Mapping[str, FloatArray]
    impulse_sum: Mapping[str, FloatArray]
    impulse_sum_error: Mapping[str, FloatArray]
    largest_impulse: Mapping[str, FloatArray]
    largest_impulse_error: Mapping[str, FloatArray]
    largest_torque: Mapping[str, FloatArray]
    largest_torque_error: Mapping[str, FloatArray]

    def _repr_html_(self) -> str:
        every = self._columns()
        head = ("engine", "outcome", "message", "speed_rpm", *_SHOWN)
        rows = list(zip(*(list(every[name]) for name in head), strict=True))
        title = f"Turns of {self.model}: {len(self):,} cases"
        return html(title, {"outcomes": self._outcomes(), "engine": self.why}, head, rows)

    def quantity(self, name: str) -> FloatArray:
        """Values of a quantity by its name in files, such as ``rest_index``, shape (n,).

        Args:
            name: The name; of a stop or drive with its name behind, such as ``collisions_jaw``.

        Raises:
            KeyError: There is none of this name, or it was not asked for.
        """
        item, part = of_turn(name, self.mechanism)
        found = getattr(self, item.column)
        return np.asarray(found[part] if part else found, dtype=np.float64)

    def to_frame(self, library: str | None = None) -> Any:
        """All cases as a data frame, with the names and units of study files.

        Args:
            library: "pandas", "polars" or "pyarrow"; by default the first that is installed.

        Raises:
            InputError: It is not installed.
        """
        return data_frame(self._columns(), library)

    def _columns(self) -> dict[str, Column]:
        """A table as columns: parameters by their paths in the model, quantities by their names.

        Returns:
            Numbers as arrays, shape (n,), NaN where a case has none; all else as lists.
        """
        e_N = {f"stops.{name}.restitution": value for name, value in self.restitution.items()}
        return {
            **self._cases(e_N),
            "turns": self.turns,
            "repeats_after": self.repeats_after,
            **{
                name: self.quantity(name)
                for name in turn_names(self.mechanism, drives=bool(self.largest_torque))
                if name != "repeats_after"
            },
        }
