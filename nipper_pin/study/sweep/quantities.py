"""What a sweep can keep of each scenario, by name."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from ...arrays import FloatArray
from ...errors import UnknownNameError
from ..transitions import TransitionTable

DEFAULT = (
    "duration_s",
    "duration_error_s",
    "first_two_share",
    "impulse_N_s_1",
    "rebound_amplitude_1",
    "rebound_time_s_1",
)
_WHOLE: dict[str, Callable[[TransitionTable], FloatArray]] = {
    "duration_s": lambda table: table.duration,
    "duration_error_s": lambda table: table.duration_error,
    "first_two_share": lambda table: table.first_two_share,
}
# Of collision K, named with "_K" behind.
_EACH: dict[str, Callable[[TransitionTable], FloatArray]] = {
    "time_s": lambda table: table.time,
    "cylinder_angle_rad": lambda table: table.cylinder_angle,
    "approach_rate": lambda table: table.approach_rate,
    "separation_rate": lambda table: table.separation_rate,
    "impulse_N_s": lambda table: table.impulse,
    "energy_lost_J": lambda table: table.energy_lost,
    "rebound_amplitude": lambda table: table.rebound_amplitude,
    "rebound_time_s": lambda table: table.rebound_time,
    "time_error_s": lambda table: table.time_error,
    "rate_error": lambda table: table.rate_error,
    "impulse_error_N_s": lambda table: table.impulse_error,
    "amplitude_error": lambda table: table.amplitude_error,
    "rebound_error_s": lambda table: table.rebound_error,
}
_NUMBERED = re.compile(r"(.+)_([1-9][0-9]{0,3})")


def check_quantities(names: Sequence[str], where: str) -> None:
    """Refuse names that are no quantity.

    Args:
        names: Names such as ``duration_s`` or ``rebound_time_s_2`` (of the second collision).
        where: File and key, for messages.

    Raises:
        UnknownNameError: A name is none.
    """
    for name in names:
        found = _NUMBERED.fullmatch(name)
        if name not in _WHOLE and (found is None or found[1] not in _EACH):
            known = (*_WHOLE, *(f"{item}_K" for item in _EACH))
            raise UnknownNameError(kind="quantity", name=name, known=known, where=where)


def quantity(table: TransitionTable, name: str) -> FloatArray:
    """Values of a quantity, shape (n,); NaN where a scenario does not have it."""
    if name in _WHOLE:
        return _WHOLE[name](table)
    found = _NUMBERED.fullmatch(name)
    key, place = ("", "1") if found is None else (found[1], found[2])
    rows = _EACH[key](table)
    column = int(place) - 1
    if column >= rows.shape[1]:
        return np.full(len(table), np.nan)
    return rows[:, column]
