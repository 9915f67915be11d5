"""What flights leave unresolved in positions and rates: the errors that they make of their own.

They come from what the dynamics say between the nodes, where the interpolant is wrong by the
Chebyshev coefficients that it lacks, from what one more sweep would change and from what the
round-off of a state does to its acceleration, more than round-off where masses differ much.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import inverted
from ..dynamics.system import ConstraintSet, System
from ..mechanism import Stop
from .collocation import nodes
from .event import Event
from .panel import Panel, defect, nearby
from .segment import Segment

_EPS = float(np.finfo(float).eps)
# True errors were up to 4.6 times the bare estimate, over ten runs at six tolerances; with masses
# that differ by 1e8 up to 11 times.
_SAFETY = 8.0
# With several freedoms, elastic drive trains above all, what one leaves unresolved disturbs the
# others in later flights: up to 3.5 times the estimate was seen.
_COUPLED = 4.0
# Round-off of a polynomial, in units of that of its largest term.
_OPERATIONS = 4.0


class OpenGaps:
    """What flights have left unresolved in gaps, since each stop was struck.

    Where one freedom is left the collision at one stop stands for the error of all. Where there are
    several, a gap goes on with its own error while another stop is struck, and in any case while a
    closed stop is released.

    Args:
        system: The system.
    """

    def __init__(self, system: System) -> None:
        """Begin with none."""
        self._system = system
        self._own: dict[str, tuple[float, float]] = {}
        # By the arrays of the panels, of which copies of a turn share theirs.
        self._panels: dict[int, tuple[FloatArray, FloatArray]] = {}

    def after(self, segment: Segment, end: Stop) -> tuple[float, float]:
        """Errors of a gap [rad or m] and of its rate [rad/s or m/s] at the end of a segment.

        Args:
            segment: The segment that follows the last one.
            end: The stop that is asked for.
        """
        if segment.t_end <= segment.t_start:
            return 0.0, 0.0
        rows = self._system.constraint_set(segment.closed)
        before = self._own
        goes_on = rows.freedom > 1 or end.name in segment.closed
        found = {
            stop.name: self._grown(segment, stop, before.get(stop.name, (0.0, 0.0)))
            for stop in rows.open
            if not segment.kinematic and (goes_on or stop.name in (end.name, *before))
        }
        self._own = {name: own for name, own in found.items() if goes_on or name in before}
        return found.get(end.name, (0.0, 0.0))

    def along(self, segment: Segment) -> tuple[FloatArray, FloatArray]:
        """Errors of all positions and velocities that a flight has made at its end, each (nv,)."""
        eps, eta = np.zeros((2, self._system.body.nv))
        for panel, begin, end in segment.pieces():
            position, velocity = self._alone(segment, panel)
            eps += position + (end - begin) * eta
            eta += velocity
        return eps, eta

    def forget(self, event: Event) -> None:
        """Let an event start its stops anew: what they were wrong by is in its errors."""
        for name in event.stops:
            self._own.pop(name, None)

    def _grown(
        self, segment: Segment, stop: Stop, before: tuple[float, float]
    ) -> tuple[float, float]:
        """Errors of a gap and of its rate at the end of a flight, from those at its start."""
        system, index, (eps, eta) = self._system, stop.index, before
        coupled, start = self._coupled(segment), segment.panels[0]
        if start.q[0, index] != stop.at:
            # Where a gap has not just opened its start has the round-off of the closures.
            eps += coupled * float(round_off(system, start, start.q[:1])[index])
        for panel, begin, end in segment.pieces():
            if panel is not start:
                # Where panels meet a gap has the round-off of its coordinate, however small it is.
                eps += coupled * _EPS * abs(float(panel.q[0, index]))
            gap, slope = _in_gap(system, panel, index, *self._alone(segment, panel))
            eps += gap + (end - begin) * eta
            eta += slope
        return eps, eta

    def _coupled(self, segment: Segment) -> float:
        rows = self._system.constraint_set(segment.closed)
        return _COUPLED if rows.freedom > 1 else 1.0

    def _alone(self, segment: Segment, panel: Panel) -> tuple[FloatArray, FloatArray]:
        """What a panel leaves unresolved in all positions and velocities, each (nv,)."""
        key = id(panel.q)
        if key not in self._panels:
            rows, coupled = self._system.constraint_set(segment.closed), self._coupled(segment)
            position, velocity = _unresolved(self._system, rows, panel)
            self._panels[key] = coupled * position, coupled * velocity
        return self._panels[key]


def round_off(system: System, panel: Panel, q: FloatArray) -> FloatArray:
    """Round-off of positions, (nv,): of dependent ones that of the closures, by their lever."""
    lever = np.ones(q.shape[1])
    if panel.split.dependent:
        _, jacobian = system.body.closures(q)
        _, inverse = inverted(jacobian[0].take(panel.split.columns, 1))
        lever[panel.split.columns] = np.abs(inverse).sum(axis=1)
    return np.asarray(8.0 * _EPS * system.body.reach_m * lever)


def _in_gap(
    system: System, panel: Panel, index: int, position: FloatArray, velocity: FloatArray
) -> tuple[float, float]:
    """What a flight panel leaves unresolved in the position and the velocity of one coordinate.

    A coordinate that the closures determine has the errors of those that determine it besides.

    Args:
        system: The system.
        panel: The panel.
        index: The coordinate.
        position: What each position alone is left with, shape (nv,).
        velocity: What each velocity alone is left with, shape (nv,).
    """
    columns, shares = [index], np.ones(1)
    if index in panel.split.dependent:
        columns = [index, *(k for k in panel.split.independent if system.free[k])]
        shares = np.append(shares, np.abs(_lever(system, panel, index)[columns[1:]]))
    return float(shares @ position[columns]), float(shares @ velocity[columns])


def _lever(system: System, panel: Panel, index: int) -> FloatArray:
    """Change of a dependent coordinate by each independent one at the end of a panel, (nv,)."""
    _, jacobian = system.body.closures(panel.q[-1:])
    _, inverse = inverted(jacobian[0].take(panel.split.columns, 1))
    return np.asarray(inverse[panel.split.dependent.index(index)] @ jacobian[0])


def _between(system: System, rows: ConstraintSet, panel: Panel) -> FloatArray:
    """Largest difference of the dynamics from the interpolant between the nodes, (nv,).

    The last coefficients may be small by chance; what is wrong between the nodes is not.
    """
    return np.asarray(defect(system, rows, panel, nodes(panel.order).between).max(axis=0))


def _unresolved(system: System, rows: ConstraintSet, panel: Panel) -> tuple[FloatArray, FloatArray]:
    """What a flight panel leaves unresolved in all positions and velocities, each (nv,)."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times)
    again = system.accelerations(motion, panel.q, panel.v, rows)
    swept = again - a
    there = system.accelerations(motion, *nearby(system, panel.q, panel.v, panel.split), rows)
    rough = np.abs(there - again).max(axis=0)
    missing = _between(system, rows, panel)
    if system.mechanism.tabulated_springs:
        # Across a row of a table coefficients decay by powers: of k^-3 that all follow, twice
        # integrated, a quarter of their number times the last one is missing.
        last = np.abs(grid.integrals[0][-2:] @ a).max(axis=0)
        missing = np.maximum(missing, 0.25 * panel.order * last)
    round_off = _OPERATIONS * _EPS * (np.abs(panel.v[0]) + h * np.abs(a).max(axis=0))
    position = missing / (2.0 * panel.order) ** 2 + np.abs(grid.twice @ swept).max(axis=0)
    velocity = missing / (2.0 * panel.order) + np.abs(grid.once @ swept).max(axis=0)
    return (
        _SAFETY * h**2 * (position + 0.5 * rough) + h * round_off,
        _SAFETY * h * (velocity + rough) + round_off,
    )
