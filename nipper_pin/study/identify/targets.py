"""What an identification aims at: quantities of transitions, alone or as changes between two."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError, SimulationError, UnknownNameError
from ...hybrid.case import Case, Resolution
from ...hybrid.quantities import refuse_unknown, transition_value
from ...hybrid.simulate import simulate
from ...hybrid.solution import Outcome, Solution
from ...mechanism import Mechanism

QUANTITIES = (
    *(f"{name}_{k}" for name in ("rebound_amplitude", "rebound_time_s") for k in (1, 2, 3)),
    "duration_s",
    "first_two_share",
    "approach_rate_1",
)
"""Quantities of a transition (:mod:`nipper_pin.hybrid.quantities`): rebounds of the transition stop
in rad (or m) and s, the time from the first collision to rest in s, the share of the first two
rebounds in it, and the rate at which the stop closes first."""

_COLUMNS = ("speed_rpm", "restitution", "stiffness", "quantity", "value", "sigma")
_NEEDED = ("speed_rpm", "quantity", "value", "sigma")


class Condition(NamedTuple):
    """Settings of one transition; None leaves the model's own value.

    Attributes:
        speed_rpm: Cylinder speed [r/min].
        restitution: Of the transition stop.
        stiffness: Of the only spring [N/m or N m/rad]; its preload length is kept.
    """

    speed_rpm: float
    restitution: float | None = None
    stiffness: float | None = None


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
    mechanism: Mechanism, targets: Sequence[Target], tolerance: float, rest_rate: float | None
) -> FloatArray:
    """Values that a mechanism gives for some targets.

    Args:
        mechanism: The mechanism.
        targets: The targets.
        tolerance: Relative accuracy of the transitions.
        rest_rate: Separation rate at which a transition ends; None: at its limit.

    Returns:
        Values, shape (targets,).

    Raises:
        SimulationError: A transition cannot be simulated or has no such quantity.
        InputError: A setting cannot be used.
    """
    known = {
        at: transition_quantities(mechanism, at, tolerance, rest_rate) for at in conditions(targets)
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
    mechanism: Mechanism, at: Condition, tolerance: float, rest_rate: float | None
) -> dict[str, float]:
    """All quantities of one transition; NaN where there are fewer rebounds.

    Args:
        mechanism: The mechanism.
        at: Settings of the transition.
        tolerance: Relative accuracy.
        rest_rate: Separation rate at which it ends; None: at its limit.

    Raises:
        SimulationError: The transition cannot be simulated, or does not come to rest.
        InputError: A setting cannot be used.
    """
    case = Case(
        speed_rpm=at.speed_rpm,
        rest_rate=rest_rate,
        resolution=Resolution(tolerance=tolerance),
        max_collisions=500,
    )
    solution = simulate(with_settings(mechanism, at), case)
    if solution.outcome is not Outcome.AT_REST:
        message = f"{mechanism.name} at {at.speed_rpm:g} r/min: {solution.outcome.value}"
        raise SimulationError(message, condition=at._asdict())
    return _quantities(solution)


def with_settings(mechanism: Mechanism, at: Condition) -> Mechanism:
    """Return the mechanism with other settings; its tree does not depend on them.

    Args:
        mechanism: The mechanism.
        at: Restitution and stiffness; its speed is left to the caller.

    Raises:
        InputError: A stiffness is given, and the mechanism has not just one spring.
    """
    if at.restitution is not None:
        stops = tuple(
            replace(stop, restitution=at.restitution)
            if stop.name == mechanism.transition_stop
            else stop
            for stop in mechanism.stops
        )
        mechanism = replace(mechanism, stops=stops)
    if at.stiffness is not None:
        if len(mechanism.springs) != 1:
            message = (
                f"{mechanism.name} has {len(mechanism.springs)} springs: a stiffness in a target "
                "needs a model with one"
            )
            raise InputError(message, springs=[spring.name for spring in mechanism.springs])
        springs = (replace(mechanism.springs[0], stiffness=at.stiffness),)
        mechanism = replace(mechanism, springs=springs)
    return mechanism


def _quantities(solution: Solution) -> dict[str, float]:
    found = {name: transition_value(solution, name) for name in QUANTITIES}
    return {name: math.nan if value is None else value for name, value in found.items()}


def read_measured(path: str | Path) -> tuple[Target, ...]:
    """Read measured rebounds, for example from a high-speed camera.

    Args:
        path: CSV file with the columns speed_rpm, quantity, value, sigma and, if they differ from
            those of the model, restitution and stiffness; rebound amplitudes in rad (or m), times
            in s, stiffness in N/m.

    Raises:
        UnknownNameError: A column or quantity does not exist.
        InputError: The file cannot be read, or a number cannot be used.
    """
    file = Path(path)
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            columns, lines = tuple(reader.fieldnames or ()), list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        message = f"{file.name}: {error}; a readable CSV file is wanted"
        raise InputError(message, file=str(file)) from error
    for column in columns:
        if column not in _COLUMNS:
            raise UnknownNameError(kind="column", name=column, known=_COLUMNS, where=file.name)
    for column in _NEEDED:
        if column not in columns:
            message = f"{file.name}: the column {column} is missing; there must be {_NEEDED}"
            raise InputError(message, file=str(file), columns=columns)
    if not lines:
        message = f"{file.name}: no measurement below the heading"
        raise InputError(message, file=str(file))
    return tuple(
        _measured(line, f"{file.name}, line {number}") for number, line in enumerate(lines, start=2)
    )


def _measured(line: Mapping[str, str | None], where: str) -> Target:
    quantity = (line["quantity"] or "").strip()
    refuse_unknown([quantity], QUANTITIES, where)
    numbers: dict[str, float | None] = {}
    for column in ("speed_rpm", "restitution", "stiffness", "value", "sigma"):
        text = (line.get(column) or "").strip()
        try:
            number = float(text) if text else None
        except ValueError:
            number = math.nan
        if (number is None and column in _NEEDED) or (
            number is not None and not math.isfinite(number)
        ):
            message = f"{where}: {column} = {text!r} cannot be used: a finite number is wanted"
            raise InputError(message, column=column, value=text)
        numbers[column] = number
    speed, value, sigma = numbers["speed_rpm"], numbers["value"], numbers["sigma"]
    if speed is None or value is None or sigma is None or speed <= 0.0 or sigma <= 0.0:
        message = f"{where}: speed_rpm and sigma have to be above zero"
        raise InputError(message, speed_rpm=speed, sigma=sigma)
    at = Condition(speed, numbers["restitution"], numbers["stiffness"])
    settings = [f"{speed:g} r/min"]
    settings += [f"e = {at.restitution:g}"] if at.restitution is not None else []
    settings += [f"k = {at.stiffness:g}"] if at.stiffness is not None else []
    name = ", ".join([quantity, *settings])
    return Target(name=name, quantity=quantity, at=at, value=value, sigma=sigma)
