"""One flight of the jaw by SciPy's DOP853, stepped by hand; its ends located on dense output.

Not ``solve_ivp(events=...)``: that reports a root on the end of a step twice and stops at once when
it is restarted on the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scipy.integrate import DOP853, DenseOutput

from nipper_pin.arrays import FloatArray

from .protocol import Setting

SETTINGS = (
    Setting("rtol 1e-3", 1e-3),
    Setting("rtol 1e-5", 1e-5),
    Setting("rtol 1e-7", 1e-7),
    Setting("rtol 1e-9", 1e-9),
    Setting("rtol 1e-11", 1e-11),
    Setting("rtol 1e-13", 1e-13),
)
_LONGEST = 0.1
_NEWTON = 12

Equation = Callable[[float, FloatArray], tuple[float, ...] | FloatArray]


@dataclass(frozen=True)
class Start:
    """State just after a collision.

    Attributes:
        t: Time [s].
        y: State there; the gap is zero and opens.
        rate: Jaw rate there [rad/s].
        fall: Deceleration of the jaw there [rad/s^2].
        scale: Sizes of what the state does in the flight, to which the tolerance applies, too.
    """

    t: float
    y: FloatArray
    rate: float
    fall: float
    scale: FloatArray


class Flight:
    """A flight from just after a collision to the next one.

    Its first step is the ballistic flight time, so that a late flight is a single step.

    Args:
        equation: Derivative of the state, of time [s] and state.
        start: Where the flight begins.
        places: Where jaw angle [rad] and jaw rate [rad/s] are in the state.
        tolerance: Relative tolerance.
        watched: True if the amplitude will be asked for.
    """

    def __init__(
        self,
        equation: Equation,
        start: Start,
        places: tuple[int, int],
        tolerance: float,
        watched: bool,
    ) -> None:
        """Set up the solver."""
        self._th, self._w = places
        self._start, self._watched = start.t, watched
        self._rising: DenseOutput | None = None
        self._top = start.t
        self._solver = DOP853(
            equation,
            start.t,
            start.y,
            start.t + _LONGEST,
            rtol=tolerance,
            atol=tolerance * start.scale,
            # Just beyond the parabola's end, so that a short flight ends inside the step.
            first_step=2.02 * start.rate / start.fall,
        )

    def land(self) -> tuple[float, FloatArray, int]:
        """Fly until the gap closes.

        The motion is concave, so Newton's method from the end of the step approaches from one side
        and cannot run into the start of the flight, which is a root too.

        Returns:
            Time of the collision [s], state just before it, and the evaluations.
        """
        solver = self._solver
        while solver.y[self._th] > 0.0 or solver.t == self._start:
            rising = solver.y[self._w] > 0.0
            solver.step()
            if self._watched and rising and solver.y[self._w] <= 0.0:
                self._rising, self._top = solver.dense_output(), solver.t
        motion, t = solver.dense_output(), solver.t
        for _ in range(_NEWTON):
            y = motion(t)
            change = y.item(self._th) / y.item(self._w)
            t -= change
            if abs(change) <= 1e-9 * (t - motion.t_old):
                break
        return t, motion(t), solver.nfev

    def amplitude(self, acceleration: Callable[[float, FloatArray], float]) -> float:
        """Greatest jaw angle of the flight [rad]."""
        motion, t = self._rising, self._top
        if motion is None:
            return 0.0
        for _ in range(_NEWTON):
            y = motion(t)
            th, w = y.item(self._th), y.item(self._w)
            a = acceleration(t, y)
            t -= w / a
            if abs(w) <= 1e-9 * abs(a) * (t - motion.t_old):
                break
        return float(th - 0.5 * w * w / a)
