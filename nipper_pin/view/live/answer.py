"""The result of one setting: numbers with their words and curves, or the reason why there are none.

What follows the rest of a transition is among it: the jaw is pressed shut by a force.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...hybrid import Case, Collision, Outcome, Solution, simulate
from ...hybrid.result.quantities import force_unit
from ...mechanism import INDEX_PER_TURN, Mechanism, index_difference
from ...units import MS_PER_S
from ..compare.words import index_text, percent_text
from ..reading import coordinate_shown, lips_shown
from ..reading import shown as words_of
from ..run.sampling import sample_coordinates
from .settings import SPEED, Knob, changed, in_si

# The force of a closed stop is as smooth as the drives: straight lines between so many of its
# values are off by less than a line of a plot is wide.
_POINTS = 9
# A bounce series converges with fewer collisions.
_MOST_COLLISIONS = 400
_NO_LINE = partial(np.zeros, (2, 0))


class Number(NamedTuple):
    """One row of the page.

    Attributes:
        key: Its name in the page.
        label: What it is, with its unit.
        text: What is shown.
        value: The value itself, from which differences are computed; None without one.
        on_scale: Whether it is a place on the comber's scale, whose difference is in indices.
    """

    key: str
    label: str
    text: str
    value: float | None = None
    on_scale: bool = False


Rows = tuple[Number, ...]
"""Rows of a table."""


def difference(now: Number, other: Number | None) -> str:
    """The difference of a number to that of another setting, if that has one: per cent, or indices.

    Returns:
        With its sign; empty where there is nothing to compare, or no number of which it is a part.
    """
    if other is None or now.value is None or other.value is None:
        return ""
    if not (math.isfinite(now.value) and math.isfinite(other.value)):
        return ""
    if now.value == other.value:
        return "0"
    if now.on_scale:
        return index_text(index_difference(now.value, other.value))
    return "" if other.value == 0.0 else percent_text(100.0 * (now.value / other.value - 1.0))


def told(rows: Sequence[Number], others: Sequence[Number] = ()) -> list[tuple[str, ...]]:
    """Key, label, text and difference of each row, to those of another setting."""
    known = {item.key: item for item in others}
    return [
        (item.key, item.label, item.text, difference(item, known.get(item.key))) for item in rows
    ]


def followed_on(solution: Solution) -> Solution:
    """A transition to rest and one index more, in which the stop is closed unless it opens before.

    Events stay those of the transition. Where the machine cannot be followed further, so does all
    else: the transition itself is not in doubt.
    """
    end = solution.events[-1].t + solution.shaft.period / INDEX_PER_TURN
    try:
        return solution.continued(end)
    except NipperError:
        return solution


def gap_line(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Times [s] and gaps of the transition stop [rad or m], each shape (K,)."""
    stop = solution.mechanism.stop(solution.mechanism.transition_stop)
    if not solution.segments:
        return np.zeros(1), np.zeros(1)
    t, q = sample_coordinates(solution, 0.0, solution.segments[-1].t_end)
    # Both limits at a collision have one abscissa, and a line needs only one of them.
    t, places = np.unique(t, return_index=True)
    return t, stop.gaps(q[places])


