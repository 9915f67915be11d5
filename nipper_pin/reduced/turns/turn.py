"""Whole turns of a mechanism by the reduced engine."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import FloatArray
from ...errors import SimulationError
from ...given import number
from ...made_once import made_once
from ...mechanism import Mechanism
from ..kernels.layout import LEFT_GAP, Cases
from ..transition import kernel
from .cases import Run, one_turn_case, run_of
from .model import START_INDEX, TurnModel, build_turns
from .results import TURN_REASONS, ReducedTurns, TurnStatus

GAP_SCALES = (1.0, 2.0, 4.0, 8.0, 32.0, 128.0)


def turn_model(
    mechanism: Mechanism, start_index: float = START_INDEX, gap_scale: float = 1.0
) -> TurnModel:
    """Return the model of a mechanism's turns, sampled at the first call.

    Args:
        start_index: Index at which turns start.
        gap_scale: Factor on the gaps that the tables cover.

    Raises:
        InputError: The mechanism cannot be reduced.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    return _model(mechanism, start_index, gap_scale)


@made_once
def _model(mechanism: Mechanism, start_index: float, gap_scale: float) -> TurnModel:
    return build_turns(mechanism, start_index=start_index, gap_scale=gap_scale)


def wider(mechanism: Mechanism, start_index: float, gap_scale: float) -> TurnModel | None:
    """The model of that scale; None where no tables can be made that are wider than the usual."""
    try:
        return turn_model(mechanism, start_index, gap_scale)
    except SimulationError:
        if gap_scale == GAP_SCALES[0]:
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

    Tables of wider gaps are made where flights leave those of the usual one.

    Args:
        cycles: Number of turns; fewer are computed once they repeat.

    All others are those of :func:`~.quantities.turn_quantities`, for one case.

    Raises:
        InputError: A parameter is out of range, or the mechanism cannot be reduced.
        SimulationError: The turns cannot be followed; the reason says why.
    """
    run = run_of("cycles", cycles, rest_rate, tolerance, max_collisions)
    start_index = number("start_index", start_index)
    told, nothing = np.zeros((1, 4), dtype=np.int64), np.empty((1, 0, 0))
    for gap_scale in GAP_SCALES:
        model = wider(mechanism, start_index, gap_scale)
        if model is None:
            break
        cases = one_turn_case(model, speed_rpm, restitution, stiffness, preload)
        events = run.events()
        follow(run, model, cases, events, told, nothing)
        if told[0, 0] != LEFT_GAP:
            break
    status, done, again, count = told[0].tolist()
    if status:
        name = TurnStatus(status).name
        reason = TURN_REASONS[TurnStatus(status)]
        message = f"{mechanism.name} at {speed_rpm:g} r/min: {reason}; use the direct engine"
        raise SimulationError(message, status=name, speed_rpm=speed_rpm)
    stops = tuple(stop.name for stop in mechanism.stops)
    return ReducedTurns(mechanism.name, stops, done, again, events[0, :count].copy())


def follow(
    run: Run, model: TurnModel, cases: Cases, events: FloatArray, told: NDArray[np.int64],
    found: FloatArray,
) -> None:  # fmt: skip
    """Follow turns of cases on one model."""
    solve, grids = kernel()
    job = (*run.of(model),)
    solve(grids, (*model.charts,), (*cases,), (*run.settings,), job, events, told, found)
