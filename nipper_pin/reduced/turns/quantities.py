"""Quantities of the turns of many cases of one mechanism, computed in compiled code."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import FloatArray
from ...errors import InputError
from ...extras import require
from ...mechanism import Mechanism
from ...units import S_PER_MIN
from ..inputs import check_run, column, spring_rows
from ..kernels import turn_layout as rows
from ..results import ENGINE
from .model import START_INDEX, TurnModel
from .results import TurnStatus
from .turn import BESIDE, ROOMS, STRETCHES, scratch, turn_model, wider

_LEFT_GAP = int(TurnStatus.LEFT_GAP)


class _Column:
    """A quantity of a turn, read by its name."""

    def __init__(self, place: int) -> None:
        self._place = place

    def __get__(self, result: TurnQuantities, kind: type) -> FloatArray:
        return np.asarray(result.table[..., self._place])


@dataclass(frozen=True, eq=False)
class TurnQuantities:
    """Quantities of the last turn or turns that were followed, of n cases; NaN where there is none.

    A turn that repeats an earlier one stands for all that follow it. The clamping stop is the
    transition stop; travels are those of the cylinder from the start of the turn.

    Attributes:
        model: Name of the model.
        stops: Names of the stops.
        status: :class:`TurnStatus` of each case, shape (n,).
        turns: Turns that were followed, shape (n,).
        repeats_after: After how many turns the last one repeats an earlier one, 0 where it does
            not, shape (n,).
        speed: Cylinder speeds, shape (n,) [rad/s].
        table: All quantities, shape (n, columns), or (n, last, columns) with more than one turn.
        engine: The engine that computed them.
    """

    model: str
    stops: tuple[str, ...]
    status: NDArray[np.int64]
    turns: NDArray[np.int64]
    repeats_after: NDArray[np.int64]
    speed: FloatArray
    table: FloatArray = field(repr=False)
    engine: str = ENGINE

    closed_at = _Column(rows.CLOSED_AT)
    """Travel to the first collision of the clamping stop [rad]."""
    closed_error = _Column(rows.CLOSED_ERROR)
    """Bound on the error of that; so are the others called."""
    rests_at = _Column(rows.RESTS_AT)
    """Travel to its first rest [rad]; NaN where it does not settle."""
    rests_error = _Column(rows.RESTS_ERROR)
    lost_at = _Column(rows.LOST_AT)
    """Travel to where its force falls to zero [rad]; NaN where that does not happen."""
    lost_error = _Column(rows.LOST_ERROR)
    opened_at = _Column(rows.OPENED_AT)
    """Travel to where another stop throws it open [rad]; NaN where none does."""
    opened_error = _Column(rows.OPENED_ERROR)
    clamped = _Column(rows.CLAMPED)
    """Travel with the stop closed and its force above the given one [rad]."""
    clamped_error = _Column(rows.CLAMPED_ERROR)
    least_force = _Column(rows.LEAST_FORCE)
    """Smallest force while it is closed [N]; along the joint of a stop without a contact point."""
    most_force = _Column(rows.MOST_FORCE)
    """Largest force while it is closed [N]."""
    force_error = _Column(rows.FORCE_ERROR)
    """Bound on the errors of both [N]; the next two are those of each."""
    least_force_error = _Column(rows.LEAST_ERROR)
    most_force_error = _Column(rows.LARGEST_ERROR)
    largest_gap = _Column(rows.LARGEST_GAP)
    """Largest gap of rebounds that end at the same stop [rad or m]; NaN without one."""
    gap_error = _Column(rows.GAP_ERROR)
    """Bound on the error of that."""
    energy_lost = _Column(rows.LOST_ENERGY)
    """Kinetic energy lost in all collisions [J], those of a series beyond the last too."""
    energy_lost_error = _Column(rows.LOSS_ERROR)

    @property
    def clamped_time(self) -> FloatArray:
        """Time of the turn with the clamping stop closed and its force above the given one [s]."""
        return np.asarray((self.clamped.T / self.speed).T)

    @property
    def clamped_time_error(self) -> FloatArray:
        """Bound on the error of that [s]."""
        return np.asarray((self.clamped_error.T / self.speed).T)

    @property
    def clamped_share(self) -> FloatArray:
        """The same by the time of a turn."""
        return self.clamped / math.tau

    @property
    def collisions(self) -> FloatArray:
        """Collisions of each stop that were computed, shape (n, stops)."""
        return self._of_stops(rows.COUNT)

    @property
    def impulse_sum(self) -> FloatArray:
        """Sum of normal impulses, those of a series beyond the last too, shape (n, stops)."""
        return self._of_stops(rows.IMPULSE_SUM)

    @property
    def impulse_sum_error(self) -> FloatArray:
        """Bound on the errors of the sums."""
        return self._of_stops(rows.SUM_ERROR)

    @property
    def largest_impulse(self) -> FloatArray:
        """Largest of the impulses, shape (n, stops) [N s or N m s]."""
        return self._of_stops(rows.IMPULSE_MOST)

    @property
    def largest_impulse_error(self) -> FloatArray:
        """Bound on the errors of those."""
        return self._of_stops(rows.MOST_ERROR)

    def _of_stops(self, place: int) -> FloatArray:
        return np.asarray(self.table[..., rows.TURN_NUMBERS + place :: rows.PER_STOP])


def turn_quantities(
    mechanism: Mechanism,
    *,
    speed_rpm: ArrayLike,
    turns: int = 1,
    start_index: float = START_INDEX,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    least_force: float = 0.0,
    last: int | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
) -> TurnQuantities:
    """Follow turns of many cases; a case is the same to the last bit alone.

    Args:
        mechanism: The mechanism.
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so are all the others.
        turns: Largest number of turns of a case; fewer where they repeat.
        start_index: Index at which turns start, in the initial phase.
        restitution: e_N of the transition stop, or of stops by name; by default the mechanism's.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        least_force: Force above which the clamping stop clamps [N].
        last: How many turns to report, from the last one backwards; None for the last one alone.
        rest_rate: None: series end at their limit. A number: rest at the first slower rebound.
        tolerance: Relative accuracy of flights and of limits.
        max_collisions: Largest number of collisions of a series of bounces, and per turn.

    Returns:
        The quantities; cases that could not be followed are marked by their status.

    Raises:
        InputError: A parameter is out of range, or the mechanism cannot be reduced.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    check_run(rest_rate, tolerance, max_collisions)
    _check_counts(turns, 1 if last is None else last)
    settings = _Settings(turns, least_force, rest_rate or 0.0, tolerance, max_collisions)
    model = turn_model(mechanism, start_index)
    cases = _cases(model, speed_rpm, restitution, stiffness, preload)
    n = len(cases[0])
    told = np.zeros((n, 3), dtype=np.int64)
    found = np.empty((n, last or 1, rows.TURN_NUMBERS + rows.PER_STOP * len(model.stops)))
    left = np.arange(n)
    for room in ROOMS:
        wide = wider(mechanism, start_index, room)
        if wide is None:
            break
        model = wide
        here = told[left], found[left]
        _run(model, [item[left] for item in cases], settings, *here)
        told[left], found[left] = here
        left = left[told[left, 0] == _LEFT_GAP]
        if not len(left):
            break
    status, followed, again = told.T.copy()
    table = found[:, 0] if last is None else found
    return TurnQuantities(model.name, model.stops, status, followed, again, cases[0], table)


def _check_counts(turns: int, last: int) -> None:
    """Refuse less than one turn."""
    for key, value in (("turns", turns), ("last", last)):
        if value < 1:
            message = f"{key} = {value!r} cannot be used: a whole number from 1"
            raise InputError(message, key=key, value=value)


@dataclass(frozen=True)
class _Settings:
    """What all cases of a batch share."""

    turns: int
    least_force: float
    rest_rate: float
    tolerance: float
    most: int


def _run(
    model: TurnModel,
    cases: list[FloatArray],
    settings: _Settings,
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


def _cases(
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
