"""Every quantity of a turn, once: its name, words and unit, and how it is read.

As in :mod:`~nipper_pin.hybrid.result.quantities`, of which this is the part of whole turns.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ....mechanism import Mechanism
from ..quantities import Quantity
from ..solution import Solution
from .turn import StopTurn, Turn


def _own(name: str) -> Callable[[Solution, object], Any]:
    """Reads an attribute of a turn, or of a stop in it."""
    return lambda _, item: getattr(item, name)


def _of(name: str, words: str, column: str, unit: str = "", force: str | None = None) -> Any:
    """A quantity whose attribute is called alike in a turn and in tables of turns."""
    return Quantity(name=name, words=words, unit=unit, read=_own(column), column=column,
                    force=force)  # fmt: skip


TURN: tuple[Quantity[Turn], ...] = (
    _of("repeats_after", "repeats after so many turns", "repeats_after"),
    _of("clamped_time_s", "time clamped", "clamped_time", "s"),
    _of("clamped_share", "share of the turn clamped", "clamped_share"),
    _of("closing_index", "index of closing", "closing_index"),
    _of("rest_index", "index of rest", "rest_index"),
    _of("loss_index", "index of loss", "loss_index"),
    _of("opening_index", "index of opening", "opening_index"),
    *(
        _of(f"{name}_{unit.replace(' ', '_')}", words, name, unit, force=unit)
        for name, words in (
            ("least_clamping_force", "smallest clamping force"),
            ("largest_clamping_force", "largest clamping force"),
        )
        for unit in ("N", "N m")
    ),
    *(
        Quantity(name=f"clamping_force_error_{unit.replace(' ', '_')}", unit=unit, force=unit,
                 words="error of both clamping forces", column="clamping_force_error")
        for unit in ("N", "N m")
    ),
    _of("largest_gap", "largest gap of a rebound", "largest_gap", "{gap}"),
    _of("largest_gap_error", "error of the largest gap", "largest_gap_error", "{gap}"),
    _of("energy_lost_turn_J", "energy lost in the turn", "energy_lost", "J"),
)  # fmt: skip
"""Quantities of a whole turn; forces and gaps are those of the transition stop, which clamps."""

TURN_STOP: tuple[Quantity[StopTurn], ...] = (
    _of("collisions", "collisions", "collisions"),
    *(
        _of(f"{name}_{unit.replace(' ', '_')}", words, name, unit, force=unit.removesuffix(" s"))
        for name, words in (
            ("impulse_sum", "sum of the impulses"),
            ("impulse_sum_error", "error of the sum"),
            ("largest_impulse", "largest impulse"),
        )
        for unit in ("N s", "N m s")
    ),
)  # fmt: skip
"""Quantities of each stop in a turn; in tables, those of a stop are ``name_STOP``."""


def of_turn(name: str, mechanism: Mechanism) -> tuple[Quantity[Any], str]:
    """The quantity that a name such as ``rest_index`` or ``collisions_jaw`` stands for.

    Args:
        name: The name.
        mechanism: The machine, whose stops have names and units.

    Returns:
        The quantity, and the stop that it is of; "" for one of the whole turn.

    Raises:
        KeyError: There is none, or it has another unit at this stop.
    """
    return _named(mechanism)[name]


def turn_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of all quantities of a machine's turn.

    Args:
        mechanism: The machine.
    """
    return tuple(_named(mechanism))


def _named(mechanism: Mechanism) -> dict[str, tuple[Quantity[Any], str]]:
    """All quantities that a machine has, by name."""
    clamp = mechanism.transition_stop
    found: dict[str, tuple[Quantity[Any], str]] = {
        item.name: (item, "") for item in TURN if item.fits(mechanism, clamp)
    }
    for stop in mechanism.stops:
        for item in TURN_STOP:
            if item.fits(mechanism, stop.name):
                found[f"{item.name}_{stop.name}"] = item, stop.name
    return found
