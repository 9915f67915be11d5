"""Motion between two events: one set of closed stops, from a start to the first trigger."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition, close_positions
from ..dynamics.elements import Elements
from ..dynamics.system import ConstraintSet, System
from ..errors import ConvergenceError, ElementError, SimulationError, SingularConfigurationError
from ..mechanism import Stop
from .case import Resolution
from .event_location.guards import Trigger, TriggerKind, triggers
from .motion.chebyshev import nodes
from .motion.coordinate_choice import serves, suited_split
from .motion.integrators import integrator
from .motion.kinematics import kinematic_panel
from .motion.panel import Begin, Exact, Panel, one_state_at
from .motion.residual_check import shows_end, shows_forces, shows_turns
from .state import State

_SHORTEST_PANEL = 1e-12
# In one phase; a whole turn of a comber has thirty.
_MOST_PANELS = 10_000
# Round-off of a gap at a root [rad or m].
_ROUND_OFF = 1e-14


@dataclass(frozen=True, eq=False)
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

    def shifted(self, delay: float, wound: FloatArray) -> Segment:
        """Return the same motion at a later time; arguments as :meth:`Panel.shifted`."""
        return replace(
            self,
            t_start=self.t_start + delay,
            t_end=self.t_end + delay,
            panels=tuple(panel.shifted(delay, wound) for panel in self.panels),
        )

    def pieces(self) -> Iterator[tuple[Panel, float, float]]:
        """Panels with the part of each that belongs to the segment: begin and end [s]."""
        for panel in self.panels:
            begin, end = max(panel.t, self.t_start), min(panel.t + panel.h, self.t_end)
            if end > begin:
                yield panel, begin, end

    def panel_number(self, t: float) -> int:
        """Return the place of the panel that holds time t [s]."""
        return max(bisect_right(self.panels, t, key=lambda panel: panel.t) - 1, 0)


class Advance(NamedTuple):
    """Result of :func:`advance`.

    Attributes:
        segment: The motion.
        triggers: Simultaneous triggers that end it, ordered by stop; empty at the time limit.
        end: State at its end (left limit).
    """

    segment: Segment
    triggers: tuple[Trigger, ...]
    end: State


def advance(
    system: System, state: State, a: FloatArray, t_limit: float, resolution: Resolution
) -> Advance:
    """Follow the motion from a state just after an event to the next event.

    Args:
        system: The system.
        state: The state; gaps of stops just left are exactly zero.
        a: Acceleration there, shape (nv,).
        t_limit: Where to stop at the latest [s].
        resolution: How finely the motion is resolved.

    Returns:
        The motion and what ended it.

    Raises:
        SimulationError: The motion cannot be followed.
    """
    phase = system.constraint_set(state.closed)
    kinematic = phase.freedom == 0
    jacobian, begin = state.jacobian, Begin(state.t, state.q, state.v, a)
    longest = system.shaft.period / resolution.panels_per_turn
    h = longest if kinematic else min(longest, _ballistic_length(begin, phase.open))
    # A stop that has just been left is independent, so that its gap keeps its relative precision,
    # and stays so: a coordinate that the others determine has their errors, multiplied.
    leaving = sorted(phase.open, key=lambda stop: stop.gap(state.q) != 0.0)
    preferred = (*phase.yielding, *(stop.index for stop in leaving))
    panels: list[Panel] = []
    while True:
        t, left = begin.t, t_limit - begin.t
        h = min(h, left, system.shaft.smooth_for(t))
        if left - h < _SHORTEST_PANEL * system.shaft.period:
            # Round-off of a sum of panels must not leave one that holds nothing but round-off.
            h = left
        try:
            choose = system.split if kinematic else system.good_split
            split = choose(jacobian, phase.given, preferred)
            panel, forces, advised = _panel(system, phase, split, begin, h, resolution)
        except SimulationError as error:
            raise type(error)(error.message, **{**error.evidence, "t": t, "q": begin.q}) from error
        panels.append(panel)
        if len(panels) > _MOST_PANELS:
            message = (
                f"one phase needs more than {_MOST_PANELS} panels: a drive train or a spring "
                "swings many times, the nodes are too few for the tolerance, or a dead centre is "
                "near"
            )
            raise ConvergenceError(
                message,
                residual=h,
                tolerance=resolution.tolerance,
                iterations=len(panels),
                t=t,
                q=begin.q,
            )
        found, t_end, exact = _followed(system, phase, panel, forces, t_limit)
        suited: Partition | None = split
        if not kinematic and not serves(system, panel, jacobian, exact.jacobian):
            suited = suited_split(system, phase, panel, exact.jacobian, preferred)
        seen = kinematic or not found or not resolution.adaptive
        seen = seen or shows_end(system, phase, panel, resolution.tolerance, t_end)
        if (suited is None or not seen) and t_end - t > 4.0 * _SHORTEST_PANEL * system.shaft.period:
            # The same motion in shorter panels: they see what happens at its end, and each has the
            # coordinates that suit it.
            del panels[-1]
            h = 0.5 * (t_end - t)
            continue
        if suited is not None and suited != split:
            panel = panels[-1] = replace(panel, split=suited)
            found, t_end, exact = _followed(system, phase, panel, forces, t_limit)
        if found or t_end >= t_limit:
            segment = Segment(state.t, t_end, phase.closed, tuple(panels), kinematic)
            hit = [
                system.mechanism.stop(trigger.stop)
                for trigger in found
                if trigger.kind is TriggerKind.GAP
            ]
            end = _closed_up(system, phase, exact, hit) if hit else exact
            return Advance(segment, found, State(t_end, *end, state.closed, state.series))
        jacobian = exact.jacobian
        begin = Begin(t + panel.h, exact.q, exact.v, panel.a[-1])
        h = min(longest, advised)


def _followed(
    system: System, phase: ConstraintSet, panel: Panel, forces: FloatArray, t_limit: float
) -> tuple[tuple[Trigger, ...], float, Exact]:
    """Triggers on a panel, and time and state at the first of them or at the end."""
    found = triggers(system, phase, panel, forces)
    t_end = found[0].t if found else min(panel.t + panel.h, t_limit)
    if system.elements is not None:
        _check_tables(system.elements, panel, found[0].t if found else t_limit)
    return found, t_end, one_state_at(system, phase, panel, t_end)


def _shows_elements(
    system: System, phase: ConstraintSet, panel: Panel, resolution: Resolution
) -> bool:
    """True if the nodes see what tables, and dampers between points, do on a panel."""
    if system.elements is None or not resolution.adaptive:
        return True
    # Such forces bend the motion to its start, however early the event is that ends it.
    if system.elements.runs_off(panel.q):
        return False
    if not shows_turns(system.elements, panel, resolution.tolerance):
        return False
    return not panel.integrated or shows_forces(system, phase, panel, resolution.tolerance)


def _check_tables(elements: Elements, panel: Panel, t_end: float) -> None:
    """Refuse a panel that leaves a table before the end of the segment; no node may show it."""
    times = panel.t + panel.h * nodes(panel.order).samples
    times = np.append(times[times < t_end], min(t_end, panel.t + panel.h))
    elements.check(panel.interpolate(times)[0], times)


def _closed_up(system: System, phase: ConstraintSet, end: Exact, hit: list[Stop]) -> Exact:
    """The end of a segment with the gaps of the stops that it ends at exactly zero."""
    met = end.q
    left = max(abs(stop.gap(met)) for stop in hit)
    for stop in hit:
        met[stop.index] = stop.at
    if left <= _ROUND_OFF:
        return end
    # The root is one of the motion as it was integrated, the closures move a gap that depends on
    # the others: let these follow the gap instead.
    columns = tuple(stop.index for stop in hit)
    split = system.split(end.jacobian, phase.given, (*columns, *phase.yielding))
    if not set(columns).isdisjoint(split.dependent):
        return end
    q, jacobians = close_positions(system.body, met[None], split)
    jacobian = jacobians[0]
    return Exact(q[0], system.closed_velocity(end.v, jacobian, split), jacobian, end.motion)


def _ballistic_length(begin: Begin, open_stops: Sequence[Stop]) -> float:
    """Time [s] in which a body that leaves a stop at constant acceleration is back, and a bit."""
    _, q, v, a = begin
    lengths = [
        -2.0 * v[stop.index] / a[stop.index]
        for stop in open_stops
        if q[stop.index] == stop.at and stop.rate(v) > 0.0 and stop.rate(a) < 0.0
    ]
    return 1.1 * float(min(lengths, default=np.inf))


def _panel(
    system: System,
    phase: ConstraintSet,
    split: Partition,
    begin: Begin,
    h: float,
    resolution: Resolution,
) -> tuple[Panel, FloatArray, float]:
    """Solve one panel, shortened until it is resolved; with stop forces and the next length."""
    shortest = _SHORTEST_PANEL * system.shaft.period
    kinematic = phase.freedom == 0
    while h > 0.0:
        factor = 0.5
        try:
            if kinematic:
                attempt = kinematic_panel(system, phase, split, begin, h, resolution)
            else:
                solve = integrator(resolution.integrator)
                attempt = solve(system, phase, split, begin, h, resolution)
        except (ConvergenceError, ElementError, SingularConfigurationError):
            # The guess of a long panel may be too far off, or its iteration run away to where the
            # loops do not close; a short one tells the truth.
            if h <= 2.0 * shortest:
                raise
        else:
            panel = attempt.panel
            if panel is not None and _shows_elements(system, phase, panel, resolution):
                return panel, attempt.forces, h * attempt.factor
            factor = min(attempt.factor, 0.5) if panel is not None else attempt.factor
        if h <= shortest:
            break
        h *= factor
    message = (
        f"the motion cannot be resolved: the step falls to {h:.2g} s; a spring or a mass is too "
        "extreme, or a dead centre is near"
    )
    raise ConvergenceError(message, residual=h, tolerance=shortest, iterations=0)
