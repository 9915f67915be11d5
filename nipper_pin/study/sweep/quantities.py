"""Quantities of a scenario that a sweep can store, by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...errors import UnknownNameError
from ...hybrid.result.quantities import COLLISION, RENAMED, TRANSITION, of_transition
from ...mechanism import Mechanism
from ..transitions import TransitionTable

_FIRST = ("duration_s", "duration_error_s", "first_two_share")
_OF_FIRST = ("impulse_N_s", "impulse_N_m_s", "rebound_amplitude", "rebound_time_s")


def default(mechanism: Mechanism) -> tuple[str, ...]:
    """Quantities that are stored by default: those of the transition and its first collision.

    Args:
        mechanism: The model.
    """
    stop = mechanism.transition_stop
    return (
        *_FIRST,
        *(
            f"{item.name}_1"
            for item in COLLISION
            if item.name in _OF_FIRST and item.fits(mechanism, stop)
        ),
    )


def check_quantities(names: Sequence[str], mechanism: Mechanism, where: str) -> None:
    """Refuse names that are no quantity of the model's transition.

    Args:
        names: Names such as ``duration_s`` or ``rebound_time_s_2`` (of the second collision).
        mechanism: The model.
        where: File and key, for messages.

    Raises:
        UnknownNameError: A name is none.
    """
    stop = mechanism.transition_stop
    each = [item for item in COLLISION if item.column and item.fits(mechanism, stop)]
    known = [item.name for item in TRANSITION if item.column]
    known += [f"{item.name}_K" for item in each]
    for name in names:
        now = RENAMED.get(name, "")
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


def quantity(table: TransitionTable, name: str) -> FloatArray:
    """Values of a quantity, shape (n,); NaN where a scenario does not have it."""
    item, place = of_transition(name)
    rows: FloatArray = getattr(table, item.column)
    if not place:
        return rows
    if place > rows.shape[1]:
        return np.full(len(table), np.nan)
    return rows[:, place - 1]
