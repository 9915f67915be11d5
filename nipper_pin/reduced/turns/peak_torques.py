"""Largest torques of the drives in the turns of many cases, computed in compiled code.

They cost about as much as the turns themselves, so they are computed where they are asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import FloatArray
from ...extras import require
from ...given import number
from ...mechanism import Mechanism
from ..inputs import check_run
from ..kernels import turn_layout as rows
from ..results import ENGINE
from .batch import widening
from .cases import BESIDE, check_size, room_for, turn_cases
from .model import START_INDEX, TurnModel
from .torques import torque_model
from .turn import STRETCHES, scratch, turn_model

# Panels of a turn that there is room for, by its collisions and other events.
_PANELS = 2


@dataclass(frozen=True, eq=False)
class TurnTorques:
    """Largest torques of the last turn or turns that were followed, of n cases.

    Between events: a collision changes the speed of held drives by an impulse, which is no torque.

    Attributes:
        model: Name of the model.
        drives: Names of the drives.
        status: :class:`TurnStatus` of each case, shape (n,).
        largest: Largest magnitudes, shape (n, drives), or (n, last, drives) with more than one
            turn [N m; N of a drive along a slide]; NaN without a turn.
        error: Bounds on their errors, likewise.
        engine: The engine that computed them.
    """

    model: str
    drives: tuple[str, ...]
    status: NDArray[np.int64]
    largest: FloatArray = field(repr=False)
    error: FloatArray = field(repr=False)
    engine: str = ENGINE


def turn_torques(
    mechanism: Mechanism,
    *,
    speed_rpm: ArrayLike,
    turns: int = 1,
    start_index: float = START_INDEX,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    last: int | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
) -> TurnTorques:
    """Largest torque of each drive in the turns of many cases.

    Arguments are those of :func:`~.quantities.turn_quantities`.

    Returns:
        The torques; cases that could not be followed are marked by their status.

    Raises:
        InputError: A parameter is out of range, or the mechanism cannot be reduced.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    check_run(rest_rate, tolerance, max_collisions)
    check_size("turns", turns, max_collisions)
    start_index = number("start_index", start_index)
    numbers = turn_cases(turn_model(mechanism, start_index), speed_rpm, restitution, stiffness,
                         preload)  # fmt: skip
    n = len(numbers[0])
    drives = tuple(item.name for item in mechanism.drives)
    told = np.zeros((n, 1), dtype=np.int64)
    found = room_for(n, last, 2 * len(drives)).reshape(n, -1, 2, len(drives))
    run = _Run(mechanism, turns, rest_rate or 0.0, tolerance, max_collisions)
    widening(mechanism, start_index, numbers, told, found, run.on)
    table = found[:, 0] if last is None else found
    return TurnTorques(mechanism.name, drives, told[:, 0], table[..., 0, :], table[..., 1, :])


@dataclass(frozen=True)
class _Run:
    """What all cases of a batch share."""

    mechanism: Mechanism
    turns: int
    rest_rate: float
    tolerance: float
    most: int

    def on(
        self,
        model: TurnModel,
        room: float,
        cases: list[FloatArray],
        told: NDArray[np.int64],
        found: FloatArray,
    ) -> None:
        """Follow cases on the tables with a room, and write their status and torques."""
        torques = torque_model(self.mechanism, model, room)
        run_torques, grids = _compiled()
        events = self.most + BESIDE
        run_torques(
            grids,
            model.charts,
            scratch(model.charts, self.most),
            scratch(model.charts, self.most, _PANELS * events),
            torques.charts,
            scratch(torques.charts),
            *cases,
            np.ones(len(told)),
            self.rest_rate,
            self.tolerance,
            self.turns,
            model.begin,
            model.clamp,
            np.empty((self.turns * events, rows.EVENT_COLUMNS)),
            np.empty((self.turns * STRETCHES, rows.HOLD_COLUMNS)),
            np.empty((self.turns + 1, rows.END_COLUMNS)),
            np.empty((2, rows.END_COLUMNS)),
            told[:, 0],
            found,
        )


@cache
def _compiled() -> tuple[Callable[..., Any], FloatArray]:
    """The compiled function of a batch and its grids; numba is loaded here."""
    require("study", "numba", what="the reduced engine")
    from ..kernels.grids import grids
    from ..kernels.turn_torques import run_torques

    return run_torques, grids()
