"""Quantities of a scenario that a sweep can store, by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...errors import UnknownNameError
from ...hybrid.result.quantities import COLLISION, TRANSITION, of_transition
from ...hybrid.result.turns import of_turn, turn_names
from ...mechanism import Mechanism
from ...terms import NONE, unit_of
from ..transitions import TransitionTable
from ..turns import TurnTable
from .axes import Axis
from .job import TURN_COLUMNS

_FIRST = ("duration_s", "duration_error_s", "first_two_share")
_OF_FIRST = ("impulse_N_s", "impulse_N_m_s", "rebound_amplitude", "rebound_time_s")


_OF_TURN = (
    "clamped_time_s", "clamped_share", "closing_index", "rest_index", "opening_index",
    "largest_gap", "energy_lost_turn_J",
)  # fmt: skip


def default(mechanism: Mechanism, *, turns: bool = False) -> tuple[str, ...]:
    """Quantities that are stored by default: those of the transition and its first collision.

    Args:
        turns: Whether whole turns are followed; then some of theirs.
    """
    if turns:
        return _OF_TURN
    stop = mechanism.transition_stop
    return (
        *_FIRST,
        *(
            f"{item.name}_1"
            for item in COLLISION
            if item.name in _OF_FIRST and item.fits(mechanism, stop)
        ),
    )


def check_quantities(
    names: Sequence[str], mechanism: Mechanism, where: str, *, turns: bool = False
) -> None:
    """Refuse names that are no quantity of the model's transition, or of its turn.

    Args:
        names: Names such as ``duration_s`` or ``rebound_time_s_2`` (of the second collision).
        where: File and key, for messages.
        turns: Whether whole turns are followed.

    Raises:
        UnknownNameError: A name is none.
    """
    if turns:
        every = turn_names(mechanism, drives=True)
        for name in names:
            # The column of this name is always there.
            if name not in every or name in TURN_COLUMNS:
                known = [item for item in every if item not in TURN_COLUMNS]
                raise UnknownNameError(kind="quantity", name=name, known=known, where=where)
        return
    stop = mechanism.transition_stop
    each = [item for item in COLLISION if item.column and item.fits(mechanism, stop)]
    known = [item.name for item in TRANSITION if item.column]
    known += [f"{item.name}_K" for item in each]
    for name in names:
        now = ""
        try:
            item, place = of_transition(name)
        except KeyError:
            pass
        else:
            if item.column and item.fits(mechanism, stop):
                continue
            # An impulse has another unit and name where the stop has no contact point.
            same = [other.name for other in each if other.column == item.column]
            now = f"{same[0]}_{place}" if same else ""
        raise UnknownNameError(kind="quantity", name=name, known=known, where=where, now=now)


def units_of(
    axes: Sequence[Axis], quantities: Sequence[str], mechanism: Mechanism, *, turns: bool = False
) -> dict[str, str]:
    """Unit of every column of numbers, parameters as in the model's file.

    Numbers of a URDF are left out: their names do not say.

    Args:
        turns: Whether the quantities are those of whole turns.
    """
    stops, found = {stop.name for stop in mechanism.stops}, {}
    for name in quantities:
        item, part = of_turn(name, mechanism) if turns else (of_transition(name)[0], "")
        stop = part if part in stops else mechanism.transition_stop
        found[name] = item.unit_at(mechanism, stop) or NONE
    for axis in axes:
        head, _, last = axis.target.path.rpartition(".")
        if not head.startswith("urdf."):
            found[axis.name] = unit_of(last)
    return found


def quantity(table: TransitionTable | TurnTable, name: str) -> FloatArray:
    """Values of a quantity, shape (n,); NaN where a scenario does not have it."""
    if isinstance(table, TurnTable):
        return table.quantity(name)
    item, place = of_transition(name)
    rows: FloatArray = getattr(table, item.column)
    if not place:
        return rows
    if place > rows.shape[1]:
        return np.full(len(table), np.nan)
    return rows[:, place - 1]
