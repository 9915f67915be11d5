"""Motion between two events: one set of closed stops, from a start to the first trigger.

Panel by panel: solve it, check it, find the first trigger on it. The motion ends there, with the
gaps of the stops that close exactly zero, or at a given time.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics import ConstraintSet, Partition, System, close_positions
from ..errors import ConvergenceError, ElementError, SimulationError, SingularConfigurationError
from ..mechanism import Stop
from ..tolerances.hybrid import ROOT_GAP_ROUND_OFF, SHORTEST_PANEL
from .case import Resolution
from .contact.active_set import touching
from .event_location.guards import Trigger, triggers
from .history import Segment, State
from .motion.kinematics import kinematic_panel
from .motion.panel import Begin, Exact, Panel, one_state_at, serves, suited_split
from .motion.picard import flight_panel
from .motion.residual_check import need_described, shows_elements, shows_end

# In one phase; a whole turn of a comber has thirty.
_MOST_PANELS = 10_000
# What drives alone determine is smoother than flights: panels have more nodes and are longer, the
# more so once one has shown it.
_LONGER_WITHOUT_FREEDOM, _LONGER_STILL = 2.5, 1.25
# Flights are a bit shorter than the panels that are made for them. Round-off of a gap goes with the
# square of the panel's length: of a panel that is so much longer it is a thousandfold.
_BALLISTIC_MARGIN, _MUCH_TOO_LONG = 1.1, 64.0


class Advance(NamedTuple):
    """What :func:`advance` has found.

    Attributes:
        triggers: Simultaneous triggers that end the motion, by stop; none at the time limit.
        end: State at its end (left limit).
    """

    segment: Segment
    triggers: tuple[Trigger, ...]
    end: State


def advance(
    system: System,
    state: State,
    a: FloatArray | None,
    t_limit: float,
    resolution: Resolution,
    place: int = 0,
    watched: Collection[str] | None = None,
) -> Advance:
    """Follow the motion from a state just after an event to the next event.

    Args:
        state: The state; gaps of stops just left are exactly zero.
        a: Acceleration there, shape (nv,); None in a phase without freedom, which needs none.
        t_limit: Where to stop at the latest [s].
        place: Place of the motion among the segments of the run.
        watched: Names of the stops that end it; all if there are none.

    Raises:
        SimulationError: The motion cannot be followed.
    """
    way = _Way(system, state, t_limit, resolution, watched)
    known = np.full_like(state.v, np.nan) if a is None else a
    begin = Begin(state.t, state.q, state.v, known, state.jacobian)
    h = way.first
    if not way.kinematic:
        h = min(h, _ballistic_length(begin, way.phase.open))
    panels: list[Panel] = []
    while True:
        solved = way.solve(begin, way.length(begin.t, h))
        if len(panels) >= _MOST_PANELS:
            raise way.too_many(begin, solved.panel.h)
        end = way.end(solved)
        suited = way.suited(solved.panel, begin.jacobian, end)
        shown = way.shown(solved.panel, end)
        if (suited is None or not shown) and end.t - begin.t > 4.0 * way.shortest:
            # The same motion in shorter panels: they see what happens at its end, and each has the
            # coordinates that suit it.
            h = 0.5 * (end.t - begin.t)
            continue
        if not panels and way.much_too_long(solved.panel, end):
            h = max(_BALLISTIC_MARGIN * (end.t - begin.t), 2.0 * way.shortest)
            continue
        panel = solved.panel
        if suited is not None and suited != panel.split:
            panel = replace(panel, split=suited)
            end = way.end(solved._replace(panel=panel))
        panels.append(panel)
        if end.found or end.t >= t_limit:
            return way.closed_up(panels, end, place)
        q, v, jacobian, _ = end.exact
        begin = Begin(begin.t + panel.h, q, v, panel.a[-1], jacobian)
        h = min(way.longest, solved.advised)


class _Solved(NamedTuple):
    """A panel, the forces of its stops at its nodes, and the length of the next one [s]."""

    panel: Panel
    forces: FloatArray
    advised: float


class _End(NamedTuple):
    """First triggers on a panel, and time and state there; without any, at its end."""

    found: tuple[Trigger, ...]
    t: float
    exact: Exact


class _Way:
    """Phase, limits and checks of the motion from one event to the next."""

    def __init__(
        self,
        system: System,
        state: State,
        t_limit: float,
        resolution: Resolution,
        watched: Collection[str] | None,
    ) -> None:
        """Find what the phase asks for."""
        self._watched = watched
        self._system, self._state = system, state
        self._t_limit, self._resolution = t_limit, resolution
        self.phase = phase = system.constraint_set(state.closed)
        self.kinematic = phase.freedom == 0
        self.longest = system.shaft.period / resolution.panels_per_turn
        self.first = self.longest
        if self.kinematic:
            self.first *= _LONGER_WITHOUT_FREEDOM
            self.longest = self.first * _LONGER_STILL
        self.shortest = SHORTEST_PANEL * system.shaft.period
        # A stop that has just been left is independent, so that its gap keeps its relative
        # precision: a coordinate that the others determine has their errors, multiplied.
        leaving = sorted(phase.open, key=lambda stop: stop.gap(state.q) != 0.0)
        self._preferred = (*phase.yielding, *(stop.index for stop in leaving))

    def length(self, t: float, h: float) -> float:
        """Length of a panel that begins at t and should have the length h [s]."""
        left = self._t_limit - t
        h = min(h, left, self._system.shaft.smooth_for(t))
        # Round-off of a sum of panels must not leave one that holds nothing but round-off.
        return left if left - h < self.shortest else h

    def solve(self, begin: Begin, h: float) -> _Solved:
        """Solve a panel from ``begin``, at most of the length h [s]."""
        choose = self._system.split if self.kinematic else self._system.good_partition
        try:
            split = choose(begin.jacobian, self.phase.given, self._preferred)
            return self._resolved(split, begin, h)
        except SimulationError as error:
            evidence = {**error.evidence, "t": begin.t, "q": begin.q}
            raise type(error)(error.message, **evidence) from error

    def end(self, solved: _Solved) -> _End:
        """Find the first triggers on a panel, and the state there or at its end."""
        panel = solved.panel
        found = triggers(self._system, self.phase, panel, solved.forces, self._watched)
        t = found[0].t if found else min(panel.t + panel.h, self._t_limit)
        need_described(self._system, panel, found[0].t if found else self._t_limit)
        return _End(found, t, one_state_at(self._system, self.phase, panel, t))

    def suited(self, panel: Panel, jacobian: FloatArray, end: _End) -> Partition | None:
        """Coordinates that suit a panel up to its end; None if it has to be shorter."""
        if self.kinematic:
            return panel.split
        if serves(self._system, panel, jacobian, end.exact.jacobian):
            return panel.split
        return suited_split(self._system, self.phase, panel, end.exact.jacobian, self._preferred)

    def shown(self, panel: Panel, end: _End) -> bool:
        """Return whether a flight panel shows what happens at the event that ends it."""
        if self.kinematic or not end.found or not self._resolution.adaptive:
            return True
        return shows_end(self._system, self.phase, panel, self._resolution.tolerance, end.t)

    def closed_up(self, panels: list[Panel], end: _End, place: int) -> Advance:
        """The motion to its end, where the gaps of the stops that close are exactly zero."""
        state = self._state
        closed, kinematic = self.phase.closed, self.kinematic
        segment = Segment(state.t, end.t, closed, tuple(panels), kinematic, place)
        names = [item.stop for item in end.found if item.closes]
        hit = [self._system.mechanism.stop(name) for name in names]
        if hit:
            hit += touching(self._system, end.exact.q, end.exact.v, self.phase.open, names)
        last = _closed_up(self._system, self.phase, end.exact, hit) if hit else end.exact
        return Advance(segment, end.found, State(end.t, *last, state.closed, state.series))

    def much_too_long(self, panel: Panel, end: _End) -> bool:
        """Return whether a flight ends so early that the round-off of its panel moves its end."""
        if self.kinematic or not end.found:
            return False
        return _MUCH_TOO_LONG * max(end.t - panel.t, self.shortest) < panel.h

    def too_many(self, begin: Begin, h: float) -> ConvergenceError:
        """The error of a phase that needs too many panels."""
        message = (
            f"one phase needs more than {_MOST_PANELS} panels: a drive train or a spring "
            "swings many times, the nodes are too few for the tolerance, or a dead centre is "
            "near"
        )
        return ConvergenceError(
            message, residual=h, tolerance=self._resolution.tolerance,
            iterations=_MOST_PANELS + 1, t=begin.t, q=begin.q,
        )  # fmt: skip

    def _resolved(self, split: Partition, begin: Begin, h: float) -> _Solved:
        """Solve one panel, made shorter until its nodes and the checks find it resolved."""
        system, phase, resolution = self._system, self.phase, self._resolution
        solve = kinematic_panel if self.kinematic else flight_panel
        while h > 0.0:
            factor = 0.5
            try:
                attempt = solve(system, phase, split, begin, h, resolution)
            except (ConvergenceError, ElementError, SingularConfigurationError):
                # The guess of a long panel may be too far off, or its iteration run away to where
                # the loops do not close; of a short one it is an error of the motion.
                if h <= 2.0 * self.shortest:
                    raise
            else:
                panel = attempt.panel
                if panel is not None and (
                    not resolution.adaptive
                    or shows_elements(system, phase, panel, resolution.tolerance)
                ):
                    return _Solved(panel, attempt.forces, h * attempt.factor)
                factor = min(attempt.factor, 0.5) if panel is not None else attempt.factor
            if h <= self.shortest:
                break
            h *= factor
        message = (
            f"the motion cannot be resolved: the step falls to {h:.2g} s; a spring or a mass is "
            "too extreme, or a dead centre is near"
        )
        raise ConvergenceError(message, residual=h, tolerance=self.shortest, iterations=0)


def _closed_up(system: System, phase: ConstraintSet, end: Exact, hit: list[Stop]) -> Exact:
    """The end of a segment with the gaps of the stops that it ends at exactly zero."""
    met = end.q
    units = system.body.unit_of
    left = max(abs(stop.gap(met)) / units[stop.index] for stop in hit)
    for stop in hit:
        met[stop.index] = stop.at
    if left <= ROOT_GAP_ROUND_OFF:
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
    _, q, v, a, _ = begin
    lengths = [
        -2.0 * v[stop.index] / a[stop.index]
        for stop in open_stops
        if q[stop.index] == stop.at and stop.rate(v) > 0.0 and stop.rate(a) < 0.0
    ]
    return _BALLISTIC_MARGIN * float(min(lengths, default=np.inf))
