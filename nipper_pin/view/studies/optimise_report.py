"""An optimisation as tables and sentences for a terminal."""

from __future__ import annotations

from rich.console import Console

from ...study.optimise.design import Design
from ...study.optimise.problem.quantities import label
from ...study.optimise.result import CAUTION, Optimum
from ...study.optimise.search.binding import Binding
from ..console import add_row, paste, plain_table, say

_SAME = 1e-6
_ENGINES = {
    "reduced": "the reduced engine",
    "direct": "the direct engine",
    "reduced_turn": "whole turns of the reduced engine",
    "turn": "whole turns",
}


def print_optimum(optimum: Optimum, console: Console) -> None:
    """Print what was found and what holds it back.

    Args:
        optimum: The optimum.
        console: Where to print; 80 columns are enough.
    """
    problem = optimum.problem
    say(console, problem.title, style="bold")
    aim = problem.aims[0].quantity
    change = "" if optimum.gain is None else f" ({100.0 * optimum.gain:+.3g} %)"
    say(console, f"{problem.aims[0]}: {optimum.best.values[aim]:.6g}{change}")
    _numbers(optimum, console)
    _quantities(optimum, console)
    say(console, "What holds it back", style="bold")
    for item in optimum.account.bindings:
        if item.active:
            say(console, _price(item, problem.units[aim]))
    free = [item.name for item in optimum.account.bindings if not item.active]
    if free:
        say(console, f"with room left: {', '.join(free)}")
    say(
        console,
        f"part of the gradient that nothing active explains: {optimum.account.residual:.2g}",
    )
    _search(optimum, console)
    if optimum.front:
        _front(optimum.front, optimum, console)
    say(console, "To simulate it", style="bold")
    paste(console, optimum.command)
    say(console, CAUTION, style="bold")


def _numbers(optimum: Optimum, console: Console) -> None:
    table = plain_table("number", "before", "optimum", "bounds")
    for item in optimum.problem.parameters:
        value = optimum.best.numbers[item.name]
        bounds = f"{item.low:g} to {item.high:g}"
        add_row(table, item.name, f"{item.start:.6g}", f"{value:.6g}", bounds)
    console.print(table)


def _quantities(optimum: Optimum, console: Console) -> None:
    table = plain_table("quantity", "before", "optimum", "control (simulated turn)")
    seen = optimum.control.values
    for name in optimum.problem.quantities:
        before = "-" if optimum.before is None else f"{optimum.before.values[name]:.6g}"
        value = seen.get(name)
        control = "-" if value is None else f"{value:.6g}"
        add_row(table, name, before, f"{optimum.best.values[name]:.6g}", control)
    console.print(table)
    if optimum.contradiction:
        say(console, f"NOT CONFIRMED: {optimum.contradiction}", style="bold")
    else:
        turns = optimum.control.turns
        say(console, f"confirmed by turn {turns} of the direct engine, which all later ones repeat")
    if optimum.before is not None and not optimum.before.inside:
        limits = zip(optimum.problem.limits, optimum.before.slacks, strict=True)
        broken = ", ".join(str(limit) for limit, slack in limits if slack < 0.0)
        say(console, f"the model itself breaks {broken}")


def _price(item: Binding, unit: str) -> str:
    return (
        f"{item.name}: one unit more of room is worth {item.price:.4g}{f' {unit}' if unit else ''}"
    )


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
    one, two = (item.quantity for item in optimum.problem.aims)
    if len(front) == 1:
        say(console, f"No conflict: one design is the best by {one} and by {two}")
        return
    names = [item.name for item in optimum.problem.parameters]
    # Paths side by side are wider than a terminal; their last words do where they differ.
    short = [name.rsplit(".", 1)[-1] for name in names]
    say(console, "Pareto front", style="bold")
    headings = short if len(set(short)) == len(short) else names
    table = plain_table(
        *(label(name, optimum.problem.units[name]) for name in (one, two)), *headings
    )
    for item in front:
        values = (item.values[one], item.values[two], *(item.numbers[name] for name in names))
        add_row(table, *(f"{value:.5g}" for value in values))
    console.print(table)
