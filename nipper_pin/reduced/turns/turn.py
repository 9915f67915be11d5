"""Whole turns of a mechanism by the reduced engine."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from ...errors import SimulationError
from ...extras import require
from ...given import LARGEST, number
from ...made_once import made_once
from ...mechanism import Mechanism
from ...units import S_PER_MIN
from ..inputs import check_run, one_row, speed_of
from ..kernels.layout import CASE_NUMBERS, LEFT_GAP, LEVELS, SCRATCH_ROWS, SIZES
from ..kernels.turn_layout import END_COLUMNS, EVENT_COLUMNS, HOLD_COLUMNS, Charts, TurnWork
from .cases import BESIDE, by_stop, check_size
from .model import START_INDEX, TurnModel, build_turns
from .results import TURN_REASONS, ReducedTurns, TurnStatus

# Stretches of a turn on which a stop is closed.
STRETCHES = 64
ROOMS = (1.0, 2.0, 4.0, 8.0, 32.0, 128.0)


def turn_model(
    mechanism: Mechanism, start_index: float = START_INDEX, room: float = 1.0
) -> TurnModel:
    """Return the model of a mechanism's turns, sampled at the first call.

    Args:
        start_index: Index at which turns start.
        room: Factor on the gaps that the tables cover.

    Raises:
        InputError: The mechanism cannot be reduced.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    return _model(mechanism, start_index, room)


@made_once
def _model(mechanism: Mechanism, start_index: float, room: float) -> TurnModel:
    return build_turns(mechanism, start_index=start_index, room=room)


def wider(mechanism: Mechanism, start_index: float, room: float) -> TurnModel | None:
    """The model with that room; None where no tables can be made that are wider than the usual."""
    try:
        return turn_model(mechanism, start_index, room)
    except SimulationError:
        if room == ROOMS[0]:
            raise
        return None


def turns(
    mechanism: Mechanism,
    *,
    speed_rpm: float,
    cycles: int = 1,
    start_index: float = START_INDEX,
    restitution: float | Mapping[str, float] | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
) -> ReducedTurns:
    """Follow whole turns from event to event.

    Tables with more room are made where flights leave those of the usual one.

    Args:
        cycles: Number of turns; fewer are computed once they repeat.

    All others are those of :func:`~.quantities.turn_quantities`, for one case.

    Raises:
        InputError: A parameter is out of range, or the mechanism cannot be reduced.
        SimulationError: The turns cannot be followed; the reason says why.
    """
    check_run(rest_rate, tolerance, max_collisions)
    check_size("cycles", cycles, max_collisions)
    start_index = number("start_index", start_index)
    case = _Case(speed_rpm, cycles, restitution, stiffness, preload, rest_rate or 0.0, tolerance,
                 max_collisions)  # fmt: skip
    for room in ROOMS:
        wide = wider(mechanism, start_index, room)
        if wide is None:
            break
        status, found = _followed(wide, case)
        if status != LEFT_GAP:
            break
    if status:
        name = TurnStatus(status).name
        reason = TURN_REASONS[TurnStatus(status)]
        message = f"{mechanism.name} at {speed_rpm:g} r/min: {reason}; use the direct engine"
        raise SimulationError(message, status=name, speed_rpm=speed_rpm)
    return found


@dataclass(frozen=True)
class _Case:
    """Arguments of :func:`turns`."""

    speed_rpm: float
    cycles: int
    restitution: float | Mapping[str, float] | None
    stiffness: ArrayLike | None
    preload: ArrayLike | None
    rest_rate: float
    tolerance: float
    max_collisions: int


def _followed(model: TurnModel, case: _Case) -> tuple[int, ReducedTurns]:
    """Follow the turns of a case on one model; returns the status, too."""
    follow, grids = _compiled()
    speed = speed_of(case.speed_rpm)
    speed *= math.tau / S_PER_MIN
    chart, gap, rate, by_speed, closed = model.begin
    events = np.full((case.cycles * (case.max_collisions + BESIDE), EVENT_COLUMNS), np.nan)
    status, count, _, done, again = follow(
        grids,
        model.charts,
        scratch(model.charts, case.max_collisions),
        speed,
        _restitutions(model, case.restitution),
        one_row("stiffness", case.stiffness, model.stiffness, 0.0),
        one_row("preload", case.preload, model.preload, -LARGEST),
        1.0,
        float(case.rest_rate),
        float(case.tolerance),
        case.cycles,
        (chart, gap, rate + by_speed * speed, closed, 0.0, 0.0),
        model.clamp,
        events,
        np.empty((case.cycles * STRETCHES, HOLD_COLUMNS)),
        np.empty((case.cycles + 1, END_COLUMNS)),
    )
    return status, ReducedTurns(model.name, model.stops, done, again, events[:count].copy())


def _restitutions(model: TurnModel, restitution: float | Mapping[str, float] | None) -> FloatArray:
    """e_N of the stops, shape (K,)."""
    found = model.restitution.copy()
    if restitution is None:
        return found
    for name, value in by_stop(model, restitution).items():
        found[model.stops.index(name)] = number(f"restitution of {name}", value, 0.0, 1.0)
    return found


def scratch(charts: Charts, most: int = 1, panels: int = 0) -> TurnWork:
    """Scratch arrays of a call: no two threads share them.

    Args:
        charts: The functions that are evaluated.
        most: Largest number of collisions of a series.
        panels: Panels of the motion that are kept.
    """
    count, _, cells, count_u, count_x = charts.equation.shape
    rows, finest = (3 + charts.others.shape[1]) * count_x, LEVELS[-1]
    return TurnWork(
        np.zeros((count, CASE_NUMBERS)),
        np.zeros((count, cells, count_u, rows)),
        np.zeros((count, SIZES, 3)),
        np.zeros((count, cells, count_u)),
        np.zeros(count, dtype=np.bool_),
        np.zeros((finest + 1, rows)),
        np.zeros((SCRATCH_ROWS * (1 + panels), finest + 2)),
        np.zeros((3, most)),
    )


@cache
def _compiled() -> tuple[Callable[..., Any], FloatArray]:
    """The compiled function of turns and its grids; numba is loaded here."""
    require("study", "numba", what="the reduced engine")
    from ..kernels.panel import grids
    from ..kernels.turn import follow

    return follow, grids()
