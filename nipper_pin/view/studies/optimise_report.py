"""An optimisation as tables and sentences for a terminal, and its limits and numbers in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rich.console import Console

from ...study.optimise.design import Design
from ...study.optimise.problem.problem import Aim, Parameter, Problem
from ...study.optimise.result import CAUTION, Optimum
from ...terms import Shown, named
from ..console import ending, headline, say, show_table

_SAME = 1e-6
_ENGINES = {
    "reduced": "the reduced engine",
    "direct": "the direct engine",
    "reduced_turn": "whole turns of the reduced engine",
    "turn": "whole turns",
}


class Side(NamedTuple):
    """A limit, or a bound of a free number.

    Attributes:
        shown: How people read its quantity, or the number.
        words: What has to hold.
    """

    shown: Shown
    words: str


def print_optimum(optimum: Optimum, console: Console, written: Sequence[str] = ()) -> None:
    """Print what was found and what holds it back, and the files that were written."""
    problem = optimum.problem
    say(console, problem.title, style="bold")
    say(console, _found(optimum))
    _numbers(optimum, console)
    _quantities(optimum, console)
    headline(console, "What holds it back")
    aim, held = quantity_shown(problem, problem.aims[0].quantity), sides(problem)
    for item in optimum.account.bindings:
        if item.active:
            say(console, _price(held[item.name], item.price, aim))
    free = [held[item.name].words for item in optimum.account.bindings if not item.active]
    if free:
        say(console, f"with room left: {', '.join(free)}")
    say(
        console,
        f"part of the gradient that nothing active explains: {optimum.account.residual:.2g}",
    )
    headline(console, "Search")
    _search(optimum, console)
    if optimum.front:
        _front(optimum.front, optimum, console)
    headline(console, f"Found: {_found(optimum)}")
    say(console, CAUTION)
    ending(console, optimum.command if optimum.control.values else "", written)


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


def _aim(aim: Aim, problem: Problem) -> str:
    verb = "smallest" if aim.sense > 0.0 else "largest"
    return f"{verb} {quantity_shown(problem, aim.quantity).words}"


def _found(optimum: Optimum) -> str:
    problem = optimum.problem
    aim = problem.aims[0]
    value = quantity_shown(problem, aim.quantity).phrase(optimum.best.values[aim.quantity])
    if not optimum.control.confirmed:
        return f"no confirmed optimum; {_aim(aim, problem)} of the search alone: {value}"
    change = "" if optimum.gain is None else f" ({100.0 * optimum.gain:+.3g} %)"
    return f"{_aim(aim, problem)}: {value}{change}"


def _numbers(optimum: Optimum, console: Console) -> None:
    headline(console, "Numbers of the model")
    rows = []
    for item in optimum.problem.parameters:
        term = number_shown(item)
        values = item.start, optimum.best.numbers[item.name]
        bounds = f"{term.value(item.low):g} to {term.value(item.high):g}"
        rows.append((term.label, *(_six(term, value) for value in values), bounds))
    show_table(console, ("number", "before", "optimum", "bounds"), rows)


def _quantities(optimum: Optimum, console: Console) -> None:
    headline(console, "Quantities (control: a simulated turn)")
    problem, seen = optimum.problem, optimum.control.values
    rows = []
    for name in problem.quantities:
        term = quantity_shown(problem, name)
        before = None if optimum.before is None else optimum.before.values[name]
        values = (before, optimum.best.values[name], seen.get(name))
        rows.append((term.label, *(_six(term, value) for value in values)))
    show_table(console, ("quantity", "before", "optimum", "control"), rows)
    if optimum.contradiction:
        say(console, f"NOT CONFIRMED: {optimum.contradiction}", style="bold")
    else:
        turns = optimum.control.turns
        say(console, f"confirmed by turn {turns} of the direct engine, which all later ones repeat")
    if optimum.before is not None and not optimum.before.inside:
        limits, held = zip(problem.limits, optimum.before.slacks, strict=True), sides(problem)
        broken = ", ".join(held[str(limit)].words for limit, slack in limits if slack < 0.0)
        say(console, f"the model itself breaks: {broken}")


def _six(term: Shown, value: float | None) -> str:
    """Six digits, which tell an optimum from its control."""
    return "-" if value is None else f"{term.value(value):.6g}"


def _price(side: Side, price: float, aim: Shown) -> str:
    # A price is one of the unit in files: people read both the aim and the room in others.
    worth = f"{aim.value(price) / side.shown.factor:.4g} {aim.unit}".rstrip()
    more = f"one {side.shown.unit or 'unit'} more of room"
    return f"{side.words}: {more} is worth {worth}"


def _search(optimum: Optimum, console: Console) -> None:
    best = optimum.descents[0]
    same = sum(
        item.feasible and item.aim - best.aim <= _SAME * abs(best.aim) for item in optimum.descents
    )
    say(
        console,
        f"{same} of {len(optimum.descents)} descents (seed {optimum.seed}) end there; "
        f"{optimum.evaluations:,} points in {optimum.wall_s:.3g} s",
    )
    counts = [f"{count:,} by {_ENGINES[name]}" for name, count in optimum.engines.items()]
    failed = optimum.evaluations - sum(optimum.engines.values())
    say(console, f"of them {', '.join([*counts, f'{failed:,} without a usable machine'])}")
    if optimum.check is not None:
        found = (
            f"found a design better by {100.0 * optimum.check_gain:.3g} %"
            if optimum.check_gain > _SAME
            else "found nothing better"
        )
        say(console, f"differential evolution ({optimum.check.evaluations:,} points) {found}")
    for why in optimum.no_machine:
        say(console, f"some samples make no machine: {why}")


def _front(front: tuple[Design, ...], optimum: Optimum, console: Console) -> None:
    problem = optimum.problem
    one, two = (quantity_shown(problem, item.quantity) for item in problem.aims)
    if len(front) == 1:
        say(console, f"No conflict: one design is the best by {one.words} and by {two.words}")
        return
    numbers = [(item.name, number_shown(item)) for item in problem.parameters]
    headline(console, "Pareto front")
    rows = [
        (
            f"{one.value(item.values[problem.aims[0].quantity]):.5g}",
            f"{two.value(item.values[problem.aims[1].quantity]):.5g}",
            *(f"{term.value(item.numbers[name]):.5g}" for name, term in numbers),
        )
        for item in front
    ]
    headings = [term.label for _, term in numbers]
    show_table(console, (one.label, two.label, *headings), rows, text=())
