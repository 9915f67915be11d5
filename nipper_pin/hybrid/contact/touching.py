"""Stops that lie on one another: gap and rate are round-off, so they take part in an impact."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System
from ...mechanism import Stop
from ...tolerances.hybrid import GAP_ROUND_OFF
from ...tolerances.mechanics import STILL_GAP_RATE


def touching(
    system: System, q: FloatArray, v: FloatArray, stops: Iterable[Stop], known: Collection[str]
) -> list[Stop]:
    """Stops whose gap and rate are zero, but for round-off of machine and motion.

    Args:
        q: Configuration, shape (nv,).
        v: Velocity, shape (nv,).
        known: Names of those that are closed, or close.
    """
    # Few gaps are so small, and only these are worth a look at units.
    far = GAP_ROUND_OFF * max(system.body.reach_m, 1.0)
    near = [stop for stop in stops if stop.name not in known and -far <= stop.gap(q) <= far]
    if not near:
        return near
    turning, rates = system.turning, system.turns(v)
    slow = STILL_GAP_RATE * max(float(rates.max()), system.shaft.speed_rad_s)
    return [
        stop
        for stop in near
        if abs(stop.gap(q)) * turning[stop.index] <= GAP_ROUND_OFF and rates[stop.index] <= slow
    ]


def stilled(system: System, v: FloatArray, jacobian: FloatArray, stops: list[Stop]) -> FloatArray:
    """Velocity without the round-off of the rates of stops that touch, shape (nv,).

    Args:
        v: Velocity, shape (nv,).
        jacobian: Closure Jacobian G, shape (m, nv).
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
