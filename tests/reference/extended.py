"""The planar nipper in 80-bit arithmetic: the 60-digit solution, a hundred times faster.

The machine is that of ``planar.py``, and ``events.py`` solves it by Taylor series as it does in 60
digits; only the numbers are ``numpy.longdouble``. A bounce series is followed until its flights
last less than 1e-11 s; what is left is a geometric series. The agreement with the certified
solutions is tested in ``test_reference.py``; nothing here is shared with the package.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any

import numpy as np
from events import JAW, STEEVE, Phase, Settings, Simulation, fly
from planar import Machine

COLLISION, REST, RELEASE = "collision", "rest", "release"
L = np.longdouble
PI = L("3.14159265358979323846264338327950288")
SETTINGS = Settings(order=24, tolerance="1e-21", shortest="1e-11")


class Extended:
    """What ``planar`` and ``events`` ask of an mpmath context, for 80-bit numbers and arrays."""

    zero, one, pi, inf = L(0), L(1), PI, L("inf")
    mpf = L

    @staticmethod
    def mpc(real: Any, imaginary: Any) -> Any:
        """A complex number."""
        return L(real) + 1j * L(imaginary)

    @staticmethod
    def expj(angle: Any) -> Any:
        """exp(i x) of a real number."""
        return np.cos(angle) + 1j * np.sin(angle)

    @staticmethod
    def fdot(left: Any, right: Any) -> Any:
        """Sum of products."""
        return sum(map(operator.mul, left, right))

    arg, asin, sqrt = staticmethod(np.angle), staticmethod(np.arcsin), staticmethod(np.sqrt)


@dataclass
class Happening:
    """An event; rates are of the stop's coordinate (rad/s or m/s), impulses N m s or N s.

    Attributes:
        kind: collision, rest or release.
        stop: the stop.
        time: of it, s.
        approach: rate before a collision.
        separation: rate after it.
        impulse: of a collision.
        amplitude: of the rebound after it.
        rebound: its duration, s.
    """

    kind: str
    stop: str
    time: Any
    approach: Any = None
    separation: Any = None
    impulse: Any = None
    amplitude: Any = None
    rebound: Any = None


class Solution(Simulation):
    """Motion of one machine, as its events.

    Args:
        changes: parameters (names of ``planar.PARAMETERS``) that differ, as decimals.
        foremost: begin at the foremost position, not at the touch.
    """

    def __init__(self, changes: dict[str, str], *, foremost: bool = False) -> None:
        machine = Machine(Extended(), changes)
        super().__init__(
            machine, SETTINGS, machine.psi_foremost() if foremost else machine.psi_touch
        )
        self.period = 2 * PI / machine.speed

    @property
    def events(self) -> list[Happening]:
        """What happened, in order of time."""
        found = [
            Happening(COLLISION, hit.stop, hit.time, hit.approach_rate, hit.separation_rate,
                      hit.impulse, hit.rebound_amplitude, hit.rebound_time)
            for hit in self.trace.collisions
        ]  # fmt: skip
        found += [Happening(REST, stop, time) for stop, time, _ in self.trace.rests]
        found += [
            Happening(RELEASE, phase.closed, phase.end)
            for phase in self.trace.phases
            if phase.closed is not None and phase.ended_by == RELEASE
        ]
        return sorted(found, key=lambda event: event.time)

    def held(self, stop: str, time: Any) -> tuple[Any, Any]:
        """Motion with one stop closed, and the force of that stop, as series about some times."""
        frame = self.machine.frame(self.psi(time))
        return self.machine.phase1(frame) if stop == STEEVE else self.machine.phase2(frame)

    def follow(self, held: str, time: Any, until: str = "") -> None:
        """From a closed stop on: one turn, or until a certain stop rests."""
        while held and held != until:
            motion, force = self.held(held, time)
            if force[0] > 0:
                name, time, found = self.hold(held, time, self.period)
                motion, vanish = found or motion, 3
            else:
                # A stop that is not pressed shut opens there.
                self.trace.phases.append(Phase(held, time, time, RELEASE))
                name, vanish = RELEASE, 2
            if name == "end":
                return
            if name == RELEASE:
                th, rate = motion.th[0], motion.th[1]
                held, time = self.bounce(time, th, rate, {held: vanish}, self.period)
            else:
                rate = self.collide_from(held, name, time, motion)
                held, time = fly(self, time, rate, self.period)


def transition(changes: dict[str, str]) -> list[Happening]:
    """From the first collision at the jaw (time zero, cylinder at touch) to rest of the jaw."""
    run = Solution(changes)
    motion, _ = run.held(STEEVE, L(0))
    held, time = fly(run, L(0), run.collide_from(STEEVE, JAW, L(0), motion), run.period)
    # Where the steeve rests first the jaw follows it until it touches again.
    run.follow(held, time, until=JAW)
    if not run.trace.rests or run.trace.rests[-1][0] != JAW:
        message = "no rest"
        raise ArithmeticError(message)
    return run.events


def cycle(changes: dict[str, str]) -> list[Happening]:
    """One turn from the foremost position, jaw open and steeve on its stop."""
    run = Solution(changes, foremost=True)
    run.follow(STEEVE, L(0))
    return run.events
