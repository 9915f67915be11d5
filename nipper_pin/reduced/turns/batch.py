"""Many cases of one mechanism's turns, on the narrowest tables that hold each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import FloatArray
from ...errors import InputError
from ...extras import require
from ...mechanism import Mechanism
from ...units import S_PER_MIN
from ..inputs import column, spring_rows
from ..kernels import turn_layout as rows
from .model import TurnModel
from .results import TurnStatus
from .turn import BESIDE, ROOMS, STRETCHES, scratch, wider

_LEFT_GAP = int(TurnStatus.LEFT_GAP)


@dataclass(frozen=True)
class Settings:
    """What all cases of a batch share."""

    turns: int
    least_force: float
    rest_rate: float
    tolerance: float
    most: int


def _run(
    model: TurnModel,
    cases: list[FloatArray],
    settings: Settings,
    told: NDArray[np.int64],
    found: FloatArray,
) -> None:
    """Follow cases on one model."""
    run_turns, grids = _compiled()
    run_turns(
        grids,
        model.charts,
        scratch(model, settings.most),
        *cases,
        np.ones(len(told)),
        settings.rest_rate,
        settings.tolerance,
        settings.turns,
        model.begin,
        model.clamp,
        settings.least_force,
        np.empty((settings.turns * (settings.most + BESIDE), rows.EVENT_COLUMNS)),
        np.empty((settings.turns * STRETCHES, rows.HOLD_COLUMNS)),
        np.empty((settings.turns + 1, 5)),
        told,
        found,
    )


def follow_all(
    mechanism: Mechanism,
    start_index: float,
    cases: list[FloatArray],
    settings: Settings,
    told: NDArray[np.int64],
    found: FloatArray,
) -> None:
    """Follow cases, those that leave the tables of a model on the next wider one.

    Args:
        mechanism: The mechanism.
        start_index: Index at which turns start.
        cases: Of :func:`cases_of`.
        settings: What all cases share.
        told: Written: status, turns, and after how many the last repeats, shape (n, 3).
        found: Written: quantities of the last turns, shape (n, last, quantities).
    """
    left = np.arange(len(told))
    for room in ROOMS:
        model = wider(mechanism, start_index, room) if len(left) else None
        if model is None:
            break
        here = told[left], found[left]
        _run(model, [item[left] for item in cases], settings, *here)
        told[left], found[left] = here
        left = left[told[left, 0] == _LEFT_GAP]


def cases_of(
    model: TurnModel,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None,
    stiffness: ArrayLike | None,
    preload: ArrayLike | None,
) -> list[FloatArray]:
    """Speeds [rad/s], restitutions, spring rates and deflections of n cases."""
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


@cache
def _compiled() -> tuple[Callable[..., Any], FloatArray]:
    """The compiled function of a batch and its grids; numba is loaded here."""
    require("study", "numba", what="the reduced engine")
    from ..kernels.grids import grids
    from ..kernels.turn_quantities import run_turns

    return run_turns, grids()
