"""The head of a printed run: machine, setting, and what its transition came to."""

from __future__ import annotations

from rich.console import Console

from ...hybrid import Solution, Transition
from ...terms import counted
from ..console import headline, paste, say
from ..naming import lips_phrase, rate_shown, shown
from ..reading import (
    case_text,
    element_lines,
    in_sight,
    index_at,
    law_text,
    restitution_text,
)
from .remarks import more

_TOLD = ("First", "second")


def header(solution: Solution, console: Console) -> None:
    """Print the machine, the setting and where time is zero."""
    mechanism = solution.mechanism
    say(console, mechanism.title or mechanism.name, style="bold")
    say(console, case_text(solution))
    if mechanism.stops:
        say(console, f"restitution: {restitution_text(mechanism.stops)}")
    if law := law_text(mechanism):
        say(console, law)
    for line in element_lines(mechanism):
        say(console, line)
    say(console, f"Times t count from the start of the run at index {index_at(solution, 0.0):.3f}.")


def transitions(solution: Solution, console: Console) -> None:
    """Print the completed transitions: how long they take and how far the stop rebounds."""
    stop = solution.mechanism.transition_stop
    headline(console, "Transition")
    if not solution.transitions:
        say(console, f"No transition of the {stop} was completed.")
        return
    told = in_sight(solution, solution.transitions)
    for item in told:
        say(console, _duration(solution, item))
    say(console, _rebounds(solution, told[0] if told else solution.transitions[0]))
    say(console, _how_ended(solution))
    more(console, len(solution.transitions) - len(told), "transition")


def premise(solution: Solution, console: Console, turns: str) -> None:
    """Print a remark if no turn of the machine reaches this transition.

    Args:
        turns: The command that simulates whole turns; empty if unknown.
    """
    if solution.premise_holds is not False:
        return
    say(console, f"No turn has this transition: {solution.premise.why}", style="bold")
    if turns:
        say(console, "The one that turns have:")
        paste(console, turns)
    else:
        say(console, "The one that turns have is found by simulating them (window cycle).")


def _duration(solution: Solution, item: Transition) -> str:
    mechanism = solution.mechanism
    share = (
        "" if item.first_two_share is None
        else "; the first two rebounds take "
        f"{shown(mechanism, 'first_two_share').phrase(item.first_two_share)} of it"
    )  # fmt: skip
    hits = counted(item.collisions, "collision")
    duration = shown(mechanism, "duration_s").phrase(item.duration)
    return f"{duration} from the first collision to rest, {hits} computed{share}."


def _rebounds(solution: Solution, item: Transition) -> str:
    """The first two rebounds of a transition in words."""
    mechanism = solution.mechanism
    stop, parts = mechanism.stop(mechanism.transition_stop), []
    hits = (hit for hit in solution.collisions if hit.stop == stop.name and hit.t >= item.t_start)
    for word, hit in zip(_TOLD, hits, strict=False):
        if hit.rebound_amplitude:
            height = shown(mechanism, "rebound_amplitude").phrase(hit.rebound_amplitude)
            lasting = shown(mechanism, "rebound_time_s").phrase(hit.rebound_time)
            lips = lips_phrase(mechanism, stop, hit.rebound_amplitude)
            parts.append(f"{word} rebound {height}{lips} in {lasting}")
    return f"{'; '.join(parts)}." if parts else "It does not rebound."


def _how_ended(solution: Solution) -> str:
    """A remark on the finite duration of infinitely many bounces."""
    mechanism, threshold = solution.mechanism, solution.case.rest_rate
    stop = mechanism.stop(mechanism.transition_stop)
    if stop.restitution == 0.0:
        return "Without restitution the first collision ends it."
    if threshold is None:
        return "The bounces go on for ever; the time of rest is their limit, by extrapolation."
    rate = rate_shown(mechanism, stop.index).phrase(threshold)
    return f"It was ended by a threshold: the first rebound slower than {rate}."
