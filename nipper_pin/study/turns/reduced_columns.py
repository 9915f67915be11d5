"""Quantities of the reduced engine under the names, and in the units, of a table of turns."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray
from ...hybrid import START_INDEX
from ...mechanism import INDEX_PER_TURN, within_turn
from ...reduced.turns import TurnQuantities

_OF_CLAMP = (
    "clamped_time", "clamped_time_error", "clamped_share", "least_clamping_force",
    "largest_clamping_force", "clamping_force_error", "largest_gap", "largest_gap_error",
    "energy_lost", "energy_lost_error",
)  # fmt: skip
_EACH = ("collisions", "impulse_sum", "impulse_sum_error", "largest_impulse",
         "largest_impulse_error")  # fmt: skip
_OF_DRIVES = "largest_torque", "largest_torque_error"
_INDICES = {
    "closing_index": "closed_at",
    "rest_index": "rests_at",
    "loss_index": "lost_at",
    "opening_index": "opened_at",
}
_PER_RAD = INDEX_PER_TURN / math.tau


def reduced_columns(found: TurnQuantities) -> dict[tuple[str, str], FloatArray]:
    """Columns of the last turn of each case, by attribute and name of the stop or drive."""
    again = found.repeats_after.astype(np.float64)
    columns: dict[tuple[str, str], FloatArray] = {("repeats_after", ""): again}
    for name in _OF_CLAMP:
        columns[name, ""] = np.array(getattr(found, name))
    for name, place in _INDICES.items():
        columns[name, ""] = within_turn(START_INDEX + _PER_RAD * getattr(found, place))
        columns[f"{name}_error", ""] = _PER_RAD * getattr(found, f"{place}_error")
    for names, parts in ((_EACH, found.stops), (_OF_DRIVES, found.drives)):
        for name in names:
            for number, part in enumerate(parts):
                columns[name, part] = np.array(getattr(found, name)[:, number])
    return columns
