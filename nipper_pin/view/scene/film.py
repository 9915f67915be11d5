"""A solution sampled for a film: where the links stand in each frame, and what is read off.

Rebounds are drawn larger: flights of the transition stop from one collision to the next. The curves
under the picture are gaps and forces of the stops.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics import close_positions, partition
from ...errors import ConvergenceError, InputError, SingularConfigurationError
from ...given import number
from ...hybrid import EventKind, Solution
from ...hybrid.result.quantities import force_unit
from ...mechanism import Mechanism, Stop
from ..reading import contact_shown, coordinate_shown, shown_until
from .pace import Pace, pace

_LONGEST_STRETCH = 1e5
# On rebounds, the largest first.
_FACTORS = (1000.0, 500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0)
# A rebound is drawn no larger than this.
_DRAWN_ANGLE = math.radians(6.0)
_DRAWN_STROKE = 0.03  # of the reach of the mechanism
_SEEN = 0.6  # of these, for the highest rebound where nobody asks for a factor
# Of curves: gap and force of the transition stop, and gaps of others.
_GAP, _FORCE, _OTHER = "#0072B2", "#CC79A7", "#009E73"
# Room above the largest rebound, and curves of other stops.
_ROOM, _OTHERS = 1.15, 2


@dataclass(frozen=True, kw_only=True)
class Look:
    """How a solution is shown.

    Attributes:
        slow: Stretch of time around events, 1 to 1e5 [-]; None: 1000, or less for a run of which
            the film would take more than two minutes.
        exaggerate: Factor on rebounds of the transition stop in the drawing, 1 to 1000 [-]; None:
            a round one by which they are seen.

    Raises:
        InputError: A value is out of range.
    """

    slow: float | None = None
    exaggerate: float | None = None

    def __post_init__(self) -> None:
        """Validate."""
        for key, most in (("slow", _LONGEST_STRETCH), ("exaggerate", _FACTORS[0])):
            value = getattr(self, key)
            if value is not None:
                number(key, value, 1.0, most, allowed=f"1 to {most:g}", where="view")


@dataclass(frozen=True)
class Film:
    """Frames of a solution.

    Attributes:
        larger: Factor on rebounds in the drawing [-].
        pace: Times of the frames on both clocks.
        q: Configurations of the machine, shape (K, nv) [rad or m].
        drawn: Configurations of the drawing; those of the machine unless gaps are exaggerated.
        position: Origins of the links (x, z), shape (K, links, 2) [m].
        angle: Rotation of the links, counter-clockwise, shape (K, links) [rad].
        turned: Rotation of the cylinder since the touch configuration, shape (K,) [rad].
        phase: Place of the frame's phase in ``solution.phases``, shape (K,).
        index: Index on the comber's scale, shape (K,).
        force: By stop: normal force [N] (N m along a hinge without contact), shape (K,).
    """

    solution: Solution
    larger: float
    pace: Pace
    q: FloatArray
    drawn: FloatArray
    position: FloatArray
    angle: FloatArray
    turned: FloatArray
    phase: NDArray[np.intp]
    index: FloatArray
    force: dict[str, FloatArray]


def film(solution: Solution, look: Look, frames: Pace | None = None) -> Film:
    """Sample a solution.

    Args:
        frames: Times of the frames, by default those that suit the solution. Outside of its run the
            machine stands still.

    Raises:
        InputError: The solution has no motion, or its gap cannot be drawn larger.
    """
    if shown_until(solution) <= 0.0:
        message = (
            "the run has no motion to show: the stop comes to rest in its first collision; "
            "use --window cycle or a higher restitution"
        )
        raise InputError(message, outcome=solution.outcome.name)
    mechanism = solution.mechanism
    if frames is None:
        frames = pace(solution, look.slow)
    t = np.clip(frames.machine, 0.0, shown_until(solution))
    motion = solution.trajectory.evaluate(t)
    larger, drawn = _enlarged(solution, t, motion.q, look.exaggerate)
    position, angle = poses(solution, drawn)
    cylinder = mechanism.cylinder
    starts = [item.t_start for item in solution.phases]
    return Film(
        solution=solution,
        larger=larger,
        pace=frames,
        q=motion.q,
        drawn=drawn,
        position=position,
        angle=angle,
        turned=motion.cylinder_angle - cylinder.angle_at_touch_rad,
        phase=np.maximum(np.searchsorted(starts, t, side="right") - 1, 0),
        index=cylinder.indices_from_angles(motion.cylinder_angle),
        force=solution.trajectory.reactions(t).contacts,
    )


def true_size(film: Film) -> Film:
    """The film with its rebounds as they are."""
    position, angle = poses(film.solution, film.q)
    return replace(film, larger=1.0, drawn=film.q, position=position, angle=angle)


@dataclass(frozen=True)
class Flight:
    """A rebound, or the last ones of a series together.

    Attributes:
        begin: Time at which it begins [s].
        end: Time at which the stop is closed again [s].
        highest: Largest gap [rad or m].
    """

    begin: float
    end: float
    highest: float


def rebound_flights(solution: Solution) -> list[Flight]:
    """Flights between a collision of the transition stop and its next one, or its rest.

    The closing before the first collision and the opening after the last are none.
    """
    stop = solution.mechanism.transition_stop
    closes = [
        event
        for event in solution.events
        if stop in event.stops and event.kind in (EventKind.COLLISION, EventKind.REST)
    ]
    own = (hit for hit in solution.collisions if hit.stop == stop)
    heights = {hit.event.number: hit.rebound_amplitude or 0.0 for hit in own}
    return [
        Flight(first.t, second.t, heights.get(first.number, 0.0))
        for first, second in pairwise(closes)
        if first.kind is EventKind.COLLISION
    ]


def highest_drawn(solution: Solution, t: FloatArray, gap: FloatArray) -> float:
    """Largest gap of a rebound in the frames of a film, in the unit of the gaps.

    Args:
        t: Times of the frames [s], shape (K,).
        gap: Gaps of the transition stop there, shape (K,).
    """
    flights = rebound_flights(solution)
    found = (gap[(t >= item.begin) & (t <= item.end)].max(initial=0.0) for item in flights)
    return float(max(found, default=0.0))


def factors(
    solution: Solution, t: FloatArray, gap: FloatArray, factor: float, limit: float
) -> FloatArray:
    """Factor on the gap of the transition stop in every frame.

    A rebound has one factor from its begin to its end, at both of which the gap is zero, so the
    drawing does not jump. A rebound that would be drawn beyond the limit has a smaller factor; all
    else is drawn as it is.

    Args:
        t: Times of the frames [s], shape (K,).
        gap: Gaps of the transition stop there, shape (K,) [rad or m].
        factor: Factor on rebounds [-].
        limit: Largest gap of a rebound that is drawn [rad or m].

    Returns:
        Shape (K,), at least 1.
    """
    found = np.ones(len(t))
    for flight in rebound_flights(solution):
        inside = (t >= flight.begin) & (t <= flight.end)
        highest = max(flight.highest, float(gap[inside].max(initial=0.0)))
        most = limit / highest if highest > 0.0 else factor
        found[inside] = max(1.0, min(factor, most))
    return found


def _enlarged(
    solution: Solution, t: FloatArray, q: FloatArray, asked: float | None
) -> tuple[float, FloatArray]:
    """Factor on rebounds, and configurations to draw."""
    if asked is not None:
        return asked, exaggerated(solution, t, q, asked)
    highest = max((flight.highest for flight in rebound_flights(solution)), default=0.0)
    if highest > 0.0:
        most = _SEEN * drawn_limit(solution.mechanism) / highest
        for factor in (item for item in _FACTORS if item <= most):
            # Where loops do not close so far from the motion, a smaller factor serves.
            with suppress(InputError):
                return factor, exaggerated(solution, t, q, factor)
    return 1.0, q


def bouncing_stop(mechanism: Mechanism) -> Stop | None:
    """The stop whose bouncing is the transition; None in a mechanism without one."""
    name = mechanism.transition_stop
    return next((stop for stop in mechanism.stops if stop.name == name), None)


def drawn_limit(mechanism: Mechanism) -> float:
    """Gap up to which the transition stop is exaggerated [rad or m]."""
    stop = mechanism.stop(mechanism.transition_stop)
    turns = mechanism.joints[stop.index].kind == "revolute"
    return _DRAWN_ANGLE if turns else _DRAWN_STROKE * mechanism.reach_m


def exaggerated(solution: Solution, t: FloatArray, q: FloatArray, factor: float) -> FloatArray:
    """Configurations with the rebounds of the transition stop enlarged and the loops closed again.

    A rebound is drawn so many times as large, or less if it would exceed 6 degrees or 3 % of the
    mechanism's reach; the shafts stand where they are and all other links follow. Closing and
    opening are drawn as they are.

    Args:
        t: Times of the configurations [s], shape (K,).
        q: Configurations of the machine, shape (K, nv).
        factor: Factor on the gap of rebounds [-].

    Returns:
        Configurations to draw, shape (K, nv).

    Raises:
        InputError: There is no such stop, or the loops of this mechanism leave its gap no
            freedom of its own.
    """
    if factor == 1.0:
        return q
    mechanism, body = solution.mechanism, solution.system.body
    stop = bouncing_stop(mechanism)
    if stop is None:
        message = f"{mechanism.name} has no transition stop whose gap could be drawn larger"
        raise InputError(message, exaggerate=factor)
    gap = stop.gaps(q)
    guess = q.copy()
    drawn = gap * factors(solution, t, gap, factor, drawn_limit(mechanism))
    guess[:, stop.index] = stop.at + stop.sense * drawn
    given = [*(drive.index for drive in mechanism.drives), stop.index]
    try:
        _, jacobian = body.closures(q[:1])
        return close_positions(body, guess, partition(jacobian[0], given, []))[0]
    except (ConvergenceError, SingularConfigurationError) as error:
        message = (
            f"the gap of stop {stop.name} cannot be drawn {factor:g} times as large, because the "
            f"loops do not close there ({error}); use a smaller factor"
        )
        raise InputError(message, exaggerate=factor) from error


def poses(solution: Solution, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where links stand.

    Args:
        q: Configurations, shape (K, nv).

    Returns:
        Origins (x, z), shape (K, links, 2) [m], and angles that go on, shape (K, links) [rad].
    """
    body = solution.system.body
    position = np.empty((len(q), len(solution.mechanism.joints), 2))
    angle = np.empty(position.shape[:2])
    for row, q_row in enumerate(q):
        for link, placement in enumerate(body.placements(q_row)):
            position[row, link] = placement.translation[[0, 2]]
            # About -y, which is counter-clockwise in the side view.
            angle[row, link] = math.atan2(placement.rotation[2, 0], placement.rotation[0, 0])
    return position, np.unwrap(angle, axis=0)


