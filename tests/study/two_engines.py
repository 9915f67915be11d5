"""How far tables of turns of two engines may be apart."""

from __future__ import annotations

import numpy as np

from nipper_pin import TurnTable
from nipper_pin.hybrid.result.turns import of_turn

# Round-off of forces that the direct engine solves for, by the largest one, and of other numbers.
FORCE, EPS = 1e-10, float(np.finfo(float).eps)
# Events at which clamping begins or ends.
ENDS = "closing_index", "rest_index", "loss_index", "opening_index"


def difference(few: TurnTable, many: TurnTable, i: int, name: str) -> tuple[float, float, float]:
    """A quantity of a case in both tables, and the most by which it may differ."""
    item, part = of_turn(name, few.mechanism)
    column = item.column

    def stated(*columns: str) -> float:
        found = [getattr(table, f"{key}_error") for table in (few, many) for key in columns]
        return float(np.nansum([(errors[part] if part else errors)[i] for errors in found]))

    one, other = (float(table.quantity(name)[i]) for table in (few, many))
    room = 64.0 * EPS * max(abs(one), 1.0)
    if column in ("collisions", "repeats_after"):
        return one, other, 0.0
    if column.startswith("clamped"):
        # Of the direct engine the errors are those of the events between which it is clamped.
        turn = 60.0 / float(few.speed_rpm[i])
        room += stated("clamped_time") / turn + stated(*ENDS) / 40.0
        return one, other, room * (turn if column == "clamped_time" else 1.0)
    if column.endswith("clamping_force"):
        return one, other, stated("clamping_force") + FORCE * float(few.largest_clamping_force[i])
    if column == "largest_torque":
        room += FORCE * abs(one)
    return one, other, room + stated(column)
