"""Quantities of the turns of many cases of one mechanism, computed in compiled code.

Many cases are computed on the narrowest tables that hold each.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import FloatArray
from ...hybrid import START_INDEX
from ...mechanism import Mechanism
from ..kernels import layout as rows
from ..results import ENGINE, Column, TurnStatus
from .cases import room_for, run_of, turn_cases
from .peak_torques import peak_torques
from .turn import follow, turn_model, widening


def _of_stops(place: int) -> Column:
    """A quantity of each stop."""
    return Column(slice(rows.TURN_NUMBERS + place, None, rows.PER_STOP))


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
        drives: Names of the drives whose torques were asked for.
        torques: Those, shape (n, 2, drives), or (n, last, 2, drives).
        engine: The engine that computed them.
    """

    model: str
    stops: tuple[str, ...]
    status: NDArray[np.int64]
    turns: NDArray[np.int64]
    repeats_after: NDArray[np.int64]
    speed: FloatArray
    table: FloatArray = field(repr=False)
    drives: tuple[str, ...]
    torques: FloatArray = field(repr=False)
    engine: str = ENGINE

    closed_at = Column(rows.CLOSED_AT)
    """Travel to the first collision of the clamping stop [rad]."""
    closed_at_error = Column(rows.CLOSED_ERROR)
    """Bound on the error of that; so are the others called."""
    rests_at = Column(rows.RESTS_AT)
    """Travel to its first rest [rad]; NaN where it does not settle."""
    rests_at_error = Column(rows.RESTS_ERROR)
    lost_at = Column(rows.LOST_AT)
    """Travel to where its force falls to zero [rad]; NaN where that does not happen."""
    lost_at_error = Column(rows.LOST_ERROR)
    opened_at = Column(rows.OPENED_AT)
    """Travel to where another stop throws it open [rad]; NaN where none does."""
    opened_at_error = Column(rows.OPENED_ERROR)
    clamped = Column(rows.CLAMPED)
    """Travel with the stop closed and its force above the given one [rad]."""
    clamped_error = Column(rows.CLAMPED_ERROR)
    least_clamping_force = Column(rows.LEAST_FORCE)
    """Smallest force while it is closed [N]; along the joint of a stop without a contact point."""
    largest_clamping_force = Column(rows.MOST_FORCE)
    """Largest force while it is closed [N]."""
    clamping_force_error = Column(rows.FORCE_ERROR)
    """Bound on the errors of both [N]; the next two are those of each."""
    least_clamping_force_error = Column(rows.LEAST_ERROR)
    largest_clamping_force_error = Column(rows.LARGEST_ERROR)
    largest_gap = Column(rows.LARGEST_GAP)
    """Largest gap of rebounds that end at the same stop [rad or m]; NaN without one."""
    largest_gap_error = Column(rows.GAP_ERROR)
    """Bound on the error of that."""
    energy_lost = Column(rows.LOST_ENERGY)
    """Kinetic energy lost in all collisions [J], those of a series beyond the last too."""
    energy_lost_error = Column(rows.LOSS_ERROR)
    collisions = _of_stops(rows.COUNT)
    """Collisions of each stop that were computed, shape (n, stops)."""
    impulse_sum = _of_stops(rows.IMPULSE_SUM)
    """Sum of normal impulses, those of a series beyond the last too, shape (n, stops)."""
    impulse_sum_error = _of_stops(rows.SUM_ERROR)
    largest_impulse = _of_stops(rows.IMPULSE_MOST)
    """Largest of the impulses, shape (n, stops) [N s or N m s]."""
    largest_impulse_error = _of_stops(rows.MOST_ERROR)
    largest_torque = Column(0, slice(None), table="torques")
    """Largest magnitude of a torque between events, shape (n, drives) [N m or N]."""
    largest_torque_error = Column(1, slice(None), table="torques")

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
    torques: bool = False,
    last: int | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
) -> TurnQuantities:
    """Follow turns of many cases; a case is the same to the last bit alone.

    Args:
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so are all the others.
        turns: Largest number of turns of a case; fewer where they repeat.
        start_index: Index at which turns start, in the initial phase.
        restitution: e_N of the transition stop, or of stops by name; by default the mechanism's.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        least_force: Force above which the clamping stop clamps [N].
        torques: Whether to compute the torques of the drives.
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
    run = run_of("turns", turns, rest_rate, tolerance, max_collisions, least_force)
    model = turn_model(mechanism, start_index)
    cases = turn_cases(model, speed_rpm, restitution, stiffness, preload)
    n = len(cases)
    told = np.zeros((n, 4), dtype=np.int64)
    table = room_for(n, last, rows.TURN_NUMBERS + rows.PER_STOP * len(model.stops))
    widening(mechanism, start_index, cases, told, table, partial(follow, run, run.events()))
    status, followed, again, _ = told.T.copy()
    drives = tuple(item.name for item in mechanism.drives) if torques else ()
    largest = np.empty((n, last or 1, 2, 0))
    if torques:
        of_torques, largest = peak_torques(mechanism, model.start_index, run, cases, last)
        status = np.where(status == TurnStatus.FOLLOWED, of_torques, status)
    if last is None:
        table, largest = table[:, 0], largest[:, 0]
    return TurnQuantities(
        model.name, model.stops, status, followed, again, cases[:, 0].copy(), table, drives, largest
    )
