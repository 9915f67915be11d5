"""Flights of the jaw by SciPy's DOP853, stepped by hand; its ends located on dense output.

Not ``solve_ivp(events=...)``: that reports a root on the end of a step twice and stops at once when
it is restarted on the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from scipy.integrate import DOP853, DenseOutput

from nipper_pin.arrays import FloatArray

from .protocol import Bounces, Setting

SETTINGS = tuple(Setting(f"rtol 1e-{n}", float(f"1e-{n}")) for n in (3, 5, 7, 9, 11, 13))
_LONGEST = 0.1
_NEWTON = 12


class Start(NamedTuple):
    """State y just after a collision, with rate [rad/s] and deceleration [rad/s^2] of the jaw.

    The tolerance applies to the sizes of what the state does in the flight, too.
    """

    t: float
    y: FloatArray
    rate: float
    fall: float
    scale: FloatArray


class Jaw(NamedTuple):
    """What flights of the jaw need, whose angle [rad] and rate [rad/s] have places in the state.

    The equation is the derivative of the state, the acceleration that of the jaw; from time and
    state before a collision a rebound makes those after it.
    """

    restitution: float
    places: tuple[int, int]
    equation: Callable[[float, FloatArray], tuple[float, ...] | FloatArray]
    acceleration: Callable[[float, FloatArray], float]
    rebound: Callable[[float, FloatArray], Start]


def bounced(jaw: Jaw, start: Start, tolerance: float) -> tuple[Bounces, int]:
    """Fly from collision to collision until their limit is known; told are evaluations, too."""
    bounces = Bounces(jaw.restitution, start.rate, start.fall, 0.1 * tolerance)
    evaluations, over = 0, False
    while not over:
        solver, rising = _flown(jaw, start, tolerance, watched=len(bounces.times) == 1)
        t, y = _landed(jaw, solver)
        if rising is not None:
            bounces.amplitude = _top(jaw, *rising)
        start = jaw.rebound(t, y)
        # One more call gave the size of the flight.
        evaluations += solver.nfev + 1
        over = bounces.add(t, start.rate, start.fall)
    return bounces, evaluations


def _flown(
    jaw: Jaw, start: Start, tolerance: float, *, watched: bool
) -> tuple[DOP853, tuple[DenseOutput, float] | None]:
    """Step until the gap is closed; if watched, the step over the top and its end, too.

    The first step is the ballistic flight time, so that a late flight is a single step: just beyond
    the parabola's end, so that a short flight ends inside the step.
    """
    (th, w), rising = jaw.places, None
    solver = DOP853(
        jaw.equation, start.t, start.y, start.t + _LONGEST, rtol=tolerance,
        atol=tolerance * start.scale, first_step=2.02 * start.rate / start.fall,
    )  # fmt: skip
    while solver.y[th] > 0.0 or solver.t == start.t:
        rose = solver.y[w] > 0.0
        solver.step()
        if watched and rose and solver.y[w] <= 0.0:
            rising = solver.dense_output(), solver.t
    return solver, rising


def _landed(jaw: Jaw, solver: DOP853) -> tuple[float, FloatArray]:
    """Time of the collision [s] and the state just before it.

    The motion is concave, so Newton's method from the end of the step approaches from one side and
    cannot run into the start of the flight, which is a root too.
    """
    (th, w), motion, t = jaw.places, solver.dense_output(), solver.t
    for _ in range(_NEWTON):
        y = motion(t)
        change = y.item(th) / y.item(w)
        t -= change
        if abs(change) <= 1e-9 * (t - motion.t_old):
            break
    return t, motion(t)


def _top(jaw: Jaw, motion: DenseOutput, t: float) -> float:
    """Greatest jaw angle of a flight [rad], by the step over its top."""
    for _ in range(_NEWTON):
        y = motion(t)
        th, w = (y.item(place) for place in jaw.places)
        a = jaw.acceleration(t, y)
        t -= w / a
        if abs(w) <= 1e-9 * abs(a) * (t - motion.t_old):
            break
    return float(th - 0.5 * w * w / a)
