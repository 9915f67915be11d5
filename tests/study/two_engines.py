"""How far tables of two engines may be apart."""

from __future__ import annotations

from typing import Any

import numpy as np

from nipper_pin import TransitionTable, TurnTable
from nipper_pin.hybrid.result.turns import of_turn

# Round-off of forces that the direct engine solves for, by the largest one, and of other numbers.
FORCE, EPS = 1e-10, float(np.finfo(float).eps)
# Columns of a table of transitions, and the errors that it states of them.
STATED = {
    "time": "time_error",
    "approach_rate": "rate_error",
    "impulse": "impulse_error",
    "rebound_amplitude": "amplitude_error",
    "rebound_time": "rebound_error",
}
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


def agree(one: TransitionTable, other: TransitionTable, mine: Any, its: Any) -> None:
    """Rows of both, in this order, are the same within the errors that both state."""
    assert one.outcome[mine].tolist() == other.outcome[its].tolist()
    count = min(one.time.shape[1], other.time.shape[1])
    for name, error in {"duration": "duration_error", **STATED}.items():
        a, b = getattr(one, name)[mine], getattr(other, name)[its]
        stated, more = getattr(one, error)[mine], getattr(other, error)[its]
        if name == "duration":
            np.testing.assert_array_equal(np.isnan(a), np.isnan(b))
        else:
            a, b, stated, more = (values[:, :count] for values in (a, b, stated, more))
        known = np.isfinite(a) & np.isfinite(b)
        most = (stated + more + 64.0 * EPS * np.abs(a))[known]
        assert (np.abs(a - b)[known] <= most).all(), name
    share = one.first_two_share[mine], other.first_two_share[its]
    np.testing.assert_allclose(*share, rtol=1e-7)
    turns = (one.cylinder_angle[mine, :1] - other.cylinder_angle[its, :1]) / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-9)
