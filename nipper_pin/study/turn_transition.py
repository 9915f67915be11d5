"""The transition of a turn that the reduced engine follows, where the premise does not hold."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..errors import SimulationError
from ..hybrid import Outcome
from ..mechanism import INDEX_PER_TURN, Mechanism
from ..reduced.kernels import layout as rows
from ..reduced.results import CollisionRows
from ..reduced.turns import ReducedTurns, TurnModel, turn_model, turns
from ..tolerances.hybrid import REST_BEFORE_TOUCH
from ..units import S_PER_MIN
from .cases import Settings

# Turns start this part of the scale before the touch, in the initial phase; the third one from the
# touch is read, as by the direct engine, and one more holds the end of it.
_BEFORE = 1.0
_READ = 3
_MOST_COLLISIONS = 1000
_TURN = math.tau


@dataclass(frozen=True, eq=False)
class TurnTransition(CollisionRows):
    """A transition of a turn; the rows have shape (collisions,).

    The rebound that a series of bounces leaves out at its limit is NaN.

    Attributes:
        premise_holds: False if the machine does not arrive at the next touch in its initial phase;
            None where the turns do not tell.
        repeats: Whether the turn equals the one before it.
        outcome: How it ended.
        duration: Time from the first collision to rest [s]; NaN without rest.
        duration_error: Bound on its error [s].
        share: Share of the first two rebounds in the duration; NaN with fewer.
        message: What is to be known of it.
        table: All rows, shape (rows, collisions).
    """

    premise_holds: bool | None
    repeats: bool
    outcome: Outcome
    duration: float
    duration_error: float
    share: float
    message: str
    table: FloatArray = field(repr=False)


def touch_turns(mechanism: Mechanism) -> TurnModel:
    """The model of turns that start a little before the touch, sampled at the first call.

    Raises:
        InputError: The mechanism cannot be reduced.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    return turn_model(mechanism, _start(mechanism))


def turn_transition(
    mechanism: Mechanism,
    *,
    speed_rpm: float,
    restitution: float,
    stiffness: FloatArray,
    preload: FloatArray,
    settings: Settings,
) -> TurnTransition:
    """Follow turns from the initial phase and read the transition of the third one.

    Args:
        restitution: e_N of the transition stop.
        stiffness: Spring rates, shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        settings: Of all cases; drives are held.

    Raises:
        InputError: The mechanism cannot be reduced.
        SimulationError: The turns cannot be followed, or do not start at the touch; with evidence
            ``status`` where that is so of this case alone.
    """
    found = turns(
        mechanism,
        speed_rpm=speed_rpm,
        cycles=_READ + 1,
        start_index=_start(mechanism),
        restitution=restitution,
        stiffness=stiffness,
        preload=preload,
        rest_rate=settings.rest_rate,
        tolerance=settings.tolerance,
        max_collisions=max(settings.max_collisions, _MOST_COLLISIONS),
    )
    events = _going_on(found, S_PER_MIN / speed_rpm)
    clamp = found.stops.index(mechanism.transition_stop)
    travel = events[:, rows.TRAVEL] - _BEFORE * _TURN / INDEX_PER_TURN
    hit = (events[:, rows.KIND] == rows.COLLISION) & (events[:, rows.STOP] == clamp)
    if not (len(events) and hit[0] and _near(travel[0], 0.0)):
        message = f"{mechanism.name}: the machine does not stay in its initial phase to the touch"
        raise SimulationError(message, status="OTHER_START", speed_rpm=speed_rpm)
    known = _holds(travel[hit])
    later = np.flatnonzero(hit & (travel >= (_READ - 1.5) * _TURN) & (travel < _READ * _TURN))
    if not len(later):
        message = f"{mechanism.name}: no turn has a collision of stop {mechanism.transition_stop!r}"
        raise SimulationError(message, status="NO_COLLISION", speed_rpm=speed_rpm)
    first = int(later[0])
    places, rest = _series(events, travel, clamp, first)
    table = _rows(mechanism, events[places], travel[places] - (_READ - 1) * _TURN)
    if np.isnan(table[rows.AMPLITUDE, :2]).any():
        message = f"{mechanism.name}: one of the first two rebounds is not followed to its end"
        raise SimulationError(message, status="LEFT_OUT", speed_rpm=speed_rpm)
    ends = None if rest is None else (events[first], events[rest])
    return _ended(table, ends, known, found.repeats_after == 1, settings.max_collisions)


