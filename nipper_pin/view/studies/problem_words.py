"""A design problem in words: its quantities, limits and free numbers as people read them."""

from __future__ import annotations

from typing import NamedTuple

from ...study.optimise.problem.problem import Parameter, Problem
from ...terms import Shown, named


class Side(NamedTuple):
    """A limit, or a bound of a free number.

    Attributes:
        shown: How people read its quantity, or the number.
        words: What has to hold.
    """

    shown: Shown
    words: str


def quantity_shown(problem: Problem, name: str) -> Shown:
    """How people read a quantity of an aim or a limit."""
    return named(name, problem.units[name])


def number_shown(item: Parameter) -> Shown:
    """How people read a free number."""
    return named(item.target.path)


def sides(problem: Problem) -> dict[str, Side]:
    """All limits, then all bounds of free numbers, by their names."""
    found = {
        str(limit): _side(quantity_shown(problem, limit.quantity), limit.side, limit.value)
        for limit in problem.limits
    }
    for item in problem.parameters:
        found[item.bound("low")] = _side(number_shown(item), "low", item.low)
        found[item.bound("high")] = _side(number_shown(item), "high", item.high)
    return found


def ranges(problem: Problem) -> list[str]:
    """What each limited quantity has to keep to, in words."""
    ends: dict[str, dict[str, float]] = {}
    for limit in problem.limits:
        ends.setdefault(limit.quantity, {})[limit.side] = limit.value
    found = []
    for name, values in ends.items():
        term = quantity_shown(problem, name)
        if len(values) == 2:
            both = " to ".join(f"{term.value(values[side]):.6g}" for side in ("low", "high"))
            found.append(f"{term.words} {both} {term.unit}".rstrip())
        else:
            found += [_side(term, side, value).words for side, value in values.items()]
    return found


def _side(term: Shown, side: str, value: float) -> Side:
    """Written limits have few digits, so zeros behind them are left out."""
    least = "at least" if side == "low" else "at most"
    return Side(term, f"{term.words} {least} {term.value(value):.6g} {term.unit}".rstrip())
