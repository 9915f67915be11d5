"""Integrators of motion with freedom: one of the package, and those that users add.

An integrator gives the accelerations of one panel at its Chebyshev nodes. All that follows, the
location of events, impacts, energy balance and stated errors, is found from the panel, whoever has
made it: the stated errors measure how far the panel is from the equations of motion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from ...dynamics.assembly import Partition
from ...dynamics.constraint_set import ConstraintSet
from ...dynamics.system import System
from ...errors import InputError, UnknownNameError
from ...tolerances.hybrid import SMALLEST
from ..case import Resolution
from .chebyshev import decayed, nodes
from .panel import Attempt, Begin, Panel, forces_at, judged
from .picard import flight_panel


class Integrator(Protocol):
    """Anything that solves one panel of a phase with freedom."""

    def __call__(
        self,
        system: System,
        phase: ConstraintSet,
        split: Partition,
        begin: Begin,
        h: float,
        resolution: Resolution,
    ) -> Attempt:
        """Solve the panel from ``begin`` over the length h [s].

        Returns:
            The panel with the forces of its stops, or the advice to try a shorter one.
        """
        ...


PICARD = "picard"
"""Picard iteration on nested collocation grids, the integrator of the package."""
_integrators: dict[str, Integrator] = {PICARD: flight_panel}


def register_integrator(name: str) -> Callable[[Integrator], Integrator]:
    """Let a case name an integrator as ``Resolution(integrator=name)``; a decorator.

    Args:
        name: Its name.

    Raises:
        InputError: The name is that of the package's own integrator.
    """
    if name == PICARD:
        message = f"the integrator {PICARD!r} is that of the package; choose another name"
        raise InputError(message, name=name)

    def add(integrator: Integrator) -> Integrator:
        _integrators[name] = integrator
        return integrator

    return add


def integrator(name: str) -> Integrator:
    """Return an integrator by name.

    Raises:
        UnknownNameError: There is none.
    """
    if name not in _integrators:
        raise UnknownNameError(
            kind="integrator", name=name, known=_integrators, where="resolution.integrator"
        )
    return _integrators[name]


def panel_of(
    system: System,
    phase: ConstraintSet,
    split: Partition,
    begin: Begin,
    h: float,
    a: FloatArray,
    tolerance: float,
) -> Attempt:
    """Return the panel of accelerations that an integrator has found, if its nodes resolve it.

    Positions and velocities are the integrals of the polynomial through the accelerations. What
    follows its last coefficient, integrated twice, has to be within the tolerance.

    Args:
        system: The system.
        phase: The phase.
        split: Dependent and independent coordinates.
        begin: Where the panel begins.
        h: Its length [s].
        a: Accelerations at its nodes, shape (N, nv).
        tolerance: Relative accuracy of the positions.
    """
    grid = nodes(len(a))
    a = np.vstack([begin.a, a[1:]])
    q = begin.q + (h * grid.sigma)[:, None] * begin.v + h**2 * (grid.twice @ a)
    v = begin.v + h * (grid.once @ a)
    panel = Panel(begin.t, h, q, v, a, split, integrated=True)
    forces = np.empty((0, 0))
    if phase.stops:
        forces = forces_at(system, phase, panel, panel.times)[3].la_N
    moved = np.abs(h * begin.v) + h**2 * np.abs(a).max(axis=0) + SMALLEST
    left = phase.moving * decayed(a) * h**2 / moved / (2.0 * len(a)) ** 2
    return judged(panel, forces, float(left.max()) / tolerance, len(a))
