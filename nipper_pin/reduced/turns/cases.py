"""Cases of one mechanism whose turns are followed together."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from ...errors import InputError
from ...units import S_PER_MIN
from ..inputs import column, spring_rows
from .model import TurnModel


def check_counts(turns: int, last: int) -> None:
    """Refuse less than one turn.

    Args:
        turns: Largest number of turns that are followed.
        last: Number of those that are reported.

    Raises:
        InputError: One of them is below 1.
    """
    for key, value in (("turns", turns), ("last", last)):
        if value < 1:
            message = f"{key} = {value!r} cannot be used: a whole number from 1"
            raise InputError(message, key=key, value=value)


def turn_cases(
    model: TurnModel,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None,
    stiffness: ArrayLike | None,
    preload: ArrayLike | None,
) -> list[FloatArray]:
    """Numbers of n cases; a single number stands for all of them.

    Args:
        model: The model of the turns.
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,).
        restitution: e_N of the transition stop, or of stops by name; None: the mechanism's.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].

    Returns:
        Speeds, shape (n,) [rad/s]; restitutions, shape (n, K); spring rates and deflections, shape
        (n, springs).

    Raises:
        InputError: A number is out of range, or the arrays have different lengths.
    """
    speed = column("speed_rpm", speed_rpm, 0.0, math.inf, open_low=True) * (math.tau / S_PER_MIN)
    if restitution is None:
        restitution = {}
    if not isinstance(restitution, Mapping):
        restitution = {model.transition_stop: restitution}
    columns = [
        column(f"restitution of {name}", restitution.get(name, own), 0.0, 1.0)
        for name, own in zip(model.stops, model.restitution, strict=True)
    ]
    springs = len(model.springs)
    rates = spring_rows("stiffness", model.stiffness if stiffness is None else stiffness, springs,
                        0.0)  # fmt: skip
    lengths = spring_rows("preload", model.preload if preload is None else preload, springs,
                          -math.inf)  # fmt: skip
    try:
        (n,) = np.broadcast_shapes(speed.shape, *(item.shape for item in columns),
                                   rates.shape[:1], lengths.shape[:1])  # fmt: skip
    except ValueError as error:
        message = f"the arrays of a batch need the same number of cases: {error}"
        raise InputError(message) from error
    e_N = np.stack([np.broadcast_to(item, (n,)) for item in columns], axis=1)
    full = (speed, (n,)), (e_N, e_N.shape), (rates, (n, springs)), (lengths, (n, springs))
    return [np.ascontiguousarray(np.broadcast_to(item, shape)) for item, shape in full]
