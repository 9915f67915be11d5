"""An identification as tables and sentences for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rich.console import Console

from ...study.identify.fitting.determine import DETERMINED, Determinability
from ...study.identify.fitting.fit import Fit
from ...study.identify.fitting.goodness import Goodness, Verdict
from ...study.identify.fitting.profiles import Profile
from ...study.identify.problem.problem import Problem
from ...study.identify.problem.targets import Condition, Target
from ...study.identify.record import WORD
from ...terms import Shown, counted, parameter_shown
from ..console import headline, say, show_table
from ..reading import shown

_SAME = 1e-3
# Two numbers whose errors go together this far are known as a combination alone.
_STRONG = 0.9
_PAIRS = 5


def print_fit(
    fit: Fit,
    judged: Goodness,
    known: Determinability,
    profiles: Sequence[Profile],
    console: Console,
) -> None:
    """Print what was identified, how good it is and what the targets determine."""
    problem = fit.objective.problem
    say(console, problem.title, style="bold")
    same = sum(item.cost < fit.best.cost * (1.0 + _SAME) for item in fit.descents)
    say(
        console,
        f"{counted(len(fit.descents), 'start')}, seed {fit.seed}: {same} ended at the least cost "
        f"{fit.best.cost:.5g}; targets met: {fit.within(0.04)} of {len(problem.targets)} within "
        f"4 %, {fit.within(0.10)} within 10 %",
    )
    bad = judged.verdict is Verdict.CONTRADICTED
    say(console, judged.sentence(), style="bold red" if bad else "")
    _targets(fit, judged, console)
    _free(fit, judged, known, console)
    _correlations(known, console)
    _premises(fit, console)
    _limits(fit, console)
    headline(console, "What the targets determine")
    say(
        console,
        f"{known.identifiable_directions} of {counted(len(known.paths), 'direction')}; "
        "singular values (sigmas over the whole range): "
        + ", ".join(f"{x:.3g}" for x in known.singular_values),
    )
    single = _names(known.determined) or "none"
    say(console, f"single numbers narrowed to less than half of their range: {single}")
    for item in profiles:
        _profile(item, console)
    headline(console, f"Found: {judged.sentence()}")
    say(console, WORD)


def _targets(fit: Fit, judged: Goodness, console: Console) -> None:
    rows = []
    for place, (target, term) in enumerate(_terms(fit.objective.problem)):
        numbers = (target.value, target.sigma, float(fit.predicted[place]))
        wanted, sigma, found = (term.value(number) for number in numbers)
        mark = "!" if place in judged.outliers else " "
        rows.append(
            (
                term.label,
                f"{wanted:.5g}",
                f"{sigma:.2g}",
                f"{found:.5g}",
                f"{100 * fit.deviations[place]:+.2f} %",
                f"{_sigmas(judged.residuals[place])}{mark}",
            )
        )
    headline(console, "Targets")
    show_table(console, ("target", "wanted", "+-", "found", "deviation", "sigmas"), rows)
    if judged.outliers:
        say(console, "!: outlier, farther off than chance explains for the worst of all targets")


def _terms(problem: Problem) -> Iterator[tuple[Target, Shown]]:
    """Targets, and how people read them: a change between two settings has no unit."""
    for target in problem.targets:
        if target.since is not None:
            yield target, Shown(words=target.name)
            continue
        term = shown(problem.mechanism, target.quantity)
        # A target that was given no name has that of its quantity in files.
        yield target, term.called(target.name.replace(target.quantity, term.words, 1))


def _sigmas(value: float) -> str:
    return f"{value:+.2f}" if abs(value) < 100.0 else f"{value:+.3g}"


def _free(fit: Fit, judged: Goodness, known: Determinability, console: Console) -> None:
    left, given = dict(known.ranked()), known.deviations
    scaled = known.scaled_deviations(judged.scale) if judged.scale else {}
    rows = []
    for item in fit.objective.problem.parameters:
        term, path = parameter_shown(item.path), item.path
        width = term.value(item.width)
        rows.append(
            (
                term.label,
                f"{term.value(item.start):.5g}",
                f"{term.value(fit.values[path]):.5g}{'*' if path in fit.at_bounds else ' '}",
                f"{given[path] * width:.2g}",
                f"{scaled[path] * width:.2g}" if scaled else "-",
                f"{term.value(item.low):g}..{term.value(item.high):g}",
                f"{100 * left[path]:.0f}%{' ' if left[path] < DETERMINED else '?'}",
            )
        )
    headline(console, "Numbers of the model")
    show_table(console, ("number", "before", "found", "+-", "scaled", "bounds", "left"), rows)
    say(
        console,
        "+-: standard deviation by the sigmas as given; scaled: by sigmas that the misfit would "
        "meet. left: part of its range that the targets leave a number; ?: "
        f"{100 * DETERMINED:.0f} % or more, not known. *: at its bound",
    )
    if fit.at_bounds:
        ends = ", ".join(
            f"{parameter_shown(path).words} ({side})" for path, side in fit.at_bounds.items()
        )
        say(
            console,
            f"at a bound of their ranges, so that bounds and not targets decide them: {ends}",
        )


def _names(paths: Iterable[str], between: str = ", ") -> str:
    """Numbers of the model in words."""
    return between.join(parameter_shown(path).words for path in paths)


def _correlations(known: Determinability, console: Console) -> None:
    strong = known.strongest(_STRONG)
    if not strong:
        return
    pairs = "; ".join(
        f"{_names((one, other), ' and ')} {size:+.3f}" for one, other, size in strong[:_PAIRS]
    )
    more = f"; and {len(strong) - _PAIRS} more" if len(strong) > _PAIRS else ""
    say(console, f"correlated, so that only a combination is well known: {pairs}{more}")


def _premises(fit: Fit, console: Console) -> None:
    for at, premise in fit.premises.items():
        if premise.holds is False:
            say(console, f"{_setting(at)}: the transition of the turn, since {premise.why}")
        elif premise.holds is None:
            say(console, f"{_setting(at)}: a transition as assumed; {premise.why}")


def _setting(at: Condition) -> str:
    words = {"restitution": at.restitution, "stiffness": at.stiffness}
    more = [f"{word} {value:g}" for word, value in words.items() if value is not None]
    return ", ".join([f"{at.speed_rpm:g} r/min", *more])


def _limits(fit: Fit, console: Console) -> None:
    if fit.broken_limits:
        words = ", ".join(f"{name} by {by:+.3g}" for name, by in fit.broken_limits.items())
        say(console, f"LIMITS ARE BROKEN: {words}", style="bold red")
    elif fit.excess.size:
        say(console, "all limits are kept")


def _profile(item: Profile, console: Console) -> None:
    term = parameter_shown(item.path)
    pairs = ", ".join(
        f"{term.value(value):.4g}: {cost:.2f} ({linear:.2f})"
        for value, cost, linear in zip(item.values, item.cost, item.quadratic, strict=True)
    )
    say(
        console,
        f"profile of {term.label} (rise of the cost; that of the linear model in brackets; 0.5 is "
        f"one sigma = {term.value(item.sigma):.3g}): {pairs}",
    )
