"""Stops that lie on one another: gap and rate are round-off, so they take part in an impact."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics.system import System
from ...mechanism import Stop
from ...tolerances.hybrid import GAP_ROUND_OFF
from ...tolerances.mechanics import STILL_GAP_RATE
from .complementarity import Closed


def touching(system: System, q: FloatArray, v: FloatArray, closed: Closed) -> list[Stop]:
    """Open stops whose gap and rate are zero, but for round-off of the machine and its motion.

    Args:
        system: The system.
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).
        closed: Names of the closed stops.
    """
    scale = system.turning
    near = [
        stop
        for stop in system.mechanism.stops
        if stop.name not in closed and abs(stop.gap(q)) * scale[stop.index] <= GAP_ROUND_OFF
    ]
    if not near:
        return near
    slow = STILL_GAP_RATE * float(system.turns(v).max())
    return [stop for stop in near if abs(stop.rate(v)) * scale[stop.index] <= slow]


def stilled(system: System, v: FloatArray, jacobian: FloatArray, stops: list[Stop]) -> FloatArray:
    """Velocity without the round-off of the rates of stops that touch, shape (nv,).

    Args:
        system: The system.
        v: Velocity, shape (nv,).
        jacobian: Closure Jacobian G, shape (m, nv).
        stops: The stops.
    """
    columns = tuple(stop.index for stop in stops)
    if not np.any(v[list(columns)]):
        return v
    v = v.copy()
    v[list(columns)] = 0.0
    if not len(jacobian):
        return v
    return system.closed_velocity(
        v, jacobian, system.split(jacobian, system.held_coordinates, columns)
    )
