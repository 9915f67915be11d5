"""Conditions under which the limit of a bounce series is not taken."""

from __future__ import annotations

from collections.abc import Collection
from math import inf

from ....arrays import FloatArray
from ....dynamics import System
from ...state import State

UNKNOWN = inf, inf


def knot_between(system: System, before: float, t: float) -> bool:
    """True if the law of a drive changes its polynomial between two times [s]."""
    return before + system.shaft.smooth_for(before) < t


def other_stop_meets(
    system: System, state: State, a: FloatArray, bouncing: Collection[str], t_rest: float
) -> bool:
    """True if another stop of their part may close while the bounces that are left out go on.

    It would meet a stop that still bounces, not one at rest.
    """
    left, part = t_rest - state.t, system.coupled(bouncing)
    return any(
        lowest_gap(stop.gap(state.q), stop.rate(state.v), stop.rate(a), left) <= 0.0
        for stop in system.mechanism.stops
        if stop.name in part and stop.name not in state.closed and stop.name not in bouncing
    )


def lowest_gap(gap: float, rate: float, acceleration: float, left: float) -> float:
    """Lowest gap within a time that is left, at constant acceleration; a little less if that falls.

    Args:
        gap: The gap [rad or m].
        left: The time [s].
    """
    if rate < 0.0 < acceleration:
        turn = min(left, -rate / acceleration)
        return gap + turn * (rate + 0.5 * acceleration * turn)
    return gap + left * (min(rate, 0.0) + left * acceleration)
