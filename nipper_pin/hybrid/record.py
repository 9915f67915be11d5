"""A solution as one plain document: the layout that scripts rely on (docs/json.md)."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from .collisions import Collision
from .solution import Solution


def record(solution: Solution) -> dict[str, Any]:
    """Return a solution as plain data.

    Times count from the first collision [s] (from the start of the run if there is none). A value
    that the window does not contain is None.

    Args:
        solution: The solution.

    Returns:
        The document: ``case``, ``outcome``, ``collisions``, ``phases``, ``transition``, ``checks``
        and ``work``.
    """
    origin = solution.collisions[0].t if solution.collisions else 0.0
    transition = solution.transitions[0] if solution.transitions else None
    stop = solution.mechanism.transition_stop
    return {
        "case": {
            "model": solution.mechanism.name,
            **asdict(solution.case),
            **{
                path.rpartition(".")[2]: _value(solution.mechanism.description, path)
                for path in solution.mechanism.shortcuts.values()
            },
        },
        "outcome": solution.outcome.value,
        "collisions": [
            {
                **_collision(item, origin),
                "time_error_s": solution.errors[item.event.number - 1].time,
                "impulse_error": solution.errors[item.event.number - 1].impulse,
            }
            for item in solution.collisions
        ],
        "phases": [
            {
                "phase": item.number,
                "closed_stops": sorted(item.closed),
                "start_s": item.t_start - origin,
                "end_s": item.t_end - origin,
            }
            for item in solution.phases
        ],
        "transition": {
            "premise_holds": solution.premise_holds,
            "duration_s": transition.duration if transition else None,
            "collisions": (
                transition.collisions
                if transition
                else sum(item.stop == stop for item in solution.collisions)
            ),
            "first_two_share": transition.first_two_share if transition else None,
        },
        "checks": asdict(solution.checks),
        "work": {
            "engine": "direct",
            "evaluations": solution.evaluations,
            "wall_s": solution.wall_s,
            "turns_computed": solution.repeated_from or solution.case.cycles,
        },
    }


def _collision(item: Collision, origin: float) -> dict[str, Any]:
    return {
        "number": item.number,
        "stop": item.stop,
        "time_s": item.t - origin,
        "cylinder_angle_rad": item.cylinder_angle,
        "index": item.index,
        "approach_rate": item.approach_rate,
        "separation_rate": item.separation_rate,
        "impulse_N_s": item.impulse,
        "energy_lost_J": item.energy_lost,
        "rebound_amplitude": item.rebound_amplitude,
        "rebound_time_s": item.rebound_time,
    }


def _value(description: Any, path: str) -> Any:
    for key in path.split("."):
        description = description[key]
    return description
