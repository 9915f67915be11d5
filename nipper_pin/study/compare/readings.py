"""Quantities of one run that a comparison looks at, by their names in files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...errors import InputError
from ...hybrid import Solution, Window
from ...hybrid.result.quantities import COLLISION, TRANSITION, Quantity
from ...hybrid.result.turns import TURN, TURN_STOP, Turn, reported_turn
from ...mechanism import Mechanism

# Of the first collisions of the transition stop: how many, and what of each.
_REBOUNDS = 3
_OF_REBOUNDS = ("rebound_amplitude", "rebound_time_s")
_OF_THE_FIRST = ("impulse_N_s", "impulse_N_m_s")
_OF_COLLISIONS = (*_OF_REBOUNDS, *_OF_THE_FIRST)
_OF_TRANSITIONS = ("duration_s", "collisions", "first_two_share")


@dataclass(frozen=True)
class Reading:
    """What was read off a run.

    Attributes:
        values: SI unit (empty without one) and value by name; None for what the run does not have.
        missing: Why quantities of a whole turn are missing; empty if they are there or not asked.
    """

    values: dict[str, tuple[str, float | None]]
    missing: str


def reading(solution: Solution) -> Reading:
    """Read a run.

    Those of whole turns are read in the turn that stands for all further ones: the first that
    repeats another, or the last one.
    """
    if not solution.mechanism.transition_stop:
        return Reading({}, "it has no stop whose bouncing is the transition")
    if solution.case.window is not Window.CYCLE:
        return Reading(_bounces(solution, 0.0), "")
    try:
        turn = reported_turn(solution)
    except InputError:
        return Reading(_bounces(solution, 0.0), f"its run ended early: {solution.outcome.value}")
    begin = (turn.number - 1) * solution.shaft.period
    return Reading(_bounces(turn.solution, begin) | _of_turn(turn), "")


def _bounces(run: Solution, begin: float) -> dict[str, tuple[str, float | None]]:
    """Rebounds of the transition stop from a time on, and its transition."""
    mechanism, stop = run.mechanism, run.mechanism.transition_stop
    hits = [hit for hit in run.collisions if hit.stop == stop and hit.t >= begin]
    whole = next((item for item in run.transitions if item.t_start >= begin), None)
    found = {}
    kept = (item for item in _fitting(COLLISION, mechanism, stop) if item.name in _OF_COLLISIONS)
    for quantity in sorted(kept, key=lambda item: _OF_COLLISIONS.index(item.name)):
        for place in range(_REBOUNDS if quantity.name in _OF_REBOUNDS else 1):
            hit = hits[place] if place < len(hits) else None
            value = None if hit is None else _read(quantity, run, hit)
            found[f"{quantity.name}_{place + 1}"] = quantity.unit_at(mechanism, stop), value
    for item in TRANSITION:
        if item.name in _OF_TRANSITIONS:
            found[item.name] = item.term.unit, None if whole is None else _read(item, run, whole)
    return found


def _of_turn(turn: Turn) -> dict[str, tuple[str, float | None]]:
    """Quantities of the turn and of its stops."""
    run = turn.solution
    mechanism, clamp = run.mechanism, run.mechanism.transition_stop
    found = {
        item.name: (item.unit_at(mechanism, clamp), _read(item, run, turn))
        for item in _fitting(TURN, mechanism, clamp)
    }
    for stop in mechanism.stops:
        part = turn.at(stop.name)
        for quantity in _fitting(TURN_STOP, mechanism, stop.name):
            unit = quantity.unit_at(mechanism, stop.name)
            found[f"{quantity.name}_{stop.name}"] = unit, _read(quantity, run, part)
    return found


def _fitting(
    quantities: tuple[Quantity[Any], ...], mechanism: Mechanism, stop: str
) -> list[Quantity[Any]]:
    """Quantities that a stop has and a run tells, without their errors."""
    return [
        item
        for item in quantities
        if item.read is not None and "error" not in item.name and item.fits(mechanism, stop)
    ]


def _read(quantity: Quantity[Any], run: Solution, subject: object) -> float | None:
    value = None if quantity.read is None else quantity.read(run, subject)
    return None if value is None else float(value)
