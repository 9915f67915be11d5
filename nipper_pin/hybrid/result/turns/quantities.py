"""How every quantity of a turn is read off it.

As in :mod:`~nipper_pin.hybrid.result.quantities`, of which this is the part of whole turns.
"""

from __future__ import annotations

from typing import Any

from ....mechanism import Mechanism
from ..quantities import Quantity, coordinate_unit, quantities
from .turn import DriveTurn, StopTurn, Turn

# The number of turns is no quantity of one of them.
TURN: tuple[Quantity[Turn], ...] = tuple(
    item for item in quantities("A turn") if item.name != "turns"
)
"""Quantities of a whole turn; forces and gaps are those of the transition stop, which clamps."""

INDICES = tuple(item.name for item in TURN if item.name.endswith("_index"))
"""Names of the quantities that are places in the turn: differences go the short way around."""
TURN_STOP: tuple[Quantity[StopTurn], ...] = quantities("A stop in a turn")
"""Quantities of each stop in a turn; in tables, those of a stop are ``name_STOP``."""

TURN_DRIVE: tuple[Quantity[DriveTurn], ...] = quantities("A drive in a turn")
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
    """Names of the quantities of a machine's turn, those of its drives only if asked for."""
    return (*_named(mechanism), *(_of_drives(mechanism) if drives else ()))


def is_of_drive(name: str, mechanism: Mechanism) -> bool:
    """Whether a quantity is one of a drive."""
    return name in _of_drives(mechanism)


def read_of(turn: Turn, item: Quantity[Any], part: str) -> Turn | StopTurn | DriveTurn:
    """What a quantity of a turn is read from, of a part as :func:`of_turn` tells."""
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
        if item.term.force == ("N" if coordinate_unit(mechanism, drive.index) == "m" else "N m")
    }
