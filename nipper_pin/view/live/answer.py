"""The result of one setting on the page: numbers and plots, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...hybrid.case import Case
from ...hybrid.result.quantities import force_unit
from ...hybrid.result.solution import Solution
from ...hybrid.result.tables import Collision
from ...hybrid.run.outcome import Outcome
from ...hybrid.simulate import simulate
from ...mechanism import Mechanism
from ...terms import digits
from ...units import MS_PER_S
from ..reading import units_of
from ..run.sampling import sample_coordinates
from .settings import SPEED, Knob, changed

# A bounce series converges with fewer collisions.
_MOST_COLLISIONS = 400


@dataclass(frozen=True, eq=False)
class Answer:
    """One setting, answered; equal to itself only.

    Attributes:
        setting: The setting in words.
        message: Why there are no numbers; empty if there are.
        rows: Key, label and value of the numbers.
        time: Times of the gap's line, from the first collision [ms], shape (K,).
        gap: Gap of the transition stop in the unit people read, shape (K,).
        hit_time: Times of its collisions, likewise [ms], shape (C,).
        impulse: Their impulses, shape (C,).
        solution: The motion to show; None if there is none to follow.
    """

    setting: str
    message: str = ""
    rows: tuple[tuple[str, str, str], ...] = ()
    time: FloatArray = field(default_factory=lambda: np.zeros(0))
    gap: FloatArray = field(default_factory=lambda: np.zeros(0))
    hit_time: FloatArray = field(default_factory=lambda: np.zeros(0))
    impulse: FloatArray = field(default_factory=lambda: np.zeros(0))
    solution: Solution | None = None


def answer(mechanism: Mechanism, controls: Sequence[Knob], shown: Mapping[str, float]) -> Answer:
    """Simulate the transition of one setting by the direct engine.

    Args:
        mechanism: The mechanism as loaded.
        controls: The knobs.
        shown: Values of the knobs in their units, by key.

    Returns:
        The answer; a setting without a transition gives its reason instead of numbers.
    """
    setting = ", ".join(
        f"{item.label.partition(' [')[0]} {shown[item.key]:g} {item.unit}".rstrip()
        for item in controls
    )
    values = {item.key: item.factor * shown[item.key] for item in controls}
    try:
        case = Case(speed_rpm=values[SPEED], max_collisions=_MOST_COLLISIONS)
        solution = simulate(changed(mechanism, values), case)
        # Rebounds are computed at their first use and may fail like a run.
        return _numbers(setting, solution)
    except NipperError as error:
        return Answer(setting, error.message)


def _numbers(setting: str, solution: Solution) -> Answer:
    mechanism = solution.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    others = [item for item in solution.collisions if item.stop != stop.name]
    if solution.outcome is not Outcome.AT_REST:
        return Answer(setting, f"{solution.outcome.value}{_also(solution, others)}")
    hits = [item for item in solution.collisions if item.stop == stop.name]
    units, origin = units_of(mechanism, stop.index), hits[0].t
    time, gap = np.zeros(1), np.zeros(1)
    if solution.segments:
        t, q = sample_coordinates(solution, 0.0, solution.segments[-1].t_end)
        # Both limits at a collision have one abscissa, and a line needs only one of them.
        t, places = np.unique(t, return_index=True)
        time, gap = MS_PER_S * (t - origin), units.coordinate_factor * stop.gaps(q[places])
    struck = [item for item in hits if item.impulse > 0.0]
    return Answer(
        setting=setting,
        rows=tuple(_rows(solution, hits, others)),
        time=time,
        gap=gap,
        hit_time=np.array([MS_PER_S * (item.t - origin) for item in struck]),
        impulse=np.array([item.impulse for item in struck]),
        solution=solution if solution.segments else None,
    )


def _rows(
    solution: Solution, hits: Sequence[Collision], others: Sequence[Collision]
) -> list[tuple[str, str, str]]:
    mechanism = solution.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    units, first, transition = units_of(mechanism, stop.index), hits[0], solution.transitions[0]
    share = transition.first_two_share
    rows = [
        ("amplitude", f"first rebound amplitude [{units.amplitude}]",
         digits(_scaled(first.rebound_amplitude, units.amplitude_factor))),
        ("rebound", "first rebound time [ms]", digits(_scaled(first.rebound_time, MS_PER_S))),
        ("duration", "transition time [ms]", digits(MS_PER_S * transition.duration)),
        ("collisions", "collisions computed up to the limit", str(transition.collisions)),
        ("share", "share of the first two rebounds", digits(share)),
        ("approach", f"rate of the first collision [{units.rate}]",
         digits(units.rate_factor * first.approach_rate)),
        ("impulse", f"impulse of the first collision [{force_unit(mechanism, stop)} s]",
         digits(first.impulse)),
    ]  # fmt: skip
    if others:
        rows.append(("others", "other stops", _also(solution, others).strip()))
    if solution.premise_holds is False:
        # Numbers of a transition that no turn reaches are shown with a remark.
        rows.insert(0, ("premise", "no turn has this transition", solution.premise.why))
    rows.append(("engine", "engine", f"direct, {MS_PER_S * solution.wall_s:.1f} ms"))
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


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def as_html(found: Answer, turn: Sequence[tuple[str, str, str]] = ()) -> str:
    """The answer as HTML: the setting, its numbers or its message, and those of the whole turn.

    Args:
        found: The answer.
        turn: Key, label and value of the numbers of the turn.
    """
    head = f'<div id="setting">{escape(found.setting)}</div>'
    if found.message:
        body = (
            f'<div id="message" role="alert" style="color:#B00020"><b>No numbers:</b> '
            f"{escape(found.message)}</div>"
        )
    else:
        body = _table("numbers", found.rows)
    return boxed(f"{head}{body}{_table('turn', turn) if turn else ''}")


def _table(name: str, rows: Sequence[tuple[str, str, str]]) -> str:
    lines = "".join(
        f'<tr><td>{escape(label)}</td><td data-key="{key}" style="text-align:right">'
        f"<b>{escape(value)}</b></td></tr>"
        for key, label, value in rows
    )
    return f'<table id="{name}" style="width:100%;border-spacing:0">{lines}</table>'


def boxed(content: str) -> str:
    """HTML in the size and with the margins of the sliders' labels.

    Args:
        content: The HTML.
    """
    return f'<div style="font-size:0.82em;line-height:1.4;padding:0.15em 0.8em">{content}</div>'