def worlds(position: FloatArray, angle: FloatArray) -> FloatArray:
    """From the axes of each link, and of the frame, to those of the world, in side view.

    Args:
        position: Origins (x, z), shape (K, links, 2) [m].
        angle: Rotations, shape (K, links) [rad].

    Returns:
        Matrices, shape (K, links + 1, 3, 3); that of the frame comes last.
    """
    count, links = angle.shape
    found = np.tile(np.eye(3), (count, links + 1, 1, 1))
    cos, sin = np.cos(angle), np.sin(angle)
    found[:, :-1, :2, :2] = np.stack([cos, -sin, sin, cos], axis=-1).reshape(count, links, 2, 2)
    found[:, :-1, :2, 2] = position
    return found


@dataclass(frozen=True)
class Curve:
    """One curve.

    Attributes:
        label: Lines of its name, the last one the unit.
        stop: The stop whose collisions are marked at it.
        colour: As in #RRGGBB.
        most: Largest value that is drawn, in the unit of the label.
        values: Values in the frames, shape (K,).
    """

    label: tuple[str, ...]
    stop: str
    colour: str
    most: float
    values: FloatArray


def curves(film: Film) -> list[Curve]:
    """Gap and force of the transition stop, then the gaps of others.

    The scale of the first is that of its rebounds; beyond it the curve ends.
    """
    mechanism = film.solution.mechanism
    main = bouncing_stop(mechanism)
    found = [] if main is None else list(_main(film, main))
    others = [stop for stop in mechanism.stops if stop is not main]
    for stop in others[:_OTHERS]:
        term = coordinate_shown(mechanism, stop.index)
        values = term.value(stop.gaps(film.q))
        found.append(Curve((f"{stop.name} {term.words}", f"[{term.unit}]"), stop.name,
                           _OTHER, _scale(values), values))  # fmt: skip
    return found


def _main(film: Film, stop: Stop) -> Iterator[Curve]:
    mechanism = film.solution.mechanism
    term = contact_shown(stop) or coordinate_shown(mechanism, stop.index)
    values = term.value(stop.gaps(film.q))
    rebounds = highest_drawn(film.solution, film.pace.machine, values)
    most = _ROOM * rebounds if rebounds > 0.0 else _scale(values)
    yield Curve((f"{stop.name} gap", f"[{term.unit}]"), stop.name, _GAP, most, values)
    force = film.force[stop.name]
    unit = force_unit(mechanism, stop)
    yield Curve(("clamping", f"force [{unit}]"), "", _FORCE, _scale(force), force)


def _scale(values: FloatArray) -> float:
    """Largest value of an axis that shows all values."""
    return _ROOM * float(values.max(initial=0.0)) or 1.0
