"""The rebounds of a transition, drawn large enough to be seen."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...hybrid import Collision, Solution, Transition
from ...mechanism import Stop
from ...units import MS_PER_S
from ..naming import contact_shown, coordinate_shown, shown
from ..reading import gap_noun
from ..style import SMALL, TEXT, line_colour, tidy
from .sampling import sample_coordinates

TIME = "time from the start of the run [ms]"
# Heights are written at as many rebounds as have room for it.
_MOST_HEIGHTS = 3
_NARROWEST = 0.03


def series(solution: Solution, transition: Transition) -> list[Collision]:
    """Collisions of a transition, in order of time."""
    return [
        item
        for item in solution.collisions
        if item.stop == solution.mechanism.transition_stop
        and transition.t_start <= item.t <= transition.t_start + transition.duration
    ]


def draw_rebounds(axes: Axes, solution: Solution, transition: Transition) -> None:
    """Gap of the transition stop from the first collision to rest, in the unit of rebounds.

    Heights are written at the first ones; where the stop has a contact point, the scale at the
    right is the gap there.
    """
    mechanism = solution.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    term = coordinate_shown(mechanism, stop.index, small=True)
    collisions = series(solution, transition)
    # After the last collision the stop is at rest, the limit of the series.
    t, q = sample_coordinates(solution, transition.t_start, collisions[-1].t)
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.plot(
        MS_PER_S * t, term.value(stop.gaps(q)),
        color=line_colour(mechanism, stop.name), linewidth=1.4,
    )  # fmt: skip
    at = MS_PER_S * np.array([item.t for item in collisions])
    end = MS_PER_S * (transition.t_start + transition.duration)
    axes.plot(at, np.zeros_like(at), "|", color="black", markersize=10.0, label="collision")
    axes.plot(end, 0.0, "s", color="black", markersize=4.0, label="rest")
    axes.margins(y=0.18)
    tidy(axes, TIME, f"{stop.name} {gap_noun(mechanism, stop)} [{term.unit}]")
    _heights(axes, solution, collisions, transition.duration)
    contact_scale(axes, stop, term.factor)


def _heights(axes: Axes, solution: Solution, collisions: list[Collision], duration: float) -> None:
    """Height of the first rebounds, above their tops."""
    term = shown(solution.mechanism, "rebound_amplitude")
    for item in collisions[:_MOST_HEIGHTS]:
        height, lasts = item.rebound_amplitude, item.rebound_time
        if height is None or lasts is None or lasts < _NARROWEST * duration:
            continue
        axes.annotate(
            term.phrase(height), (MS_PER_S * (item.t + 0.5 * lasts), term.value(height)),
            (0.0, 3.0), textcoords="offset points", ha="center", va="bottom", fontsize=SMALL,
        )  # fmt: skip


def contact_scale(axes: Axes, stop: Stop, factor: float) -> None:
    """Gap at the contact point at the right; none for a stop along its joint.

    Args:
        factor: Of the axis at the left [1/rad or 1/m].
    """
    lips = contact_shown(stop)
    if lips is None:
        return
    lever = lips.factor / factor
    beside = axes.secondary_yaxis(
        "right", functions=(lambda y: lever * np.asarray(y), lambda y: np.asarray(y) / lever)
    )
    beside.set_ylabel(lips.label, fontsize=TEXT)
    beside.tick_params(labelsize=SMALL)