def force_line(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Times [s] and clamping forces [N; N m along a hinge without contact], each shape (K,).

    The force is zero while the jaw flies, and jumps where it comes to rest.
    """
    name, rest = solution.mechanism.transition_stop, solution.events[-1].t
    end = solution.segments[-1].t_end if solution.segments else 0.0
    if end <= rest:
        return np.array([0.0, rest]), np.zeros(2)
    t = np.linspace(rest, end, _POINTS)
    inner = solution.trajectory.reactions(t[:-1]).contacts[name]
    last = solution.trajectory.reactions(t[-1:], left=True).contacts[name]
    # The foot of the jump stands a hair before it, because times of a line have to increase.
    foot = rest * (1.0 - 1e-9)
    return np.array([0.0, foot, *t]), np.concatenate([[0.0, 0.0], inner, last])


@dataclass(frozen=True, eq=False)
class Answer:
    """One setting, answered; equal to itself only.

    Attributes:
        parts: The setting in words, a number each.
        message: Why there are no numbers; empty if there are.
        rows: The numbers.
        gap: Times from the first collision [ms], and the gap of the transition stop there in the
            unit of rebounds that people read, shape (2, K).
        force: Times likewise, and the clamping force, shape (2, F).
        impulse: Times of the collisions likewise, and their impulses, shape (2, C).
        solution: The motion to show, one index beyond the rest; None if there is none to follow.
    """

    parts: tuple[str, ...]
    message: str = ""
    rows: Rows = ()
    gap: FloatArray = field(default_factory=_NO_LINE)
    force: FloatArray = field(default_factory=_NO_LINE)
    impulse: FloatArray = field(default_factory=_NO_LINE)
    solution: Solution | None = None

    @property
    def setting(self) -> str:
        """The setting in words."""
        return ", ".join(self.parts)


def answer(mechanism: Mechanism, controls: Sequence[Knob], shown: Mapping[str, float]) -> Answer:
    """Simulate the transition of one setting by the direct engine.

    Args:
        shown: Values of the knobs in their units, by key.

    Returns:
        The answer; a setting without a transition gives its reason instead of numbers.
    """
    parts = tuple(f"{item.shown.words} {shown[item.key]:g} {item.shown.unit}".rstrip()
                  for item in controls)  # fmt: skip
    values = in_si(controls, shown)
    try:
        case = Case(speed_rpm=values[SPEED], max_collisions=_MOST_COLLISIONS)
        solution = simulate(changed(mechanism, values), case)
        # Rebounds are computed at their first use and may fail like a run.
        return _numbers(parts, solution)
    except NipperError as error:
        return Answer(parts, error.message)


def _numbers(parts: tuple[str, ...], solution: Solution) -> Answer:
    mechanism = solution.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    others = [item for item in solution.collisions if item.stop != stop.name]
    if solution.outcome is not Outcome.AT_REST:
        return Answer(parts, f"{solution.outcome.value}{_also(solution, others)}")
    hits = [item for item in solution.collisions if item.stop == stop.name]
    whole, term = followed_on(solution), coordinate_shown(mechanism, stop.index, small=True)
    struck = [(item.t, item.impulse) for item in hits if item.impulse > 0.0]

    def line(t: FloatArray, values: FloatArray) -> FloatArray:
        return np.array([MS_PER_S * (t - hits[0].t), values])

    t, gap = gap_line(whole)
    return Answer(
        parts=parts,
        rows=tuple(_rows(solution, hits, others)),
        gap=line(t, term.value(gap)),
        force=line(*force_line(whole)),
        impulse=line(*np.array(struck).reshape(-1, 2).T),
        solution=whole if whole.segments else None,
    )


def _rows(
    solution: Solution, hits: Sequence[Collision], others: Sequence[Collision]
) -> list[Number]:
    mechanism = solution.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    first, transition = hits[0], solution.transitions[0]
    impulse = f"impulse_{force_unit(mechanism, stop).replace(' ', '_')}_s_1"

    def row(key: str, name: str, value: float | None, words: str = "") -> Number:
        term = words_of(mechanism, name)
        term = term.called(words) if words else term
        return Number(key, term.label, term.text(value), value)

    rows = [
        row("amplitude", "rebound_amplitude_1", first.rebound_amplitude),
        row("rebound", "rebound_time_s_1", first.rebound_time),
        row("duration", "duration_s", transition.duration),
        row("collisions", "collisions", transition.collisions),
        row("share", "first_two_share", transition.first_two_share),
        row("approach", "approach_rate_1", first.approach_rate, "rate of the first collision"),
        row("impulse", impulse, first.impulse, "impulse of the first collision"),
    ]
    if (lips := lips_shown(mechanism, stop)) is not None:
        height = first.rebound_amplitude
        rows.insert(1, Number("lips", lips.label, lips.text(height), height))
    if others:
        rows.append(Number("others", "other stops", _also(solution, others).strip()))
    if solution.premise_holds is False:
        # Numbers of a transition that no turn reaches are shown with a remark.
        rows.insert(0, Number("premise", "no turn has this transition", solution.premise.why))
    rows.append(Number("engine", "engine", f"direct, {MS_PER_S * solution.wall_s:.1f} ms"))
    return rows


def _also(solution: Solution, others: Sequence[Collision]) -> str:
    """Which other stops were struck, as a sentence; nothing if none was."""
    if not others:
        return ""
    first = others[0]
    after = MS_PER_S * (first.t - solution.collisions[0].t)
    number = "once" if len(others) == 1 else f"{len(others)} times"
    names = " and ".join(sorted({item.stop for item in others}))
    return f" On the way the {names} struck its stop {number}, first after {after:.3g} ms."