def _start(mechanism: Mechanism) -> float:
    cylinder = mechanism.cylinder
    return cylinder.index_from_angle(cylinder.angle_at_touch_rad) - _BEFORE


def _near(travel: float, place: float) -> bool:
    return abs(travel - place) <= REST_BEFORE_TOUCH * _TURN


def _holds(hits: FloatArray) -> bool | None:
    """False if the stop does not close one turn later where it closes in the initial phase."""
    return None if any(_near(travel, _TURN) for travel in hits) else False


def _going_on(found: ReducedTurns, period: float) -> FloatArray:
    """Events of all turns that are read; those after a turn that repeats are copies."""
    table, done, back = found.table.T, found.turns, found.repeats_after
    number = np.floor(table[:, rows.TRAVEL] / _TURN).astype(int)
    parts = [table]
    for turn in range(done, _READ + 1):
        copied = done - back + (turn - done) % back
        part = table[number == copied].copy()
        part[:, rows.TRAVEL] += _TURN * (turn - copied)
        part[:, rows.TIME] += period * (turn - copied)
        parts.append(part)
    return np.concatenate(parts)


def _series(
    events: FloatArray, travel: FloatArray, clamp: int, first: int
) -> tuple[list[int], int | None]:
    """Collisions from the first one to rest, and the rest; without one all of the turn."""
    own = np.flatnonzero((events[:, rows.STOP] == clamp) & (travel < _READ * _TURN))
    before = own[own < first]
    fresh = not len(before) or events[before[-1], rows.KIND] != rows.COLLISION
    hits: list[int] = []
    for place in own[own >= first]:
        kind = events[place, rows.KIND]
        if fresh and kind == rows.REST:
            return hits, int(place)
        if kind == rows.COLLISION:
            hits.append(int(place))
        else:
            fresh = False
    return hits, None


def _rows(mechanism: Mechanism, hits: FloatArray, travel: FloatArray) -> FloatArray:
    """Collisions as rows; travels count from the touch of their turn."""
    found, cylinder = hits.T.copy(), mechanism.cylinder
    late = float(hits[0, rows.TIME_ERROR])
    found[rows.TIME] -= hits[0, rows.TIME]
    found[rows.TIME_ERROR, 1:] += late
    found[rows.ANGLE] = cylinder.angle_at_touch_rad + cylinder.sense * travel
    still = found[rows.SEPARATION] <= 0.0
    for row in (rows.AMPLITUDE, rows.REBOUND, rows.AMPLITUDE_ERROR, rows.REBOUND_ERROR):
        found[row, still] = 0.0
    return found


def _ended(
    table: FloatArray,
    ends: tuple[FloatArray, FloatArray] | None,
    known: bool | None,
    repeats: bool,
    most: int,
) -> TurnTransition:
    """The transition of a turn, with its first collision and its rest if it has one."""
    outcome, share = Outcome.NO_REST, math.nan
    duration = error = math.nan
    if table.shape[1] > most:
        outcome, table = Outcome.TOO_MANY_COLLISIONS, table[:, :most]
    elif ends is not None:
        first, rest = ends
        outcome = Outcome.AT_REST
        duration = float(rest[rows.TIME] - first[rows.TIME])
        error = float(rest[rows.TIME_ERROR] + first[rows.TIME_ERROR])
        if table.shape[1] > 2 and duration > 0.0:
            share = float(table[rows.TIME, 2]) / duration
    message = "This is the transition of the turn."
    if not repeats:
        message += f" Turns differ from one another; it is that of number {_READ}."
    return TurnTransition(known, repeats, outcome, duration, error, share, message, table)
