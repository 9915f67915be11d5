"""An identification as tables and sentences for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from ..study.identify.determine import DETERMINED, Determinability, Profile
from ..study.identify.fit import Fit
from ..study.identify.objective import LIMITS
from ..study.identify.record import WORD
from .console import plain_table, say

_NEAR = 1e-3
_SAME = 1e-3
_BROKEN = 1.0


def print_fit(
    fit: Fit, known: Determinability, profiles: Sequence[Profile], console: Console
) -> None:
    """Print what was identified and what the targets determine.

    Args:
        fit: The fit.
        known: What the targets determine.
        profiles: Profile likelihoods.
        console: Where to print; 80 columns are enough.
    """
    problem = fit.objective.problem
    say(console, problem.title, style="bold")
    same = sum(item.cost < fit.best.cost * (1.0 + _SAME) for item in fit.descents)
    say(
        console,
        f"{len(fit.descents)} starts, seed {fit.seed}: {same} of them end at the least cost "
        f"{fit.best.cost:.5g}; {fit.within(0.04)} of {len(problem.targets)} targets are met within "
        f"4 %, {fit.within(0.10)} within 10 %",
    )
    _targets(fit, console)
    _free(fit, known, console)
    _limits(fit, console)
    say(console, "What the targets determine", style="bold")
    say(
        console,
        f"{known.identifiable_directions} of {len(known.paths)} directions; singular values "
        "(sigmas over the whole range): " + ", ".join(f"{x:.3g}" for x in known.singular_values),
    )
    single = ", ".join(known.determined) or "none"
    say(console, f"single numbers narrowed to less than half of their range: {single}")
    for item in profiles:
        _profile(item, console)
    say(console, WORD, style="bold")


def _targets(fit: Fit, console: Console) -> None:
    table = plain_table("target", "wanted", "found", "deviation")
    for target, found, deviation in zip(
        fit.objective.problem.targets, fit.predicted, fit.deviations, strict=True
    ):
        table.add_row(
            target.name, f"{target.value:.5g}", f"{found:.5g}", f"{100 * deviation:+.2f} %"
        )
    console.print(table)


def _free(fit: Fit, known: Determinability, console: Console) -> None:
    table = plain_table("number", "before", "found", "+-", "bounds", "left")
    left, deviations = dict(known.ranked()), known.deviations
    for item in fit.objective.problem.free:
        value = fit.values[item.path]
        width = item.high - item.low
        edge = min(value - item.low, item.high - value) < _NEAR * width
        table.add_row(
            item.path,
            f"{item.start:.5g}",
            f"{value:.5g}{'*' if edge else ' '}",
            f"{deviations[item.path] * width:.2g}",
            f"{item.low:g}..{item.high:g}",
            f"{100 * left[item.path]:.0f}%{' ' if left[item.path] < DETERMINED else '?'}",
        )
    console.print(table)
    say(
        console,
        "+-: standard deviation. left: part of its range that the targets leave a number; ?: "
        f"{100 * DETERMINED:.0f} % or more, not known. *: at its bound",
    )


def _limits(fit: Fit, console: Console) -> None:
    broken = [name for name, value in zip(LIMITS, fit.broken, strict=False) if abs(value) > _BROKEN]
    if broken:
        say(console, f"limits that are broken: {', '.join(broken)}")
    elif fit.broken.size:
        say(console, "all limits are kept")


def _profile(item: Profile, console: Console) -> None:
    pairs = ", ".join(
        f"{value:.4g}: {cost:.2f} ({linear:.2f})"
        for value, cost, linear in zip(item.values, item.cost, item.quadratic, strict=True)
    )
    say(
        console,
        f"profile of {item.path} (rise of the cost; that of the linear model in brackets; 0.5 is "
        f"one sigma = {item.sigma:.3g}): {pairs}",
    )
