"""From a mechanism to the model of its whole turns, if the reduced engine can follow them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...dynamics import DriveMode, ShaftMotion, System
from ...errors import InputError
from ...hybrid import START_INDEX, comes_back, initial_state
from ...mechanism import Mechanism, Stop
from ...tolerances.reduced import GAP_SHARE, TURN_TABLES
from ..kernels.layout import Charts
from ..model import LIVELY, Tabulated, lively_speed, numbers_of
from ..tables.tables import Chart, stacked
from .arcs import ContactContinuation, system_at
from .charts import ChartSampler, chart_of


def unfit_turns(mechanism: Mechanism, drive: DriveMode | str = DriveMode.HELD) -> str | None:
    """Return why the turns of a mechanism cannot be reduced.

    Args:
        drive: Behaviour of the driven shafts.

    Returns:
        One sentence, or None if they can be.
    """
    if drive != DriveMode.HELD:
        return "the reduced engine needs held drives: inertial shafts move on their own"
    free = mechanism.degrees_of_freedom - len(mechanism.drives)
    if free != 1:
        return f"the reduced engine needs one degree of freedom in flight, and {free} are left"
    driven = {item.index for item in mechanism.drives}
    for stop in mechanism.stops:
        if stop.leader:
            return f"the reduced engine has one stop where {stop.leader} and {stop.name} close both"
        if stop.law is not None:
            return f"the reduced engine has constant restitutions, and stop {stop.name!r} has a law"
        if stop.index in driven:
            return f"stop {stop.name!r} is on a driven coordinate: it cannot bounce"
    law = next((f"{item.kind} {item.name!r}" for item in mechanism.forces), None)
    if law is not None:
        return f"the reduced engine has springs and linear dampers only, no {law}"
    return None


# Of a turn: chart, gap, its rate by time and by the cylinder, and whether its stop is closed.
Begin = tuple[int, float, float, float, bool]
# Gap of a chart that no other meets, and least gap of any, by that at which another stop closes.
_USUAL_SHARE, _LEAST_SHARE = 0.25, 1.0 / 16.0


@dataclass(frozen=True, kw_only=True)
class TurnModel(Tabulated):
    """Functions of one mechanism around the stretches of a turn on which a stop can be closed.

    Attributes:
        stops: Names of the stops.
        transition_stop: Name of the transition stop.
        start_index: Index at which turns start.
        begin: How they start.
    """

    stops: tuple[str, ...]
    transition_stop: str
    start_index: float
    begin: Begin

    @property
    def clamp(self) -> int:
        """Place of the transition stop, which clamps, among the stops."""
        return self.stops.index(self.transition_stop)


def build_turns(
    mechanism: Mechanism, start_index: float = START_INDEX, gap_scale: float = 1.0
) -> TurnModel:
    """Sample the model of whole turns.

    Args:
        start_index: Index at which turns start.
        gap_scale: Factor on the gaps that the tables cover.

    Raises:
        InputError: The mechanism cannot be reduced.
        SimulationError: A point cannot be reached or is singular.
    """
    around, begin = surroundings(mechanism, start_index)
    return TurnModel(
        **numbers_of(mechanism),
        stops=tuple(item.name for item in mechanism.stops),
        transition_stop=mechanism.transition_stop,
        start_index=start_index,
        charts=charts_of(around, TURN_TABLES, gap_scale=gap_scale),
        begin=begin,
    )


def surroundings(mechanism: Mechanism, start_index: float) -> tuple[list[ChartSampler], Begin]:
    """Follow the stops along a turn: what is known around every arc, and how the turn starts."""
    reason = unfit_turns(mechanism)
    if reason is not None:
        message = f"{mechanism.name}: {reason}; use the direct engine"
        raise InputError(message, model=mechanism.name)
    angle = mechanism.cylinder.angle_from_index(start_index)
    system = system_at(mechanism, 0.0, angle)
    if not comes_back(system):
        message = f"{mechanism.name}: the drives do not come back with the cylinder"
        raise InputError(message)
    state = initial_state(system, start_index, mechanism.starts)
    walk = ContactContinuation(mechanism, angle)
    stop, home, closed = _standing(mechanism, walk, state.q)
    # Arcs of the stops that follow that one, and of those opposite.
    chains = [list(walk.around(stop, home))]
    if len({arc.stop.name for arc in chains[0]}) < len(mechanism.stops):
        far = walk.opposite(stop, home)
        chains += [] if far is None else [list(walk.around(*far))]
    around: list[ChartSampler] = []
    for chain in chains:
        first = len(around)
        after = [*range(first + 1, first + len(chain)), first]
        around += [
            ChartSampler(mechanism, arc, angle, to) for arc, to in zip(chain, after, strict=True)
        ]
    # What [initial] gives, and what the cylinder adds by its speed.
    twice = System(mechanism, ShaftMotion(mechanism, 2.0, angle))
    fast = stop.rate(initial_state(twice, start_index, mechanism.starts).v)
    slow = stop.rate(state.v)
    return around, (0, stop.gap(state.q), 2.0 * slow - fast, fast - slow, closed)


def _standing(
    mechanism: Mechanism, walk: ContactContinuation, q: FloatArray
) -> tuple[Stop, FloatArray, bool]:
    """The stop that turns start from, the configuration with it closed, and whether it is."""
    if not mechanism.stops:
        message = f"{mechanism.name}: turns of the reduced engine need a stop, and there is none"
        raise InputError(message)
    closed = mechanism.phase(mechanism.initial_phase).closed
    if len(closed) > 1:
        message = f"{mechanism.name}: turns of the reduced engine start with one stop closed"
        raise InputError(message, closed=sorted(closed))
    if closed:
        return mechanism.stop(next(iter(closed))), q, True
    stop = min(mechanism.stops, key=lambda item: item.gap(q))
    return stop, walk.closing(stop, q), False


def charts_of(
    around: list[ChartSampler], tolerance: float, *, gap_scale: float = 1.0,
    of_gaps: float = GAP_SHARE, first: Chart | None = None,
) -> Charts:  # fmt: skip
    """Sample the tables around the arcs of a turn.

    Args:
        gap_scale: Factor on the gaps that the tables cover.
        of_gaps: Relative accuracy of the gaps of other stops.
        first: Tables around the first arc, where they are known.
    """
    found = [] if first is None else [around[0].placed(first)]
    asked = list(zip(around, _reach(around), strict=True))[len(found) :]
    found += [chart_of(item, gap_scale * gap, w, tolerance, of_gaps) for item, (gap, w) in asked]
    return stacked(around[0].mechanism, found)


def _reach(around: list[ChartSampler]) -> list[tuple[float, float]]:
    """Largest gap of each chart, and usual rates in it."""
    gaps, rates = np.zeros(len(around)), np.zeros(len(around))
    for item in around:
        to, mechanism = item.after, item.mechanism
        w = LIVELY * abs(item.meets[0]) * lively_speed(mechanism)
        rates[to] = max(rates[to], w)
        gaps[to] = max(gaps[to], around[to].rebound(w))
    # Where stops meet slowly, a stop that is released flies higher than after their collision.
    for number, item in enumerate(around):
        if gaps[number] > 0.0:
            gaps[number] = max(gaps[number], _LEAST_SHARE * item.room)
    # The charts of one stop are alike, and those of two that meet are crossed by the same flights.
    for _ in range(2):
        for number, item in enumerate(around):
            to, throw = item.after, item.meets[2] or 1.0
            widest = max(gaps[number], throw * gaps[to])
            fastest = max(rates[number], throw * rates[to])
            gaps[number], gaps[to] = widest, widest / throw
            rates[number], rates[to] = fastest, fastest / throw
    for number, item in enumerate(around):
        if gaps[number] == 0.0:
            gaps[number] = _USUAL_SHARE * item.room
            rates[number] = math.sqrt(2.0 * abs(item.terms(0.0).sum()) * gaps[number])
        if not gaps[number] > 0.0:
            message = (
                f"{mechanism.name}: nothing tells how far stop {item.arc.stop.name!r} opens, so "
                "that the reduced engine cannot follow turns; use the direct engine"
            )
            raise InputError(message, stop=item.arc.stop.name)
    return list(zip(gaps.tolist(), rates.tolist(), strict=True))
