"""Motion between two events: one set of closed stops, from a start to the first trigger."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition, partition
from ..dynamics.system import ConstraintSet, System
from ..errors import ConvergenceError, SimulationError, SingularConfigurationError
from ..mechanism import Stop
from .case import Resolution
from .collocation import Arc, evaluate, nodes
from .flight import flight_panel
from .kinematic import kinematic_panel
from .panel import Exact, Panel, forces_at, state_at
from .roots import first_descent, polish

_SHORTEST_PANEL = 1e-12
# Triggers nearer than this fraction of a turn are one event.
_SIMULTANEOUS = 1e-13


class TriggerKind(StrEnum):
    """What a root function belongs to."""

    GAP = "gap"
    FORCE = "force"


@dataclass(frozen=True)
class Trigger:
    """A root: the gap of an open stop, or the force of a closed one, falls through zero.

    Attributes:
        t: Time [s].
        kind: Gap or force.
        stop: Name of the stop.
    """

    t: float
    kind: TriggerKind
    stop: str


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
    open_stops = [stop for stop in system.mechanism.stops if stop.name not in rows.closed]
    kinematic = rows.freedom == 0
    start = t
    longest = system.shaft.period / resolution.panels_per_turn
    h = longest if kinematic else min(longest, _ballistic_length(q, v, a, open_stops))
    panels: list[Panel] = []
    while True:
        h = min(h, t_limit - t)
        by_gap = sorted(open_stops, key=lambda stop: abs(q[stop.index]))
        split = partition(jacobian, rows.given, [stop.index for stop in by_gap])
        panel, forces, advised = _panel(system, rows, split, t, h, q, v, a, resolution)
        panels.append(panel)
        triggers = _triggers(system, rows, panel, forces, open_stops)
        if triggers or t + panel.h >= t_limit:
            t_end = triggers[0].t if triggers else t_limit
            exact = state_at(system, rows, panel, np.array([t_end]))
            segment = Segment(start, t_end, rows.closed, tuple(panels), kinematic)
            for trigger in triggers:
                if trigger.kind is TriggerKind.GAP:
                    exact.q[0, system.mechanism.stop(trigger.stop).index] = 0.0
            return Advance(segment, triggers, exact)
        t = t + panel.h
        q, v, jacobian = (item[0] for item in state_at(system, rows, panel, np.array([t]))[:3])
        a = panel.a[-1]
        h = min(longest, advised)


def _ballistic_length(q: FloatArray, v: FloatArray, a: FloatArray, open_stops: list[Stop]) -> float:
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


def _triggers(
    system: System,
    rows: ConstraintSet,
    panel: Panel,
    forces: FloatArray,
    open_stops: list[Stop],
) -> tuple[Trigger, ...]:
    """Earliest triggers on a panel, simultaneous ones together."""
    found = []
    for stop in open_stops:
        t = _gap_root(system, rows, panel, stop.index)
        if t is not None:
            found.append(Trigger(t, TriggerKind.GAP, stop.name))
    closed = [stop for stop in system.mechanism.stops if stop.name in rows.closed]
    for column, stop in enumerate(closed):
        t = _force_root(system, rows, panel, forces[:, column], column)
        if t is not None:
            found.append(Trigger(t, TriggerKind.FORCE, stop.name))
    if not found:
        return ()
    earliest = min(trigger.t for trigger in found)
    limit = earliest + _SIMULTANEOUS * system.shaft.period
    return tuple(
        replace(trigger, t=earliest)
        for trigger in sorted(found, key=lambda item: item.stop)
        if trigger.t <= limit
    )


def _gap_root(system: System, rows: ConstraintSet, panel: Panel, index: int) -> float | None:
    """Time at which a gap falls through zero on a panel, or None."""
    grid = nodes(panel.order)
    h, a = panel.h, panel.a[:, index]
    gap, rate = float(panel.q[0, index]), float(panel.v[0, index])
    if not panel.integrated:

        def interpolant(sigma: float) -> float:
            return float(evaluate(panel.q[:, index], np.array([sigma]), 0)[0])

        def rough(t: float) -> tuple[float, float]:
            q_v = np.stack([panel.q[:, index], panel.v[:, index]], axis=1)
            gap_rate = evaluate(q_v, np.array([(t - panel.t) / h]), 0)[0]
            return float(gap_rate[0]), float(gap_rate[1])

        def exact(t: float) -> tuple[float, float]:
            state = state_at(system, rows, panel, np.array([t]))
            return float(state.q[0, index]), float(state.v[0, index])

        values = grid.sample_value @ panel.q[:, index]
        return _polished(panel, first_descent(grid.samples, values, interpolant), rough, exact)
    if gap > h * abs(rate) + h**2 * float(np.abs(a).max()):
        # Too far for the rate and for twice the way of any acceleration between the nodes.
        return None
    # Dividing out the zero at the start leaves the next one as the only one, to full precision.
    power = 0 if gap != 0.0 else (1 if rate != 0.0 else 2)
    values = h**2 * (grid.sample_twice[power] @ a)
    if power < 2:
        values += gap + h * rate * grid.samples if power == 0 else h * rate

    @cache
    def arc() -> Arc:
        return Arc(h**2 * a, gap, h * rate)

    def deflated(sigma: float) -> float:
        return arc().value(sigma) / sigma**power

    def motion(t: float) -> tuple[float, float]:
        sigma = (t - panel.t) / h
        return arc().value(sigma), arc().rate(sigma) / h

    if (values < 0.0).all():
        name = next(stop.name for stop in system.mechanism.stops if stop.index == index)
        message = (
            f"stop {name!r} is open but its gap starts to close from zero: the accelerations "
            "contradict the closed stops; this is an error of the package, please report the case"
        )
        raise SimulationError(message, stop=name, gap=gap, rate=rate)
    return _polished(panel, first_descent(grid.samples, values, deflated), motion)


def _force_root(
    system: System,
    rows: ConstraintSet,
    panel: Panel,
    force: FloatArray,
    column: int,
) -> float | None:
    """Time at which the force of a closed stop falls through zero on a panel, or None."""
    grid = nodes(panel.order)
    values = grid.sample_value @ force
    if values[0] < 0.0:
        # The force was zero to round-off when the stop was taken to be pressed.
        return panel.t
    slope = np.gradient(values, grid.samples) / panel.h

    def interpolant(sigma: float) -> float:
        return float(evaluate(force, np.array([sigma]), 0)[0])

    def rough(t: float) -> tuple[float, float]:
        sigma = (t - panel.t) / panel.h
        return interpolant(sigma), float(np.interp(sigma, grid.samples, slope))

    def exact(t: float) -> tuple[float, float]:
        la_N = forces_at(system, rows, panel, np.array([t]))[3].la_N
        return float(la_N[0, column]), rough(t)[1]

    bracket = first_descent(grid.samples, values, interpolant)
    return _polished(panel, bracket, rough, exact)


def _polished(
    panel: Panel,
    bracket: tuple[float, float] | None,
    *functions: Callable[[float], tuple[float, float]],
) -> float | None:
    """Root in a bracket, by one function after the other: the cheap ones find the start."""
    if bracket is None:
        return None
    left, right = (panel.t + panel.h * sigma for sigma in bracket)
    root = right
    for function in functions:
        root = polish(function, left, right, root)
    return root
