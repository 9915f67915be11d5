"""Balls in a row on one line: each slides on the one before, and stops hold them apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from small_machines import link, machine, slide

from nipper_pin import Mechanism
from nipper_pin.dynamics import Impact, ShaftMotion, System
from nipper_pin.dynamics.impact_laws import solve_impact


def row(
    masses: Sequence[float], restitution: Sequence[float] | float, *, wall: bool = False,
    law: str = "newton", **tables: Any,
) -> Mechanism:  # fmt: skip
    """Balls upwards along z; stop ``s<i>`` is below ball i, and ``s0`` is the wall.

    Args:
        masses: From the wall on [kg].
        restitution: Of each stop, or of all.
        wall: Whether the first ball has one.
        law: ``simultaneous`` of the model.
        **tables: Further tables of the description.
    """
    given = [restitution] * len(masses) if isinstance(restitution, float) else restitution
    e_N = dict(enumerate(given, start=0 if wall else 1))
    parts, stops, parent = [], {}, "frame"
    for number, mass in enumerate(masses):
        name = f"ball{number}"
        parts += [link(name, float(mass)), slide(f"z{number}", parent, name, (0.0, 1.0))]
        if wall or number:
            stops[f"s{number}"] = {"joint": f"z{number}", "restitution": float(e_N[number])}
        parent = name
    return machine(parts, len(masses), stops=stops, simultaneous=law, **tables)


def struck(mechanism: Mechanism, velocities: Sequence[float]) -> tuple[np.ndarray, Impact]:
    """Velocities [m/s] of balls that all touch after they have had some, and the impact."""
    system = System(mechanism, ShaftMotion(mechanism, 1.0, 0.0))
    v = np.diff(np.concatenate([[0.0], velocities]))
    impact = solve_impact(system, np.zeros_like(v), v, np.empty((0, len(v))), mechanism.stops)
    return np.cumsum(impact.v_after), impact
