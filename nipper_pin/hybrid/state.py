"""State of a run between two segments."""

from __future__ import annotations

from typing import NamedTuple

from ..arrays import FloatArray
from ..dynamics import Driven, System
from .contact.active_set import Closed
from .contact.bounce_series import BounceSeries


class State(NamedTuple):
    """State of a run between two segments.

    Attributes:
        t: Time [s].
        q: Configuration, shape (nv,).
        v: Velocity (right limit), shape (nv,).
        jacobian: Closure Jacobian, shape (m, nv).
        motion: Driven coordinates at this time, as one row.
        closed: Closed stops.
        series: Bounces that have not come to rest yet, of each stop that bounces.
    """

    t: float
    q: FloatArray
    v: FloatArray
    jacobian: FloatArray
    motion: Driven
    closed: Closed
    series: tuple[BounceSeries, ...] = ()

    @classmethod
    def at(cls, system: System, t: float, q: FloatArray, v: FloatArray, closed: Closed) -> State:
        """Return the state of closed coordinates, where nothing bounces."""
        jacobian = system.body.closures(q[None])[1][0]
        return cls(t, q, v, jacobian, system.shaft.driven_at(t), closed)
