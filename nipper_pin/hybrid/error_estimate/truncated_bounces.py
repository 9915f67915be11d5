"""Effect of the bounces that are not computed before a rest on the motion after it.

They are replaced by one impulse that closes the stop where the last computed one has left it. With
the gap g that is left out, and the rates u of all coordinates by the rate of the gap, the motion is
meanwhile beside the closed one by u g and u g'. Both are zero in the end, but with A = da/dq and
B = da/dv of the closed phase they have moved it by

    dq = B u I,    dv = (A + B B) u I,    I = int g dt = w (1 - e)^2 T^2 / (6 (1 - e^3)),

w being the rate just after the last computed bounce and T the time that is left: flights at one
deceleration, 2 w / T / (1 - e), each with e times the rate of the one before.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System, close_velocities
from ...tolerances.hybrid import DIFFERENCE_STEP, SMALLEST
from ..event import Event


def left_out(system: System, rest: Event, remaining: float) -> FloatArray:
    """Deviations (dq, dv) after a rest by what is left out of its series, shape (2 nv,).

    Args:
        rest: The end of a series of bounces, with its impulse.
        remaining: Time from the last computed bounce to the rest [s].

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
    """
    stop, phase = system.mechanism.stop(rest.stops[0]), system.constraint_set(rest.closed_after)
    e_N, rate = stop.restitution, stop.rate(rest.v_before)
    q, v, u = rest.q, rest.v_after, -rest.delta / rate
    size = rate * ((1.0 - e_N) * remaining) ** 2 / (6.0 * (1.0 - e_N**3))
    # Places move along the closures, and rates stay those that belong to them.
    units = system.body.units
    aside = DIFFERENCE_STEP / max(_size(u / units), 1.0 / units[stop.index])
    moved = np.stack([q, q + aside * u])
    _, jacobians = system.body.closures(moved)
    split = system.split(jacobians[0], phase.given, (*phase.stops, *phase.yielding))
    turned = close_velocities(np.stack([v, v]), jacobians, split)[1]
    speed = DIFFERENCE_STEP * max(_size(v / units), abs(rate) / units[stop.index])
    hurried = speed / max(_size(u / units), SMALLEST)
    motion = system.shaft.driven(np.full(3, rest.t))
    a = system.accelerations(
        motion, np.stack([*moved, q]), np.stack([v, turned, v + hurried * u]), phase
    )
    by_place, by_rate = (a[1] - a[0]) / aside, (a[2] - a[0]) / hurried
    again = speed / max(_size(by_rate / units), SMALLEST)
    motion = system.shaft.driven(np.full(2, rest.t))
    a = system.accelerations(motion, np.stack([q, q]), np.stack([v, v + again * by_rate]), phase)
    by_rates = (a[1] - a[0]) / again
    return np.asarray(size * np.concatenate([by_rate, by_place + by_rates]))


def _size(vector: FloatArray) -> float:
    return float(np.abs(vector).max())
