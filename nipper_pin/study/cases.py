"""Parameters of many cases: names with units outside, checked SI values inside."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..dynamics import DriveMode
from ..errors import InputError, UnknownNameError
from ..given import column
from ..hybrid import Case, Resolution
from ..hybrid.result.quantities import coordinate_unit
from ..mechanism import Mechanism, retuned
from ..reduced.inputs import of_all_cases, speeds_of, spring_rows
from ..units import M_PER_MM, RAD_PER_DEG

# A linear spring that is wound further, or is stiffer, has its number in another unit.
_MOST_TURNS = 10
_STIFFEST = 1e10
SPRING_KEYS: Mapping[str, tuple[str, Literal["stiffness", "preload"], float, str]] = {
    "stiffness_N_per_m": ("m", "stiffness", 1.0, "N/m"),
    "preload_length_mm": ("m", "preload", M_PER_MM, "mm"),
    "stiffness_N_m_per_rad": ("rad", "stiffness", 1.0, "N m/rad"),
    "preload_deg": ("rad", "preload", RAD_PER_DEG, "deg"),
}
"""Keys of a spring: unit of its coordinate, name of the row, factor to SI, unit in sentences."""


@dataclass(frozen=True, eq=False)
class Cases:
    """Parameters of n cases in SI units, checked.

    Attributes:
        speed_rpm: Cylinder speeds [r/min], shape (n,).
        restitution: e_N of the transition stop, shape (n,).
        stiffness: Spring rates, shape (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        others: e_N of other stops by name, shape (n,); without one, that of the mechanism.
    """

    speed_rpm: FloatArray
    restitution: FloatArray
    stiffness: FloatArray
    preload: FloatArray
    others: Mapping[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings that all cases share.

    Attributes:
        drive: Behaviour of the driven shafts.
        rest_rate: None: series end at their limit. A number: rest at the first slower rebound.
        tolerance: Relative accuracy.
        max_collisions: Largest number of collisions of a transition, or of a turn.
    """

    drive: DriveMode = DriveMode.HELD
    rest_rate: float | None = None
    tolerance: float = 1e-10
    max_collisions: int = 256


def one_of(
    mechanism: Mechanism, cases: Cases, settings: Settings, number: int
) -> tuple[Mechanism, Case]:
    """The machine of one of some cases, and its transition for the direct engine."""
    e_N = {mechanism.transition_stop: cases.restitution, **cases.others}
    machine = retuned(
        mechanism,
        restitution={name: float(values[number]) for name, values in e_N.items()},
        stiffness=cases.stiffness[number],
        preload=cases.preload[number],
    )
    return machine, Case(
        speed_rpm=float(cases.speed_rpm[number]),
        drive=settings.drive,
        rest_rate=settings.rest_rate,
        resolution=Resolution(tolerance=settings.tolerance),
        max_collisions=settings.max_collisions,
    )


def cases_of(
    mechanism: Mechanism,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
) -> Cases:
    """Parameters of all cases, checked and broadcast.

    Args:
        mechanism: The mechanism; its values where there is None.
        speed_rpm: [r/min], a number or shape (n,).
        restitution: Likewise of the transition stop, or of stops by name.
        stiffness: Shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Likewise [m or rad].

    Raises:
        InputError: A value is out of range, or there is no such stop.
    """
    springs = mechanism.springs
    restitution, others = _by_stop(mechanism, restitution)
    if stiffness is None:
        stiffness = np.array([[spring.stiffness for spring in springs]])
    if preload is None:
        preload = np.array([[spring.preload for spring in springs]])
    speed = speeds_of(speed_rpm)
    e_N = column("restitution", restitution, 0.0, 1.0)
    rates = spring_rows("stiffness", stiffness, len(springs))
    lengths = spring_rows("preload", preload, len(springs))
    speed, e_N, rates, lengths, *columns = of_all_cases(
        speed, e_N, rates, lengths, *others.values()
    )
    return Cases(speed, e_N, rates, lengths, dict(zip(others, columns, strict=True)))


def _by_stop(
    mechanism: Mechanism, restitution: ArrayLike | Mapping[str, ArrayLike] | None
) -> tuple[ArrayLike, dict[str, FloatArray]]:
    """e_N of the transition stop, and those of others that are given, checked."""
    clamp = mechanism.transition_stop
    if not isinstance(restitution, Mapping):
        restitution = {} if restitution is None else {clamp: restitution}
    names = [stop.name for stop in mechanism.stops]
    for name in restitution:
        if name not in names:
            raise UnknownNameError(kind="stop", name=name, known=names, where="restitution")
    others = {
        name: column(f"restitution of {name}", value, 0.0, 1.0)
        for name, value in restitution.items()
        if name != clamp
    }
    own = restitution[clamp] if clamp in restitution else mechanism.stop(clamp).restitution
    return own, others


def spring_numbers(
    mechanism: Mechanism,
) -> Iterator[tuple[str, Literal["stiffness", "preload"], int, float]]:
    """Paths of rates and preloads: with each the name of its rows, its spring, and factor to SI."""
    for place, spring in enumerate(mechanism.springs):
        for key, (kind, row, scale, _) in SPRING_KEYS.items():
            if kind == coordinate_unit(mechanism, spring.index):
                yield f"springs.{spring.name}.{key}", row, place, scale


def spring_values(
    mechanism: Mechanism, given: Mapping[str, ArrayLike | None]
) -> tuple[FloatArray, FloatArray]:
    """Rates and deflections of all springs of a mechanism.

    Args:
        mechanism: The mechanism; its own values where there is None.
        given: By the names of the model file, for the springs on joints of that kind: a number,
            shape (n,) with one such spring, or (n, such springs).

    Returns:
        Stiffness [N/m or N m/rad] and preload [m or rad], shape (1 or n, springs) each.

    Raises:
        InputError: There is no such spring, or a value cannot be in this unit.
    """
    found = {
        field: np.array([[getattr(spring, field) for spring in mechanism.springs]], dtype=float)
        for field in ("stiffness", "preload")
    }
    for key, value in given.items():
        if value is None:
            continue
        kind, field, scale, unit = SPRING_KEYS[key]
        places = [
            place
            for place, spring in enumerate(mechanism.springs)
            if coordinate_unit(mechanism, spring.index) == kind
        ]
        if not places:
            message = f"{key}: {mechanism.name} has no spring on a joint that moves in {kind}"
            raise InputError(message, key=key, model=mechanism.name)
        rows = spring_rows(key, value, len(places))
        most = _most(mechanism, kind, field) / scale
        if (np.abs(rows) > most).any():
            message = (
                f"{key} = {float(rows[np.abs(rows) > most][0]):g} cannot be used: this is in "
                f"{unit}, and {mechanism.name} takes {most:.4g} {unit} at most"
            )
            raise InputError(message, key=key, most=most, unit=unit)
        found[field], rows = of_all_cases(found[field], scale * rows)
        found[field][:, places] = rows
    return found["stiffness"], found["preload"]


def _most(mechanism: Mechanism, kind: str, field: str) -> float:
    """Largest plausible value in SI units."""
    if field == "stiffness":
        return _STIFFEST
    return max(mechanism.reach_m, 1.0) if kind == "m" else 2.0 * math.pi * _MOST_TURNS
