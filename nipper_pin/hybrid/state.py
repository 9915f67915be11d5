"""State of a run between two segments, and the one it starts from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import assemble
from ..dynamics.shaft import Driven
from ..dynamics.system import System
from ..errors import InputError
from .phases import Closed
from .series import BounceSeries

_ASSEMBLY_STEPS = 12
_NOW = np.zeros(1)
# Round-off of a gap that the closures determine [rad or m]: one as small is a contact.
_TOUCHING = 1e-13


class State(NamedTuple):
    """State of a run between two segments.

    Attributes:
        t: Time [s].
        q: Configuration, shape (nv,).
        v: Velocity (right limit), shape (nv,).
        jacobian: Closure Jacobian, shape (m, nv).
        motion: Driven coordinates at this time, as one row.
        closed: Closed stops.
        series: Bounces that have not come to rest yet.
    """

    t: float
    q: FloatArray
    v: FloatArray
    jacobian: FloatArray
    motion: Driven
    closed: Closed
    series: BounceSeries | None = None


def initial_state(system: System, start_index: float) -> State:
    """The initial phase at time zero, assembled along the drives from the touch position.

    Args:
        system: The system; its shaft has the start angle.
        start_index: Index that belongs to that angle, for the message.

    Raises:
        InputError: An open stop would be beyond its contact there.
    """
    mechanism, shaft = system.mechanism, system.shaft
    closed = mechanism.phase(mechanism.initial_phase).closed
    shut = [stop for stop in mechanism.stops if stop.name in closed]
    travel = shaft.start_angle_rad - mechanism.cylinder.angle_at_touch_rad
    # In the touch configuration all coordinates are zero: there is nothing to assemble.
    away = travel != 0.0 or any(stop.at for stop in shut)
    times = np.linspace(-travel / shaft.rate, 0.0, _ASSEMBLY_STEPS + 1) if away else _NOW
    angles, rates, accelerations = shaft.driven(times) if away else shaft.driven_at(0.0)
    driven = shaft.indices
    given = [*driven, *[stop.index for stop in shut]]
    path = np.zeros((len(times) - 1, len(given)))
    path[:, : len(driven)] = angles[1:]
    for column, stop in enumerate(shut, start=len(driven)):
        if stop.at:
            path[:, column] = np.linspace(0.0, stop.at, len(times))[1:]
    end_rates = np.zeros(len(given))
    end_rates[: len(driven)] = rates[-1]
    q, v, jacobian = assemble(system.body, path, given, end_rates)
    for stop in mechanism.stops:
        gap = stop.gap(q)
        if abs(gap) <= _TOUCHING:
            q[stop.index] = stop.at
        elif stop.name not in closed and gap < 0.0:
            message = (
                f"stop {stop.name!r} would be {-gap:.3g} beyond its contact at the "
                f"start, index {start_index:g}; start_index has to lie in phase "
                f"{mechanism.initial_phase}"
            )
            raise InputError(message, stop=stop.name, gap=gap)
    motion = (angles[-1:], rates[-1:], accelerations[-1:])
    return State(0.0, q, v, jacobian, motion, closed)
