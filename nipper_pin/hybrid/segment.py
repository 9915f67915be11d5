"""Motion between two events: one set of closed stops, from a start to the first trigger."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition
from ..dynamics.system import ConstraintSet, System
from ..errors import ConvergenceError, SingularConfigurationError
from ..mechanism import Stop
from .case import Resolution
from .flight import flight_panel
from .kinematic import kinematic_panel
from .panel import Exact, Panel, state_at
from .triggers import Trigger, TriggerKind, triggers

_SHORTEST_PANEL = 1e-12


@dataclass(frozen=True)
class Segment:
    """Motion with one set of closed stops.

    Attributes:
        t_start: Start [s].
        t_end: End [s].
        closed: Names of the closed stops.
        panels: Panels in order of time; the last one may reach beyond the end.
        kinematic: True if the drives determine the motion.
    """

    t_start: float
    t_end: float
    closed: frozenset[str]
    panels: tuple[Panel, ...]
    kinematic: bool

    def shifted(self, delay: float) -> Segment:
        """Return the same motion at a later time."""
        return replace(
            self,
            t_start=self.t_start + delay,
            t_end=self.t_end + delay,
            panels=tuple(panel.shifted(delay) for panel in self.panels),
        )

    def panel_number(self, t: float) -> int:
        """Return the place of the panel that holds time t [s]."""
        return max(bisect_right(self.panels, t, key=lambda panel: panel.t) - 1, 0)


@dataclass(frozen=True)
class Advance:
    """Result of :func:`advance`.

    Attributes:
        segment: The motion.
        triggers: Simultaneous triggers that end it, ordered by stop; empty at the time limit.
        end: State at its end (left limit), as one row.
    """

    segment: Segment
    triggers: tuple[Trigger, ...]
    end: Exact


def advance(
    system: System,
    rows: ConstraintSet,
    t: float,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    jacobian: FloatArray,
    t_limit: float,
    resolution: Resolution,
) -> Advance:
    """Follow the motion from a state just after an event to the next event.

    Args:
        system: The system.
        rows: The phase: which stops are closed.
        t: Start [s].
        q: Closed configuration, shape (nv,); gaps of stops just left are exactly zero.
        v: Closed velocity (right limit), shape (nv,).
        a: Acceleration there, shape (nv,).
        jacobian: Closure Jacobian there, shape (m, nv).
        t_limit: Where to stop at the latest [s].
        resolution: How finely the motion is resolved.

    Returns:
        The motion and what ended it.

    Raises:
        SimulationError: The motion cannot be followed.
    """
    kinematic = rows.freedom == 0
    start = t
    longest = system.shaft.period / resolution.panels_per_turn
    h = longest if kinematic else min(longest, _ballistic_length(q, v, a, rows.open))
    panels: list[Panel] = []
    while True:
        h = min(h, t_limit - t)
        by_gap = sorted((abs(q[stop.index]), stop.index) for stop in rows.open)
        split = system.split(jacobian, rows.given, tuple(index for _, index in by_gap))
        panel, forces, advised = _panel(system, rows, split, t, h, q, v, a, resolution)
        panels.append(panel)
        found = triggers(system, rows, panel, forces)
        if found or t + panel.h >= t_limit:
            t_end = found[0].t if found else t_limit
            exact = state_at(system, rows, panel, np.array([t_end]))
            segment = Segment(start, t_end, rows.closed, tuple(panels), kinematic)
            for trigger in found:
                if trigger.kind is TriggerKind.GAP:
                    exact.q[0, system.mechanism.stop(trigger.stop).index] = 0.0
            return Advance(segment, found, exact)
        t = t + panel.h
        q, v, jacobian = (item[0] for item in state_at(system, rows, panel, np.array([t]))[:3])
        a = panel.a[-1]
        h = min(longest, advised)


def _ballistic_length(
    q: FloatArray, v: FloatArray, a: FloatArray, open_stops: Sequence[Stop]
) -> float:
    """Time [s] in which a body that leaves a stop at constant acceleration is back, and a bit."""
    lengths = [
        -2.0 * v[stop.index] / a[stop.index]
        for stop in open_stops
        if q[stop.index] == 0.0 and v[stop.index] > 0.0 and a[stop.index] < 0.0
    ]
    return 1.1 * float(min(lengths, default=np.inf))


def _panel(
    system: System,
    rows: ConstraintSet,
    split: Partition,
    t: float,
    h: float,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    resolution: Resolution,
) -> tuple[Panel, FloatArray, float]:
    """Solve one panel, shortened until it is resolved; with stop forces and the next length."""
    shortest = _SHORTEST_PANEL * system.shaft.period
    kinematic = rows.freedom == 0
    while h > 0.0:
        factor = 0.5
        try:
            if kinematic:
                attempt = kinematic_panel(system, rows, split, t, h, q, v, a, resolution)
            else:
                attempt = flight_panel(system, rows, split, t, h, q, v, a, resolution)
        except (ConvergenceError, SingularConfigurationError):
            # The guess of a long panel may be too far off, or its iteration run away to where the
            # loops do not close; a short one tells the truth.
            if h <= 2.0 * shortest:
                raise
        else:
            if attempt.panel is not None:
                return attempt.panel, attempt.forces, h * attempt.factor
            factor = attempt.factor
        if h <= shortest:
            break
        h *= factor
    message = (
        f"the motion cannot be resolved: the step falls to {h:.2g} s; a spring or a mass is too "
        "extreme, or a dead centre is near"
    )
    raise ConvergenceError(message, residual=h, tolerance=shortest, iterations=0)
