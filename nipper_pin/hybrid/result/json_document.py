"""A solution as one plain document: the layout that scripts rely on (docs/json.md).

A run that does not pass its own checks is refused, not printed.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, astuple, fields
from typing import Any

import numpy as np

from ...errors import SelfCheckError
from ...mechanism import Mechanism, number_of
from ...tolerances.hybrid import SELF_CHECK, SELF_CHECK_TOLERANCES, SHORTEST_PANEL, STORED_ENERGY
from ..case import Case
from .quantities import COLLISION, TRANSITION
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


def need_sound(solution: Simulated) -> None:
    """Refuse a run whose closures gape, or whose energy comes from nowhere.

    The gap is compared with the reach of the mechanism, and the energy that is left over with the
    sum of all terms of the balance.

    Raises:
        SelfCheckError: A residual is not a number, or far above the tolerance of the run.
    """
    allowed = SELF_CHECK + SELF_CHECK_TOLERANCES * solution.case.resolution.tolerance
    system, energy = solution.system, solution.energy
    work = allowed * sum(map(abs, astuple(energy))) + STORED_ENERGY * _stored(solution)
    for name, unit, found, most in (
        ("the closures gape by", "m", solution.checks.closure_m, allowed * system.body.reach_m),
        ("the energy balance leaves over", "J", abs(energy.residual), work),
    ):
        if found <= most:
            continue
        message = (
            f"this run fails its own check: {name} {found:.2g} {unit}, and at most {most:.2g} "
            f"{unit} would be right; its numbers are not to be used: check the lengths and masses "
            "of the model, or report it with the model"
        )
        raise SelfCheckError(message, check=name, residual=found, tolerance=most)


def _stored(solution: Simulated) -> float:
    """Energy [J] of springs and weights, of which the balance has small differences."""
    system, model = solution.system, solution.mechanism.model
    seen = [event.q for event in solution.events]
    for segment in solution.segments[:1] + solution.segments[-1:]:
        seen += [segment.panels[0].q[0], segment.panels[-1].q[-1]]
    q = np.array(seen).reshape(len(seen), system.body.nv)
    stored = np.abs(system.spring_energy(q)) + np.abs(system.body.gravity_energy(q))
    # Heights are sums of lengths.
    mass = sum(float(link.mass) for link in list(model.inertias)[1:])
    lifted = mass * abs(solution.mechanism.gravity_m_s2) * system.body.reach_m
    return float(stored.max(initial=0.0)) + lifted
