"""A design problem in words: its quantities, limits and free numbers as people read them."""

from __future__ import annotations

from ...study.optimise.problem.problem import Limit, Parameter, Problem
from ...study.optimise.search.binding import Binding
from ...terms import Shown, named


def quantity_shown(problem: Problem, name: str) -> Shown:
    """How people read a quantity of an aim or a limit."""
    return named(name, problem.units[name])


def parameter_shown(item: Parameter) -> Shown:
    """How people read a free number."""
    return named(item.target.path)


def limit_words(limit: Limit, problem: Problem) -> str:
    """A limit in words and in the unit that people read."""
    term = quantity_shown(problem, limit.quantity)
    side = "at least" if limit.side == "low" else "at most"
    return f"{term.words} {side} {term.phrase(limit.value)}"


def binding_words(item: Binding, problem: Problem) -> str:
    """The limit that binds, or the bound of a parameter, in words."""
    for limit in problem.limits:
        if item.kind == "limit" and str(limit) == item.name:
            return limit_words(limit, problem)
    return holding_words(problem)[item.name]


def room_shown(item: Binding, problem: Problem) -> Shown:
    """How people read the room that a limit or the bound of a parameter leaves."""
    if item.kind == "limit":
        found = next(limit for limit in problem.limits if str(limit) == item.name)
        return quantity_shown(problem, found.quantity)
    return next(
        parameter_shown(one)
        for one in problem.parameters
        if item.name in (one.bound("low"), one.bound("high"))
    )


def holding_words(problem: Problem) -> dict[str, str]:
    """All limits, then all bounds of free numbers: their names, and short words for a figure."""
    found = {}
    for limit in problem.limits:
        term = quantity_shown(problem, limit.quantity)
        found[str(limit)] = _side(term, limit.side == "low", limit.value)
    for item in problem.parameters:
        term = parameter_shown(item)
        found[item.bound("low")] = _side(term, True, item.low)
        found[item.bound("high")] = _side(term, False, item.high)
    return found


def ranges(problem: Problem) -> list[str]:
    """What each limited quantity has to keep to, in words."""
    sides: dict[str, dict[str, float]] = {}
    for limit in problem.limits:
        sides.setdefault(limit.quantity, {})[limit.side] = limit.value
    found = []
    for name, ends in sides.items():
        term = quantity_shown(problem, name)
        if len(ends) == 2:
            both = " to ".join(f"{term.value(ends[side]):.6g}" for side in ("low", "high"))
            found.append(f"{term.words} {both} {term.unit}".rstrip())
        else:
            found += [_side(term, side == "low", value) for side, value in ends.items()]
    return found


def _side(term: Shown, low: bool, value: float) -> str:
    """Written limits have few digits, so zeros behind them are left out."""
    side = "at least" if low else "at most"
    return f"{term.words} {side} {term.value(value):.6g} {term.unit}".rstrip()
