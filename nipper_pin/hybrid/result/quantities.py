"""How every quantity of a run is read off it; what each is called, and what holds it, in ``terms``.

The JSON document, files, tables, sweeps, optimisations and identifications take them from here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ...errors import UnknownNameError
from ...mechanism import Mechanism, Stop
from ...terms import SUBJECTS, Term, term_of
from ..error_estimate.saltation import StrikeError
from ..history import EventKind
from .simulated import Simulated
from .tables import Collision, Transition

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Quantity(Generic[T]):
    """One quantity of a collision, a transition or a turn.

    Attributes:
        term: What it is called. In tables of transitions, that of collision K of the transition
            stop has the name ``name_K``.
        read: Reads it off a solution; None where only tables of many cases have it.
    """

    term: Term
    read: Callable[[Simulated, T], float | None] | None

    @property
    def name(self) -> str:
        """Its name in documents and files."""
        return self.term.name

    @property
    def column(self) -> str:
        """Attribute of a table of many cases; empty where only solutions have it."""
        return "" if self.term.only == "run" else self.term.attribute

    def fits(self, mechanism: Mechanism, stop: str) -> bool:
        """Whether a stop has it."""
        return self.term.force in ("", force_unit(mechanism, mechanism.stop(stop)))

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


def quantities(
    subject: str, computed: Mapping[str, Callable[[Simulated, Any], float | None]] | None = None
) -> tuple[Quantity[Any], ...]:
    """The quantities of a subject of :data:`~nipper_pin.terms.SUBJECTS`.

    Args:
        computed: How those are read that no attribute holds, by name.
    """
    readers = {term.name: _held(term) for term in SUBJECTS[subject]} | dict(computed or {})
    return tuple(
        Quantity(term=term, read=None if term.only == "table" else readers[term.name])
        for term in SUBJECTS[subject]
    )


def _held(term: Term) -> Callable[[Simulated, object], Any]:
    """Reads an attribute of a collision, a turn or a transition; None without a transition."""
    return lambda _, item: None if item is None else getattr(item, term.attribute)


def _error(solution: Simulated, hit: Collision) -> StrikeError:
    return solution.errors[hit.event.number - 1].at(hit.stop)


COLLISION: tuple[Quantity[Collision], ...] = quantities(
    "A collision",
    {
        "time_s": lambda run, hit: hit.t - run.collisions[0].t,
        "time_error_s": lambda run, hit: float(_error(run, hit).time),
        "impulse_error": lambda run, hit: float(_error(run, hit).relative),
    },
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


TRANSITION: tuple[Quantity[Transition | None], ...] = quantities(
    "A transition",
    {
        "premise_holds": lambda run, _: run.premise_holds,
        "duration_error_s": _duration_error,
        "collisions": _collisions,
    },
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
