"""How every quantity of a run is read off it; what each is called stands in ``terms``.

The JSON document, files, tables, sweeps, optimisations and identifications take them from here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ...errors import UnknownNameError
from ...mechanism import Mechanism, Stop
from ...terms import TERMS, Term, term_of
from ..error_estimate.together import StrikeError
from ..event import EventKind
from .simulated import Simulated
from .tables import Collision, Transition

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Quantity(Generic[T]):
    """One quantity of a collision, a transition or a turn.

    Attributes:
        name: Its name in documents and files, a key of :data:`~nipper_pin.terms.TERMS`. In tables
            of transitions, that of collision K of the transition stop is ``name_K``.
        read: Reads it off a solution; None where only tables of transitions have it.
        column: Attribute of a table of transitions; empty where only solutions have it.
        force: Unit of the stop's force that it belongs to, or None for all stops.
    """

    name: str
    read: Callable[[Simulated, T], float | None] | None = None
    column: str = ""
    force: str | None = None

    @property
    def term(self) -> Term:
        """What it is called."""
        return TERMS[self.name]

    def fits(self, mechanism: Mechanism, stop: str) -> bool:
        """Whether a stop has it."""
        return self.force in (None, force_unit(mechanism, mechanism.stop(stop)))

    def unit_at(self, mechanism: Mechanism, stop: str) -> str:
        """Its SI unit at a stop."""
        found = mechanism.stop(stop)
        return self.term.unit.format(gap=coordinate_unit(mechanism, found.index))


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


def _own(name: str) -> Callable[[Simulated, object], Any]:
    """Reads an attribute of a collision, a turn or a transition; None without a transition."""
    return lambda _, item: None if item is None else getattr(item, name)


def _error(solution: Simulated, hit: Collision) -> StrikeError:
    return solution.errors[hit.event.number - 1].at(hit.stop)


def kept(name: str, column: str, force: str | None = None) -> Quantity[Any]:
    """A quantity whose attribute is called alike in solutions and in tables."""
    return Quantity(name=name, column=column, read=_own(column), force=force)


COLLISION: tuple[Quantity[Collision], ...] = (
    Quantity(name="t_s", read=_own("t")),
    Quantity(name="time_s", column="time", read=lambda run, hit: hit.t - run.collisions[0].t),
    kept("cylinder_angle_rad", "cylinder_angle"),
    Quantity(name="index", read=_own("index")),
    kept("approach_rate", "approach_rate"),
    kept("separation_rate", "separation_rate"),
    kept("impulse_N_s", "impulse", "N"),
    kept("impulse_N_m_s", "impulse", "N m"),
    kept("energy_lost_J", "energy_lost"),
    kept("rebound_amplitude", "rebound_amplitude"),
    kept("rebound_time_s", "rebound_time"),
    Quantity(
        name="time_error_s",
        column="time_error",
        read=lambda run, hit: float(_error(run, hit).time),
    ),
    Quantity(name="impulse_error", read=lambda run, hit: float(_error(run, hit).relative)),
    Quantity(name="rate_error", column="rate_error"),
    Quantity(name="impulse_error_N_s", column="impulse_error", force="N"),
    Quantity(name="impulse_error_N_m_s", column="impulse_error", force="N m"),
    Quantity(name="amplitude_error", column="amplitude_error"),
    Quantity(name="rebound_error_s", column="rebound_error"),
)
"""Quantities of a collision."""


def _duration_error(solution: Simulated, found: Transition | None) -> float | None:
    if found is None:
        return None
    stop = solution.mechanism.transition_stop
    rest = next(
        event
        for event in solution.events
        if event.kind is EventKind.REST and stop in event.stops and event.t >= found.t_start
    )
    return float(solution.errors[rest.number - 1].time)


def _collisions(solution: Simulated, found: Transition | None) -> float:
    if found is not None:
        return found.collisions
    stop = solution.mechanism.transition_stop
    return sum(item.stop == stop for item in solution.collisions)


TRANSITION: tuple[Quantity[Transition | None], ...] = (
    Quantity(name="premise_holds", read=lambda run, _: run.premise_holds),
    kept("duration_s", "duration"),
    Quantity(name="duration_error_s", column="duration_error", read=_duration_error),
    Quantity(name="collisions", read=_collisions),
    kept("first_two_share", "first_two_share"),
)
"""Quantities of a transition; without a completed one there are its premise and collisions."""


def of_transition(name: str) -> tuple[Quantity[Collision] | Quantity[Transition | None], int]:
    """The quantity that a name such as ``duration_s`` or ``rebound_time_s_2`` stands for.

    Returns:
        The quantity, and the number of the collision; 0 for one of the whole transition.

    Raises:
        KeyError: There is none.
    """
    term, place = term_of(name)
    known: Iterable[Quantity[Any]] = COLLISION if place else TRANSITION
    for item in known:
        if item.name == term.name:
            return item, place
    raise KeyError(name)


def refuse_unknown(names: Iterable[str], known: Iterable[str], where: str) -> None:
    """Refuse names that are no quantity here.

    Raises:
        UnknownNameError: A name is none.
    """
    there = tuple(known)
    for name in names:
        if name not in there:
            raise UnknownNameError(kind="quantity", name=name, known=there, where=where)
