"""Every quantity of a run, once: its name, words, symbol and unit, and how it is read.

The JSON document, files, tables, sweeps, optimisations and identifications take them from here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ...errors import UnknownNameError
from ...mechanism import Mechanism, Stop
from ..event import EventKind
from .solution import Solution
from .tables import Collision, Transition

T = TypeVar("T")
_NUMBERED = re.compile(r"(.+)_([1-9][0-9]{0,3})")


@dataclass(frozen=True, kw_only=True)
class Quantity(Generic[T]):
    """One quantity of a collision or of a transition.

    Attributes:
        name: Its name in documents and files. In tables of transitions, that of collision K of the
            transition stop is ``name_K``.
        words: What it is.
        symbol: As in docs/notation.md; empty without one.
        unit: SI unit, empty without one; ``{gap}`` and ``{force}`` are those of the stop.
        read: Reads it off a solution; None where only tables of transitions have it.
        column: Attribute of a table of transitions; empty where only solutions have it.
        force: Unit of the stop's force that it belongs to, or None for all stops.
    """

    name: str
    words: str
    symbol: str = ""
    unit: str = ""
    read: Callable[[Solution, T], float | None] | None = None
    column: str = ""
    force: str | None = None

    def fits(self, mechanism: Mechanism, stop: str) -> bool:
        """Whether a stop has it."""
        return self.force in (None, force_unit(mechanism, mechanism.stop(stop)))

    def unit_at(self, mechanism: Mechanism, stop: str) -> str:
        """Its SI unit at a stop."""
        found = mechanism.stop(stop)
        return self.unit.format(
            gap=coordinate_unit(mechanism, found.index), force=force_unit(mechanism, found)
        )


def coordinate_unit(mechanism: Mechanism, index: int) -> str:
    """SI unit of the coordinate at a place in q: rad or m."""
    kind = next(joint.kind for joint in mechanism.joints if joint.index == index)
    return "m" if kind == "prismatic" else "rad"


def force_unit(mechanism: Mechanism, stop: Stop) -> str:
    """Unit of a stop's force; its impulse has this unit times s.

    The force acts at the contact point, or along the coordinate of a stop without one.
    """
    turns = stop.contact is None and coordinate_unit(mechanism, stop.index) == "rad"
    return "N m" if turns else "N"


def _own(name: str) -> Callable[[Solution, object], Any]:
    """Reads an attribute of a collision or a transition; None without a transition."""
    return lambda _, item: None if item is None else getattr(item, name)


def _relative_error(solution: Solution, hit: Collision) -> float:
    return float(solution.errors[hit.event.number - 1].impulse)


COLLISION: tuple[Quantity[Collision], ...] = (
    Quantity(
        name="time_s", words="time", symbol="t", unit="s", column="time",
        read=lambda run, hit: hit.t - run.collisions[0].t,
    ),
    Quantity(
        name="cylinder_angle_rad", words="cylinder angle", symbol="psi", unit="rad",
        column="cylinder_angle", read=_own("cylinder_angle"),
    ),
    Quantity(name="index", words="index", symbol="index", read=_own("index")),
    Quantity(
        name="approach_rate", words="rate before", symbol="g_N_dot", unit="{gap}/s",
        column="approach_rate", read=_own("approach_rate"),
    ),
    Quantity(
        name="separation_rate", words="rate after", symbol="w", unit="{gap}/s",
        column="separation_rate", read=_own("separation_rate"),
    ),
    Quantity(
        name="impulse_N_s", words="impulse", symbol="P_N", unit="N s", column="impulse",
        read=_own("impulse"), force="N",
    ),
    Quantity(
        name="impulse_N_m_s", words="impulse", symbol="P_N", unit="N m s", column="impulse",
        read=_own("impulse"), force="N m",
    ),
    Quantity(
        name="energy_lost_J", words="energy lost", unit="J", column="energy_lost",
        read=_own("energy_lost"),
    ),
    Quantity(
        name="rebound_amplitude", words="rebound amplitude", unit="{gap}",
        column="rebound_amplitude", read=_own("rebound_amplitude"),
    ),
    Quantity(
        name="rebound_time_s", words="rebound time", unit="s", column="rebound_time",
        read=_own("rebound_time"),
    ),
    Quantity(
        name="time_error_s", words="error of the time", unit="s", column="time_error",
        read=lambda run, hit: float(run.errors[hit.event.number - 1].time),
    ),
    Quantity(
        name="impulse_error", words="relative error of rates and impulse", read=_relative_error
    ),
    Quantity(
        name="rate_error", words="error of the rate before", unit="{gap}/s", column="rate_error"
    ),
    Quantity(
        name="impulse_error_N_s", words="error of the impulse", unit="N s",
        column="impulse_error", force="N",
    ),
    Quantity(
        name="impulse_error_N_m_s", words="error of the impulse", unit="N m s",
        column="impulse_error", force="N m",
    ),
    Quantity(
        name="amplitude_error", words="error of the amplitude", unit="{gap}",
        column="amplitude_error",
    ),
    Quantity(
        name="rebound_error_s", words="error of the rebound time", unit="s",
        column="rebound_error",
    ),
)  # fmt: skip
"""Quantities of a collision."""


def _duration_error(solution: Solution, found: Transition | None) -> float | None:
    if found is None:
        return None
    stop = solution.mechanism.transition_stop
    rest = next(
        event
        for event in solution.events
        if event.kind is EventKind.REST and stop in event.stops and event.t >= found.t_start
    )
    return float(solution.errors[rest.number - 1].time)


def _collisions(solution: Solution, found: Transition | None) -> float:
    if found is not None:
        return found.collisions
    stop = solution.mechanism.transition_stop
    return sum(item.stop == stop for item in solution.collisions)


TRANSITION: tuple[Quantity[Transition | None], ...] = (
    Quantity(
        name="premise_holds", words="machine arrives as a transition assumes",
        read=lambda run, _: run.premise_holds,
    ),
    Quantity(
        name="duration_s", words="time to rest", unit="s", column="duration",
        read=_own("duration"),
    ),
    Quantity(
        name="duration_error_s", words="error of the time to rest", unit="s",
        column="duration_error", read=_duration_error,
    ),
    Quantity(name="collisions", words="collisions", read=_collisions),
    Quantity(
        name="first_two_share", words="share of the first two rebounds",
        column="first_two_share", read=_own("first_two_share"),
    ),
)  # fmt: skip
"""Quantities of a transition; without a completed one there are its premise and collisions."""

RENAMED = {
    "first_amplitude_rad": "rebound_amplitude_1",
    "first_amplitude_m": "rebound_amplitude_1",
    "first_rebound_amplitude": "rebound_amplitude_1",
    "second_rebound_amplitude": "rebound_amplitude_2",
    "third_rebound_amplitude": "rebound_amplitude_3",
    "first_rebound_time": "rebound_time_s_1",
    "first_rebound_time_s": "rebound_time_s_1",
    "second_rebound_time": "rebound_time_s_2",
    "third_rebound_time": "rebound_time_s_3",
    "transition_time": "duration_s",
    "transition_time_s": "duration_s",
    "approach_rate": "approach_rate_1",
}
"""Names of earlier study files, and what they are called now."""


def of_transition(name: str) -> tuple[Quantity[Collision] | Quantity[Transition | None], int]:
    """The quantity that a name such as ``duration_s`` or ``rebound_time_s_2`` stands for.

    Args:
        name: The name.

    Returns:
        The quantity, and the number of the collision; 0 for one of the whole transition.

    Raises:
        KeyError: There is none.
    """
    for item in TRANSITION:
        if item.name == name:
            return item, 0
    found = _NUMBERED.fullmatch(name)
    for quantity in COLLISION:
        if found is not None and quantity.name == found[1]:
            return quantity, int(found[2])
    raise KeyError(name)


def transition_value(solution: Solution, name: str) -> float | None:
    """A quantity of the first transition of a run by its name; None where it has none.

    Args:
        solution: The run.
        name: A name such as ``duration_s`` or ``rebound_amplitude_1``.
    """
    quantity, place = of_transition(name)
    if quantity.read is None:
        return None
    subject: Collision | Transition | None
    if place:
        stop = solution.mechanism.transition_stop
        hits = [hit for hit in solution.collisions if hit.stop == stop]
        if place > len(hits):
            return None
        subject = hits[place - 1]
    else:
        subject = solution.transitions[0] if solution.transitions else None
    return quantity.read(solution, subject)  # type: ignore[arg-type]


def refuse_unknown(names: Iterable[str], known: Iterable[str], where: str) -> None:
    """Refuse names that are no quantity here, with the present name of one that had another.

    Args:
        names: The names.
        known: Names that may stand there.
        where: File and key, for messages.

    Raises:
        UnknownNameError: A name is none.
    """
    there = tuple(known)
    for name in names:
        if name not in there:
            now = RENAMED.get(name, "")
            raise UnknownNameError(
                kind="quantity",
                name=name,
                known=there,
                where=where,
                now=now if now in there else "",
            )
