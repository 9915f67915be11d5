"""Does a run pass its own checks? One that does not is refused, not printed."""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from ...errors import SelfCheckError
from ...tolerances.hybrid import SELF_CHECK, SELF_CHECK_TOLERANCES, STORED_ENERGY

if TYPE_CHECKING:
    from .simulated import Simulated


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
