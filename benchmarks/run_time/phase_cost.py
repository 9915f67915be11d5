"""Run time of the phases of a turn, and of dynamics and other parts in a transition."""

from __future__ import annotations

from typing import Any

import numpy as np

from nipper_pin.dynamics.impact import collide
from nipper_pin.hybrid.advance import Advance, advance
from nipper_pin.hybrid.case import Case, Resolution, Window
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.segment import Segment
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.hybrid.state import State
from nipper_pin.mechanism import Mechanism

from ..tolerances import START_ROUND_OFF
from .timing import timed

Rows = list[dict[str, Any]]


def phase_cost(mechanism: Mechanism, speed_rpm: float, repeats: int) -> Rows:
    """Cost of each phase of one turn: every segment of a solution is followed again by itself."""
    case = Case(speed_rpm=speed_rpm, window=Window.CYCLE)
    solution = simulate(mechanism, case)
    whole = timed(lambda: simulate(mechanism, case), repeats)
    rows: dict[str, dict[str, Any]] = {}
    for segment in solution.segments:
        phase = mechanism.phase_of(segment.closed)
        name = "other" if phase is None else f"phase {phase.number}, {phase.name}"
        body = solution.system.body
        before = body.evaluations
        again(solution, segment)
        evaluations = body.evaluations - before
        timing = timed(lambda segment=segment: again(solution, segment), repeats)  # type: ignore[misc]
        row = rows.setdefault(name, {"what": name, "wall_ms": 0.0, "evaluations": 0, "segments": 0})
        row["wall_ms"] += timing.median_ms
        row["evaluations"] += evaluations
        row["segments"] += 1
    known = sum(row["wall_ms"] for row in rows.values())
    rest = {
        "what": "start, impacts, changes of phase",
        "wall_ms": max(whole.median_ms - known, 0.0),
        "evaluations": solution.evaluations - sum(row["evaluations"] for row in rows.values()),
        "segments": 0,
    }
    total = {
        "what": "whole turn",
        "wall_ms": whole.median_ms,
        "evaluations": solution.evaluations,
        "segments": len(solution.segments),
    }
    return [*rows.values(), rest, total]


def again(solution: Solution, segment: Segment) -> Advance:
    """Follow one segment again from its first state."""
    system, panel = solution.system, segment.panels[0]
    _, jacobian = system.body.closures(panel.q[:1])
    q = panel.q[0].copy()
    # A stop that has just been left has a gap of exactly zero, the first node one to round-off.
    q[np.abs(q) < START_ROUND_OFF] = 0.0
    motion = system.shaft.driven_at(segment.t_start)
    start = State(segment.t_start, q, panel.v[0], jacobian[0], motion, segment.closed)
    return advance(system, start, panel.a[0], solution.shaft.period, solution.case.resolution)


def transition_parts(
    mechanism: Mechanism, speed_rpm: float, repeats: int, tolerance: float = 1e-9
) -> Rows:
    """Parts of one transition, each repeated by itself with the states of the run.

    The evaluations are Pinocchio's and the shortest loop of Python around them; what is left of the
    flights is the iteration, the roots and the closing of the loops at their ends.
    """
    case = Case(speed_rpm=speed_rpm, resolution=Resolution(tolerance=tolerance))
    solution = simulate(mechanism, case)
    whole = timed(lambda: simulate(mechanism, case), repeats)
    system, flights = solution.system, [s for s in solution.segments if not s.kinematic]
    following = timed(lambda: [again(solution, segment) for segment in flights], repeats)
    panels = [
        (system.forcing(system.shaft.driven(panel.times), rows), panel.q, panel.v, rows)
        for segment in flights
        for rows in [system.constraint_set(segment.closed)]
        for panel in segment.panels
    ]
    nodes = sum(len(q) for _, q, _, _ in panels)
    batch = timed(lambda: [system.respond(*panel) for panel in panels], repeats)
    evaluations = solution.evaluations
    responding = batch.median_ms * evaluations / nodes
    hits = []
    for event in dict.fromkeys(collision.event for collision in solution.collisions):
        names = event.closed_before | set(event.stops)
        stops = [stop for stop in mechanism.stops if stop.name in names]
        jacobian = system.body.closures(event.q[None])[1][0]
        hits.append((event, jacobian, stops, [stop.restitution for stop in stops]))
    impacts = timed(
        lambda: [
            collide(system, event.q, event.v_before, jacobian, stops, e_N)
            for event, jacobian, stops, e_N in hits
        ],
        repeats,
    )
    known = following.median_ms + impacts.median_ms
    return [
        {"what": "evaluations of the dynamics", "wall_ms": responding, "count": evaluations},
        {"what": "flights without them", "wall_ms": following.median_ms - responding,
         "count": len(flights)},
        {"what": "impacts", "wall_ms": impacts.median_ms, "count": len(hits)},
        {"what": "start, limit of the bounces, record",
         "wall_ms": max(whole.median_ms - known, 0.0), "count": 1},
        {"what": "whole transition", "wall_ms": whole.median_ms, "count": 1},
    ]  # fmt: skip
