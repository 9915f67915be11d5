"""How every quantity of a turn is read off it.

As in :mod:`~nipper_pin.hybrid.result.quantities`, of which this is the part of whole turns.
"""

from __future__ import annotations

from typing import Any

from ....mechanism import Mechanism
from ..quantities import Quantity, coordinate_unit, kept
from .turn import DriveTurn, StopTurn, Turn


def _forces(column: str, units: tuple[str, ...] = ("N", "N m")) -> list[Any]:
    """A force, or an impulse, once for each unit that a stop can have."""
    return [
        kept(f"{column}_{unit.replace(' ', '_')}", column, unit.removesuffix(" s"))
        for unit in units
    ]


def _force_errors(column: str) -> list[Any]:
    """The error of a force, which tables alone have, in either unit."""
    return [
        Quantity(name=f"{column}_{unit.replace(' ', '_')}", column=column, force=unit)
        for unit in ("N", "N m")
    ]


_IMPULSE = ("N s", "N m s")
_EVENTS = ("closing", "rest", "loss", "opening")
INDICES = tuple(f"{event}_index" for event in _EVENTS)
"""Names of the quantities that are places in the turn: differences go the short way around."""
TURN: tuple[Quantity[Turn], ...] = (
    kept("repeats_after", "repeats_after"),
    kept("clamped_time_s", "clamped_time"),
    Quantity(name="clamped_time_error_s", column="clamped_time_error"),
    kept("clamped_share", "clamped_share"),
    *(
        kept(f"{event}_index{error}", f"{event}_index{error}")
        for event in _EVENTS
        for error in ("", "_error")
    ),
    *_forces("least_clamping_force"),
    *_forces("largest_clamping_force"),
    *_force_errors("clamping_force_error"),
    kept("largest_gap", "largest_gap"),
    kept("largest_gap_error", "largest_gap_error"),
    kept("energy_lost_turn_J", "energy_lost"),
    kept("energy_lost_turn_error_J", "energy_lost_error"),
)
"""Quantities of a whole turn; forces and gaps are those of the transition stop, which clamps."""

TURN_STOP: tuple[Quantity[StopTurn], ...] = (
    kept("collisions", "collisions"),
    *_forces("impulse_sum", _IMPULSE),
    *_forces("impulse_sum_error", _IMPULSE),
    *_forces("largest_impulse", _IMPULSE),
    *_forces("largest_impulse_error", _IMPULSE),
)
"""Quantities of each stop in a turn; in tables, those of a stop are ``name_STOP``."""

TURN_DRIVE: tuple[Quantity[DriveTurn], ...] = (
    *_forces("largest_torque", ("N m", "N")),
    *reversed(_force_errors("largest_torque_error")),
)
"""Quantities of each drive, ``name_DRIVE``; they cost as much as a turn: only where asked for."""


def of_turn(name: str, mechanism: Mechanism) -> tuple[Quantity[Any], str]:
    """The quantity that a name such as ``rest_index`` or ``collisions_jaw`` stands for.

    Returns:
        The quantity, and the stop or drive that it is of; "" for one of the whole turn.

    Raises:
        KeyError: There is none, or it has another unit there.
    """
    return {**_named(mechanism), **_of_drives(mechanism)}[name]


def turn_names(mechanism: Mechanism, *, drives: bool = False) -> tuple[str, ...]:
    """Names of the quantities of a machine's turn.

    Args:
        drives: Whether those of its drives are among them.
    """
    return (*_named(mechanism), *(_of_drives(mechanism) if drives else ()))


def is_of_drive(name: str, mechanism: Mechanism) -> bool:
    """Whether a quantity is one of a drive."""
    return name in _of_drives(mechanism)


def read_of(turn: Turn, item: Quantity[Any], part: str) -> Turn | StopTurn | DriveTurn:
    """What a quantity of a turn is read from.

    Args:
        part: The stop or drive that it is of, as :func:`of_turn` tells; "" for the whole turn.
    """
    if not part:
        return turn
    return turn.drive(part) if item in TURN_DRIVE else turn.at(part)


def _named(mechanism: Mechanism) -> dict[str, tuple[Quantity[Any], str]]:
    """Quantities of the turn and of the stops that a machine has, by name."""
    clamp = mechanism.transition_stop
    found: dict[str, tuple[Quantity[Any], str]] = {
        item.name: (item, "") for item in TURN if item.fits(mechanism, clamp)
    }
    for stop in mechanism.stops:
        for item in TURN_STOP:
            if item.fits(mechanism, stop.name):
                found[f"{item.name}_{stop.name}"] = item, stop.name
    return found


def _of_drives(mechanism: Mechanism) -> dict[str, tuple[Quantity[Any], str]]:
    """Quantities of the drives that a machine has, by name."""
    return {
        f"{item.name}_{drive.name}": (item, drive.name)
        for drive in mechanism.drives
        for item in TURN_DRIVE
        if item.force == ("N" if coordinate_unit(mechanism, drive.index) == "m" else "N m")
    }
