"""Whole turns of a mechanism by the reduced engine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import FloatArray
from ...errors import SimulationError
from ...given import number
from ...hybrid import START_INDEX
from ...made_once import made_once
from ...mechanism import Mechanism
from ..kernels.layout import LEFT_GAP
from ..results import TURN_REASONS, ReducedTurns, TurnStatus
from ..transition import kernel
from .cases import Run, run_of, turn_cases
from .model import TurnModel, build_turns

GAP_SCALES = (1.0, 2.0, 4.0, 8.0, 32.0, 128.0)
_model = made_once(build_turns)


def turn_model(
    mechanism: Mechanism, start_index: float = START_INDEX, gap_scale: float = 1.0
) -> TurnModel:
    """Return the model of a mechanism's turns, sampled at the first call.

    Arguments and errors are those of :func:`~.model.build_turns`; an index that is no finite number
    is refused, too.
    """
    return _model(mechanism, number("start_index", start_index), gap_scale)


def widening(
    mechanism: Mechanism,
    start_index: float,
    cases: FloatArray,
    told: NDArray[np.int64],
    found: FloatArray,
    run: Callable[[TurnModel, float, FloatArray, NDArray[np.int64], FloatArray], None],
) -> None:
    """Run cases, those that leave the tables of a model on the next wider one, if there is one.

    Args:
        told: Written by ``run``: the status first, shape (n, numbers).
        found: Written by it, shape (n, ...).
        run: Follows some of the cases on the tables of a scale of gaps.
    """
    run(turn_model(mechanism, start_index), GAP_SCALES[0], cases, told, found)
    for gap_scale in GAP_SCALES[1:]:
        left = np.flatnonzero(told[:, 0] == LEFT_GAP)
        if not len(left):
            return
        some, here = cases[left], (told[left], found[left])
        try:
            run(turn_model(mechanism, start_index, gap_scale), gap_scale, some, *here)
        except SimulationError:
            # There are no tables that wide, or none of what is asked for beside them.
            return
        told[left], found[left] = here


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
    told, nothing = np.zeros((1, 4), dtype=np.int64), np.empty((1, 0, 0))
    model = turn_model(mechanism, start_index)
    cases = turn_cases(model, speed_rpm, restitution, stiffness, preload, one=True)
    events = run.events()
    widening(mechanism, start_index, cases, told, nothing, partial(follow, run, events))
    status, done, again, count = told[0].tolist()
    if status:
        name = TurnStatus(status).name
        reason = TURN_REASONS[TurnStatus(status)]
        message = f"{mechanism.name} at {speed_rpm:g} r/min: {reason}; use the direct engine"
        raise SimulationError(message, status=name, speed_rpm=speed_rpm)
    return ReducedTurns(model.name, model.stops, done, again, events[0, :count].T.copy())


def follow(
    run: Run, events: FloatArray, model: TurnModel, _gap_scale: float, cases: FloatArray,
    told: NDArray[np.int64], found: FloatArray,
) -> None:  # fmt: skip
    """Follow turns of cases on one model."""
    solve, grids = kernel()
    job = (*run.of(model),)
    solve(grids, (*model.charts,), cases, (*run.settings,), job, events, told, found)
