"""Targets of an identification: quantities of transitions, or their changes between two.

All are computed by the direct engine, also those of whole turns: every evaluation of a fit is
another machine, whose tables of turns (163 ms of processor time for the E62) pay from six settings
on that do not arrive as a transition assumes (28 ms each). Hardly any problem has as many.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....errors import InputError, SimulationError
from ....hybrid import Case, Collision, Outcome, Resolution, Solution, Transition, simulate
from ....hybrid.result.premise import Premise
from ....hybrid.result.quantities import of_transition
from ....mechanism import Mechanism, retuned
from ...true_transition import true_transition

QUANTITIES = (
    *(f"{name}_{k}" for name in ("rebound_amplitude", "rebound_time_s") for k in (1, 2, 3)),
    "duration_s",
    "first_two_share",
    "approach_rate_1",
)
"""Quantities of a transition, as in :mod:`nipper_pin.hybrid.result.quantities`: rebounds of the
transition stop in rad (or m) and s, the time from the first collision to rest in s, the share of
the first two rebounds in it, and the rate at which the stop closes first."""


class Condition(NamedTuple):
    """Settings of one transition; None leaves the model's own value.

    Attributes:
        restitution: Of the transition stop.
        stiffness: Of the only spring [N/m or N m/rad]; its preload length is kept.
    """

    speed_rpm: float
    restitution: float | None = None
    stiffness: float | None = None


def stiffness_name(mechanism: Mechanism) -> str:
    """Name of the stiffness of the only spring in a setting, with its unit.

    Args:
        mechanism: The mechanism; without just one spring it is the name for a slide.
    """
    springs, kinds = mechanism.springs, {item.index: item.kind for item in mechanism.joints}
    on_a_hinge = len(springs) == 1 and kinds[springs[0].index] == "revolute"
    return "stiffness_N_m_per_rad" if on_a_hinge else "stiffness_N_per_m"


@dataclass(frozen=True, kw_only=True)
class Target:
    """One number to come out.

    Attributes:
        name: Name for tables.
        quantity: One of :data:`QUANTITIES`.
        at: Settings of the transition.
        since: Settings of a second one: the target is the relative change from it to ``at``,
            (new - old) / old. None: the quantity itself.
        value: The value wanted.
        sigma: Its standard deviation, in the unit of the value.
    """

    name: str
    quantity: str
    at: Condition
    since: Condition | None = None
    value: float
    sigma: float


def conditions(targets: Iterable[Target]) -> tuple[Condition, ...]:
    """Return the different settings of some targets; two targets share a transition."""
    found: dict[Condition, None] = {}
    for target in targets:
        found[target.at] = None
        if target.since is not None:
            found[target.since] = None
    return tuple(found)


def predict(
    mechanism: Mechanism,
    targets: Sequence[Target],
    tolerance: float,
    rest_rate: float | None,
    *,
    true: bool = False,
) -> FloatArray:
    """Values that a mechanism gives for some targets.

    Args:
        tolerance: Relative accuracy of the transitions.
        rest_rate: Separation rate at which a transition ends; None: at its limit.
        true: Whether the transition of the turn is taken where the machine does not arrive as a
            transition assumes, which has to be found out and is slow.

    Returns:
        Values, shape (targets,).

    Raises:
        SimulationError: A transition cannot be simulated or has no such quantity.
        InputError: A setting cannot be used.
    """
    known = {
        at: transition_quantities(mechanism, at, tolerance, rest_rate, true=true)
        for at in conditions(targets)
    }
    values = np.empty(len(targets))
    for place, target in enumerate(targets):
        value = known[target.at][target.quantity]
        if target.since is not None:
            old = known[target.since][target.quantity]
            value = (value - old) / old if old else math.nan
        values[place] = value
    if not np.isfinite(values).all():
        missing = [target.name for target, x in zip(targets, values, strict=True) if x != x]
        message = (
            f"{mechanism.name}: the transition has no value for {', '.join(missing)}; leave these "
            "targets out or change the settings"
        )
        raise SimulationError(message, targets=missing)
    return values


def transition_quantities(
    mechanism: Mechanism,
    at: Condition,
    tolerance: float,
    rest_rate: float | None,
    *,
    true: bool,
) -> dict[str, float]:
    """All quantities of one transition; NaN where there are fewer rebounds.

    Args:
        at: Settings of the transition; further arguments are those of :func:`predict`.

    Raises:
        SimulationError: The transition cannot be simulated, or does not come to rest.
        InputError: A setting cannot be used.
    """
    machine, case = with_settings(mechanism, at), _case(at, tolerance, rest_rate)
    if true:
        found = true_transition(machine, case)
        outcome, run = found.outcome, (found.solution, found.collisions, found.transition)
    else:
        solution = simulate(machine, case)
        hits = tuple(hit for hit in solution.collisions if hit.stop == mechanism.transition_stop)
        first = solution.transitions[0] if solution.transitions else None
        outcome, run = solution.outcome, (solution, hits, first)
    if outcome is not Outcome.AT_REST:
        message = f"{mechanism.name} at {at.speed_rpm:g} r/min: {outcome.value}"
        raise SimulationError(message, condition=at._asdict())
    return _quantities(*run)


def premises(
    mechanism: Mechanism, targets: Sequence[Target], tolerance: float, rest_rate: float | None
) -> dict[Condition, Premise]:
    """Say for each setting whether the machine arrives as a transition assumes.

    Raises:
        SimulationError: A transition cannot be simulated.
    """
    return {
        at: simulate(with_settings(mechanism, at), _case(at, tolerance, rest_rate)).premise
        for at in conditions(targets)
    }


def _case(at: Condition, tolerance: float, rest_rate: float | None) -> Case:
    return Case(
        speed_rpm=at.speed_rpm,
        rest_rate=rest_rate,
        resolution=Resolution(tolerance=tolerance),
        max_collisions=500,
    )


def with_settings(mechanism: Mechanism, at: Condition) -> Mechanism:
    """Return the mechanism with other settings; its tree does not depend on them.

    Args:
        at: Restitution and stiffness; its speed is left to the caller.

    Raises:
        InputError: A stiffness is given, and the mechanism has not just one spring.
    """
    if at.stiffness is not None and len(mechanism.springs) != 1:
        message = (
            f"{mechanism.name} has {len(mechanism.springs)} springs: a stiffness in a target "
            "needs a model with one"
        )
        raise InputError(message, springs=[spring.name for spring in mechanism.springs])
    e_N, k = at.restitution, at.stiffness
    return retuned(
        mechanism,
        restitution=None if e_N is None else {mechanism.transition_stop: e_N},
        stiffness=None if k is None else [k],
    )


def _quantities(
    solution: Solution, hits: Sequence[Collision], transition: Transition | None
) -> dict[str, float]:
    found = dict.fromkeys(QUANTITIES, math.nan)
    for name in QUANTITIES:
        quantity, place = of_transition(name)
        subject = transition if not place else hits[place - 1] if place <= len(hits) else None
        if subject is not None and quantity.read is not None:
            value = quantity.read(solution, subject)  # type: ignore[arg-type]
            found[name] = math.nan if value is None else value
    return found
