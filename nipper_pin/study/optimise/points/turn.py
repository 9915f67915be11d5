"""Quantities of a turn that kinematics do not determine: stops that open, long bounces.

With the steeve off its stop, or the jaw still bouncing, the links do not stand where the drives
alone would bring them. The turn is simulated then, and all quantities come from it.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ....errors import SimulationError
from ....hybrid import Event, Solution
from ....mechanism import INDEX_PER_TURN
from ....tolerances.study import SHORT_STRETCH
from ....units import MM_PER_M, S_PER_MIN
from ...identify.problem.working_cycle import WorkingCycle, middle_half
from ...true_transition import TrueTransition
from ..problem.quantities import lowest

# Samples of the stretch between two events.
_SAMPLES = 96


def differs(cycle: WorkingCycle, duration: float, asked: frozenset[str]) -> str:
    """Return why a simulated turn differs from the kinematics of its phases.

    Args:
        cycle: The kinematics.
        duration: Time from the first collision to rest [s].
        asked: Names of the quantities that count.

    Returns:
        One sentence; empty if it does not differ.
    """
    if float(lowest(cycle.clamping.index, cycle.clamping.force).min()) < 0.0:
        return "The closed stop lets go before the machine opens it."
    if "jaw_opening_deg" in asked and cycle.stop_force < 0.0:
        return "The stop of the initial phase lets go while the other is open."
    begin, end = cycle.clamping.index[0], cycle.clamping.index[-1]
    rest = begin + duration * INDEX_PER_TURN * cycle.speed_rpm / S_PER_MIN
    if "clamping_force_N" in asked and rest > begin + 0.25 * (end - begin):
        return "Bounces last into the middle half of the closed phase."
    widest = cycle.clamping.index[max(int(np.argmax(cycle.clamping.gap)) - 1, 0)]
    if "stroke_mm" in asked and rest > widest:
        return "Bounces last until the stroke is largest."
    return ""


def turn_values(found: TrueTransition, *, thin: bool = False) -> dict[str, float]:
    """Quantities of a simulated turn but the stop force, which kinematics define.

    Args:
        found: The transition of turns that repeat.
        thin: Whether curves are looked at in half of the samples.

    Raises:
        SimulationError: The stop does not come to rest, does not open again, or closes twice.
    """
    solution, transition = found.solution, found.transition
    if transition is None:
        raise SimulationError(found.outcome.value, outcome=found.outcome.name)
    mechanism, stop = solution.mechanism, solution.mechanism.transition_stop
    period, first = solution.shaft.period, found.collisions[0]
    before = first.t - (1.0 - SHORT_STRETCH) * period
    if sum(before < item.t_start <= first.t for item in solution.transitions) > 1:
        message = f"the stop {stop} closes more than once in a turn"
        raise SimulationError(message, stop=stop)
    rest, opens = first.t + transition.duration, opening(solution, first.event)
    angle = float(solution.shaft.angle(opens.t))
    begin = solution.trajectory.span[0]
    count = _SAMPLES // 2 if thin else _SAMPLES
    (waiting,) = mechanism.phase(mechanism.initial_phase).closed
    return {
        "closing_index": first.index,
        "opening_index": mechanism.cylinder.index_from_angle(angle),
        "clamping_force_N": _mean_force(solution, stop, (first.t, rest, opens.t)),
        "stroke_mm": MM_PER_M * _widest(solution, waiting, (rest, opens.t), count),
        "jaw_opening_deg": math.degrees(
            _widest(solution, stop, (max(opens.t - period, begin), first.t), count)
        ),
    }


def opening(solution: Solution, first: Event) -> Event:
    """The event at which the transition stop opens after a collision.

    Raises:
        SimulationError: It does not open again.
    """
    stop = solution.mechanism.transition_stop
    for event in solution.events[first.number :]:
        if stop in event.closed_before and stop not in event.closed_after:
            return event
    message = f"the stop {stop} does not open again in the simulated turn"
    raise SimulationError(message, stop=stop)


def _mean_force(solution: Solution, stop: str, times: tuple[float, float, float]) -> float:
    """Mean lip force over the middle half from first collision to opening; none before rest."""
    first, rest, opening = times
    quarter = 0.25 * (opening - first)
    begin, end = max(rest, first + quarter), opening - quarter
    if begin >= end:
        return 0.0
    half = 0.5 * (end - begin)
    # The rule of a middle half, over an interval that is twice as long.
    places, weights = middle_half(begin - half, end + half)
    force = float(weights @ solution.trajectory.reactions(places).contacts[stop])
    return force * half / quarter


def _widest(solution: Solution, stop: str, between: tuple[float, float], count: int) -> float:
    """Largest coordinate of a stop between two times [rad or m]; events in between are ends."""
    index, (begin, end) = solution.mechanism.stop(stop).index, between
    times = [event.t for event in solution.events if begin < event.t < end]
    ends = [begin, *times, end]
    most = 0.0
    for left, right in pairwise(ends):
        if right - left > SHORT_STRETCH * (end - begin):
            t = np.linspace(left, right, count)
            gaps = solution.trajectory.evaluate(t, left=True).q[:, index]
            most = max(most, -float(lowest(t, -gaps).min()))
    return most
