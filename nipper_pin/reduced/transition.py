"""Transitions of a reduced model: one, or a batch of them as arrays."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..errors import InputError, SimulationError
from ..extras import require
from .inputs import cases_of, checked_run
from .kernels import layout
from .kernels.layout import Job, Settings
from .model import ReducedModel
from .results import REASONS, ReducedTransition, Status, TransitionBatch

_AT_REST, _TOO_MANY = int(Status.AT_REST), int(Status.TOO_MANY_COLLISIONS)
_TRANSITIONS, _ARRIVALS = int(layout.TRANSITIONS), int(layout.ARRIVALS)
# What the job of a transition has between its collisions and the touch.
_NO_TURNS = Job(0, 0)[2:-2]
_NOTHING_TOLD = np.array([layout.GOES_ON, 0, layout.NOT_ASKED])
# Bounces of the waiting stop that are followed on the way to the touch.
_MOST_BOUNCES = 64
# Collisions that nearly all transitions have less of.
_USUAL = 32
_ENGINE = "the reduced engine"


def transition(
    model: ReducedModel,
    *,
    speed_rpm: float,
    restitution: float | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
    assumed: bool = True,
) -> ReducedTransition:
    """Solve one transition.

    Args:
        restitution: e_N of the transition stop; by default that of the mechanism.
        stiffness: Spring rates, one number or shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        rest_rate: None: the limit of the series. A number: rest at the first slower rebound.
        tolerance: Relative accuracy of flights and of the limit.
        max_collisions: Largest number of collisions.
        assumed: Whether the transition starts in the initial phase even if the machine does not
            arrive so; else it is then that of the turn.

    Returns:
        The transition.

    Raises:
        InputError: A parameter is out of range, or the case leaves the domain of the model.
        SimulationError: The stop does not come to rest, or another stop takes part; or the
            tables do not determine how the machine arrives at the transition of the turn.
    """
    settings = checked_run(rest_rate, tolerance, max_collisions)
    stop = model.charts.stops[0, layout.OWN]
    e_N = {} if restitution is None else {stop: ("restitution", restitution)}
    cases = cases_of(model, speed_rpm, e_N, stiffness, preload, one=True)
    # Few transitions need the room for all collisions, which takes time to clear.
    for most in (_USUAL, max_collisions) if max_collisions > _USUAL else (max_collisions,):
        table, told, tell = _solved(model, cases, settings, assumed, most)
        status, count, _ = told[0].tolist()
        if status != _TOO_MANY:
            break
    if status != _AT_REST:
        name = Status(status).name
        reason = REASONS[Status(status)].format(
            travel=model.travel_rad,
            gap=model.gap_max,
            most=max_collisions,
            why=model.arrival.why or "its flight before the touch leaves them",
        )
        message = f"{model.name} at {speed_rpm:g} r/min, after {count} collisions: {reason}"
        outside = status in (Status.LEFT_TRAVEL, Status.LEFT_GAP)
        kind = InputError if outside else SimulationError
        raise kind(message, status=name, collisions=count, speed_rpm=speed_rpm)
    return ReducedTransition(model.name, table[0, -1], table[0, :count].T, tell, count)


def transitions(
    model: ReducedModel,
    *,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 32,
    assumed: bool = True,
) -> TransitionBatch:
    """Solve many transitions in compiled code; a case is the same to the last bit alone.

    Args:
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so are all the others.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        max_collisions: Largest number of collisions of a case, and columns of the tables.
        assumed: Whether transitions start in the initial phase even if the machine does not arrive
            so; else they are then those of the turn, and cases whose arrival the tables cannot
            tell are marked ``UNTOLD``.

    All others are those of :func:`transition`.

    Returns:
        The batch; cases that did not come to rest are marked by their status.

    Raises:
        InputError: A parameter is out of range, or numba is not installed.
    """
    stop = model.charts.stops[0, layout.OWN]
    e_N = {} if restitution is None else {stop: ("restitution", restitution)}
    cases = cases_of(model, speed_rpm, e_N, stiffness, preload)
    require("study", "numba", what=_ENGINE)
    settings = checked_run(rest_rate, tolerance, max_collisions)
    table, told, tell = _solved(model, cases, settings, assumed, max_collisions)
    status, counts, _ = told.T.copy()
    rows = table[:, :max_collisions].swapaxes(1, 2)
    return TransitionBatch(model.name, table[:, -1], rows, tell, status, counts)


@cache
def kernel() -> tuple[Callable[..., None], FloatArray]:
    """The compiled function and its grids; numba is loaded here."""
    require("study", "numba", what=_ENGINE)
    from .kernels.kernel import run
    from .kernels.panel import grids

    return run, grids()


def _run(
    model: ReducedModel, cases: FloatArray, settings: Settings, table: FloatArray,
    told: NDArray[np.int64], *tasks: int,
) -> NDArray[np.int64]:  # fmt: skip
    """Do what is asked, in its order; returns what is known of the premise.

    Args:
        table: Written: the events of transitions, as of :func:`~.kernels.kernel.run`.
        told: Written, likewise.
        tasks: TRANSITIONS, and ARRIVALS where the premise is not known yet.
    """
    run, grids = kernel()
    for task in tasks:
        charts, events, most = model.charts, table, table.shape[1] - layout.BESIDE
        if task == _ARRIVALS:
            if model.arrival.charts is None:
                told[:, 2] = layout.UNKNOWN
                continue
            charts, most = model.arrival.charts, _MOST_BOUNCES
            events = np.empty((1, 2 * most, layout.COLUMNS))
        job = task, most, *_NO_TURNS, model.touch_angle_rad, float(model.sense)
        run(grids, (*charts,), cases, (*settings,), job, events, told, table)
    return told[:, 2]


def _solved(
    model: ReducedModel, cases: FloatArray, settings: Settings, assumed: bool, most: int
) -> tuple[FloatArray, NDArray[np.int64], partial[NDArray[np.int64]]]:
    """Transitions of checked cases: what is written by :func:`_run`, and what tells the premise."""
    n = len(cases)
    table = np.empty((n, most + layout.BESIDE, layout.COLUMNS))
    told = np.empty((n, 3), dtype=np.int64)
    told[:] = _NOTHING_TOLD
    found = partial(_run, model, cases, settings, table, told)
    if assumed:
        found(_TRANSITIONS)
        return table, told, partial(found, _ARRIVALS)
    premise = found(_ARRIVALS, _TRANSITIONS, _ARRIVALS)
    lost = (premise == layout.UNKNOWN) & (told[:, 0] == _AT_REST)
    told[lost, :2], table[lost] = (int(Status.UNTOLD), 0), math.nan
    return table, told, found
