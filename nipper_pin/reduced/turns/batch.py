"""Many cases of one mechanism's turns, on the narrowest tables that hold each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import SimulationError
from ...extras import require
from ...mechanism import Mechanism
from ..kernels import turn_layout as rows
from .cases import BESIDE
from .model import TurnModel
from .results import TurnStatus
from .turn import ROOMS, STRETCHES, scratch, wider

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
    settings: Settings,
    model: TurnModel,
    _room: float,
    cases: list[FloatArray],
    told: NDArray[np.int64],
    found: FloatArray,
) -> None:
    """Follow cases on one model."""
    run_turns, grids = _compiled()
    run_turns(
        grids,
        model.charts,
        scratch(model.charts, settings.most),
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
        np.empty((settings.turns + 1, rows.END_COLUMNS)),
        told,
        found,
    )


def widening(
    mechanism: Mechanism,
    start_index: float,
    cases: list[FloatArray],
    told: NDArray[np.int64],
    found: FloatArray,
    run: Callable[[TurnModel, float, list[FloatArray], NDArray[np.int64], FloatArray], None],
) -> None:
    """Run cases, those that leave the tables of a model on the next wider one, if there is one.

    Args:
        start_index: Index at which turns start.
        cases: As of :func:`~.cases.turn_cases`.
        told: Written by ``run``: the status first, shape (n, numbers).
        found: Written by it, shape (n, ...).
        run: Follows some of the cases on the tables with a room.
    """
    left = np.arange(len(told))
    for room in ROOMS:
        model = wider(mechanism, start_index, room) if len(left) else None
        if model is None:
            break
        here = told[left], found[left]
        try:
            run(model, room, [item[left] for item in cases], *here)
        except SimulationError:
            # It needs tables of its own, and there are none that wide.
            if room == ROOMS[0]:
                raise
            break
        told[left], found[left] = here
        left = left[told[left, 0] == _LEFT_GAP]


def follow_all(
    mechanism: Mechanism,
    start_index: float,
    cases: list[FloatArray],
    settings: Settings,
    told: NDArray[np.int64],
    found: FloatArray,
) -> None:
    """Follow cases on tables that are as wide as each needs.

    Args:
        start_index: Index at which turns start.
        cases: As of :func:`~.cases.turn_cases`.
        settings: What all cases share.
        told: Written: status, turns, and after how many the last repeats, shape (n, 3).
        found: Written: quantities of the last turns, shape (n, last, quantities).
    """
    widening(mechanism, start_index, cases, told, found, partial(_run, settings))


@cache
def _compiled() -> tuple[Callable[..., Any], FloatArray]:
    """The compiled function of a batch and its grids; numba is loaded here."""
    require("study", "numba", what="the reduced engine")
    from ..kernels.grids import grids
    from ..kernels.turn_quantities import run_turns

    return run_turns, grids()
