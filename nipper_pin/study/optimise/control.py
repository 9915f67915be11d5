"""The optimum again, in other ways than the search found it.

The model is loaded by name with the overrides that the result gives out. Bounces come from the
engine that the search did not use; timing and forces come from a simulated turn with its events.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...hybrid.case import Case, Window
from ...hybrid.simulate import simulate
from ...hybrid.solution import Solution
from ...mechanism import Mechanism, load
from ..identify.working import middle_half
from ..sweep.quantities import quantity
from ..transitions import Engine, transition_table
from .problem import Problem
from .quantities import QUANTITIES, lowest

_AT_REST = "at_rest"
# Places in a phase at which a simulated turn is asked for a force or a gap.
_PLACES = 400


def control(problem: Problem, z: FloatArray, engine: str) -> tuple[str, dict[str, float | None]]:
    """Quantities of a problem, found in other ways.

    Args:
        problem: The problem.
        z: Unit coordinates, shape (parameters,).
        engine: Engine that the search used.

    Returns:
        The other engine, and the quantities by name; None for one that cannot be found so.
    """
    mechanism = load(problem.model, problem.overrides(z))
    speed = problem.speed(z)
    other: Engine = "direct" if engine == "reduced" else "reduced"
    found: dict[str, float | None] = dict.fromkeys(problem.quantities)
    if "speed_rpm" in found:
        found["speed_rpm"] = speed
    bounces = _bounces(problem, mechanism, speed, other)
    turn: Mapping[str, Callable[[], float]] = {}
    if any(QUANTITIES[name].source == "cycle" for name in found):
        turn = _turn(mechanism, speed)
    for name in found:
        if name in bounces:
            found[name] = bounces[name]
        elif name in turn:
            found[name] = turn[name]()
    return other, found


def _bounces(
    problem: Problem, mechanism: Mechanism, speed: float, engine: Engine
) -> dict[str, float]:
    try:
        table = transition_table(
            mechanism,
            speed_rpm=speed,
            rest_rate=problem.rest_rate,
            tolerance=problem.tolerance,
            engine=engine,
        )
    except NipperError:
        return {}
    if table.outcome[0] != _AT_REST:
        return {}
    return {
        name: float(quantity(table, name)[0])
        for name, item in QUANTITIES.items()
        if item.source == "transition"
    }


def _turn(mechanism: Mechanism, speed: float) -> Mapping[str, Callable[[], float]]:
    """Quantities of a simulated turn; empty if it has no closing and opening."""
    try:
        solution = simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE))
    except NipperError:
        return {}
    stop = mechanism.transition_stop
    closing = [item.t for item in solution.collisions if item.stop == stop]
    opening = [
        event.t
        for event in solution.events
        if stop in event.closed_before and stop not in event.closed_after
    ]
    if not closing or not opening or not closing[0] < opening[0]:
        return {}
    begin, end = closing[0], opening[0]

    def index(t: float) -> float:
        return mechanism.cylinder.index_from_angle(float(solution.shaft.angle(t)))

    def clamping() -> float:
        places, weights = middle_half(begin, end)
        return float(weights @ solution.trajectory.reactions(places).contacts[stop])

    return {
        "closing_index": lambda: index(begin),
        "opening_index": lambda: index(end),
        "clamping_force_N": clamping,
        "stop_force_N": lambda: _least_stop_force(solution),
        "jaw_opening_deg": lambda: math.degrees(_widest(solution, stop, *solution.trajectory.span)),
        "stroke_mm": lambda: 1e3 * _widest(solution, _waiting(solution), begin, end),
    }


def _open_phases(solution: Solution) -> list[FloatArray]:
    """Places in the intervals in which only the stops of the initial phase are closed."""
    initial = solution.mechanism.phase(solution.mechanism.initial_phase).closed
    return [
        np.linspace(item.t_start, item.t_end, _PLACES)
        for item in solution.phases
        if item.closed == initial
    ]


def _least_stop_force(solution: Solution) -> float:
    stop = _waiting(solution)
    # At the ends of a phase the stop is just being hit or left.
    return min(
        float(lowest(t[1:-1], solution.trajectory.reactions(t[1:-1]).contacts[stop]).min())
        for t in _open_phases(solution)
    )


def _waiting(solution: Solution) -> str:
    """The stop that is closed in the initial phase."""
    (stop,) = solution.mechanism.phase(solution.mechanism.initial_phase).closed
    return stop


def _widest(solution: Solution, stop: str, begin: float, end: float) -> float:
    """Largest coordinate of a stop between two times [rad or m]."""
    column = solution.mechanism.stop(stop).index
    first, last = solution.trajectory.span
    places = np.linspace(max(begin, first), min(end, last), 10 * _PLACES)
    gaps = solution.trajectory.evaluate(places, left=True).q[:, column]
    return -float(lowest(places, -gaps).min())
