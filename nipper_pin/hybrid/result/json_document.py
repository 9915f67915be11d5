"""A solution as one plain document: the layout that scripts rely on (docs/json.md)."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, fields
from typing import Any

from ...mechanism import Mechanism, number_of
from ...tolerances.hybrid import SHORTEST_PANEL
from ..case import Case
from .quantities import COLLISION, TRANSITION
from .self_check import need_sound
from .simulated import Simulated
from .tables import Collision


def record(solution: Simulated) -> dict[str, Any]:
    """Return a solution as plain data.

    Times t count from the start of the run [s]; ``time_s``, ``start_s`` and ``end_s`` from the
    first collision, where there is one. A value that the window does not contain is None.

    Args:
        solution: The solution.

    Returns:
        The document: ``case``, ``outcome``, ``collisions``, ``phases``, ``transition``, ``checks``
        and ``work``; and ``warnings`` where there are any.

    Raises:
        SelfCheckError: The run does not meet its closures or its energy balance.
    """
    need_sound(solution)
    origin = solution.collisions[0].t if solution.collisions else 0.0
    transition = solution.transitions[0] if solution.transitions else None
    return {
        "case": {
            "model": solution.mechanism.name,
            **asdict(solution.case),
            **_shortcuts(solution.mechanism),
        },
        "outcome": solution.outcome.value,
        **({"warnings": list(solution.warnings)} if solution.warnings else {}),
        "collisions": [_collision(solution, item) for item in solution.collisions],
        "phases": [
            {
                "phase": item.number,
                "closed_stops": sorted(item.closed),
                "t_start_s": item.t_start,
                "t_end_s": item.t_end,
                "start_s": item.t_start - origin,
                "end_s": item.t_end - origin,
            }
            for item in solution.phases
        ],
        "transition": {
            item.name: item.read(solution, transition) for item in TRANSITION if item.read
        },
        "checks": asdict(solution.checks),
        "work": {
            "engine": "direct",
            "evaluations": solution.evaluations,
            "wall_s": solution.wall_s,
            "turns_computed": _turns_computed(solution),
        },
    }


def _turns_computed(solution: Simulated) -> int:
    """Turns that were begun; copies of an earlier one are none."""
    end = solution.segments[-1].t_end if solution.segments else 0.0
    # Shorter than what is resolved, of each turn before, is no further turn.
    begun = max(math.ceil(end / solution.shaft.period * (1.0 - SHORTEST_PANEL)), 1)
    return min(solution.repeated_from or solution.case.cycles, begun)


def _collision(solution: Simulated, item: Collision) -> dict[str, Any]:
    return {
        "number": item.number,
        "stop": item.stop,
        **{
            quantity.name: quantity.read(solution, item)
            for quantity in COLLISION
            if quantity.read and quantity.fits(solution.mechanism, item.stop)
        },
    }


def _shortcuts(mechanism: Mechanism) -> dict[str, float]:
    """Numbers that have shortcuts: by the last step of their path; by all of it if two share it."""
    paths = set(mechanism.shortcuts.values())
    last = Counter(path.rpartition(".")[2] for path in paths)
    taken = {
        "model",
        *(item.name for item in fields(Case)),
        *(key for key in last if last[key] > 1),
    }
    found = {}
    for path in mechanism.shortcuts.values():
        key = path.rpartition(".")[2]
        found[path if key in taken else key] = number_of(mechanism, path)
    return found
