"""Figures of the collisions: rebounds of a transition, large enough to be seen, and impulses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from ...arrays import FloatArray
from ...hybrid import Collision, Solution, Transition
from ...hybrid.result.quantities import force_unit
from ...mechanism import Stop
from ...units import MS_PER_S
from ..reading import contact_shown, coordinate_shown, gap_noun, in_sight, shown
from ..style import SMALL, TEXT, line_colour, marker, new_figure, tidy
from .sampling import sample_coordinates

TIME = "time from the start of the run [ms]"
# Heights are written at as many rebounds as have room for it.
_MOST_HEIGHTS = 3
_NARROWEST = 0.03
# A gap on a log axis is cut below this part of its rebound's height, where it falls to zero.
_DEPTH = 4e-3


def transition_figure(solution: Solution, transition: Transition) -> Figure:
    """The transition stop from its first collision to rest, linear and on logarithmic axes.

    Against the time left until rest, on logarithmic axes, all bounces of a series look alike.
    """
    mechanism = solution.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    collisions = series(solution, transition)
    figure = new_figure(solution, f"Transition: rebounds of the {stop.name}", 5.6)
    linear, log = figure.subplots(2, 1)
    draw_rebounds(linear, solution, transition)
    linear.legend(fontsize=SMALL, frameon=False, loc="upper right")

    t, q = sample_coordinates(solution, transition.t_start, collisions[-1].t)
    gap = coordinate_shown(mechanism, stop.index, small=True).value(stop.gaps(q))
    colour = line_colour(mechanism, stop.name)
    left = MS_PER_S * (transition.t_start + transition.duration - t)
    log.loglog(left, _visible(t, gap, [item.t for item in collisions]), color=colour, linewidth=1.4)
    for item in collisions:
        until_rest = MS_PER_S * (transition.t_start + transition.duration - item.t)
        log.axvline(until_rest, color="0.7", linewidth=0.8, zorder=0)
        log.annotate(str(item.number), (until_rest, 0.97), (3.0, 0.0), fontsize=SMALL, va="top",
                     xycoords=log.get_xaxis_transform(), textcoords="offset points",
                     color="0.25")  # fmt: skip
    log.margins(y=0.12)
    log.set_title("the same on logarithmic scales, on which all rebounds look alike", fontsize=TEXT)
    log.invert_xaxis()
    tidy(log, "time left until rest [ms], with the numbers of the collisions",
         linear.get_ylabel())  # fmt: skip
    return figure


def impulse_figure(solution: Solution) -> Figure:
    """Impulse of every collision shown, by stop, on a logarithmic axis."""
    mechanism = solution.mechanism
    figure = new_figure(solution, "Impulses of the collisions", 3.8)
    axes = figure.add_subplot()
    shown = [item for item in in_sight(solution, solution.collisions) if item.impulse > 0.0]
    base = 10.0 ** np.floor(np.log10(min(item.impulse for item in shown)) - 0.5)
    for stop in mechanism.stops:
        chosen = [item for item in shown if item.stop == stop.name]
        if not chosen:
            continue
        number = np.array([item.number for item in chosen])
        impulse = np.array([item.impulse for item in chosen])
        colour = line_colour(mechanism, stop.name)
        axes.vlines(number, base, impulse, color=colour, linewidth=1.6)
        axes.plot(number, impulse, linestyle="none", marker=marker(mechanism, stop.name),
                  color=colour, markersize=5.0, label=f"stop {stop.name}")  # fmt: skip
    axes.set_yscale("log")
    top = max(item.impulse for item in shown)
    axes.set_ylim(float(base), 3.0 * top)
    axes.set_xlim(shown[0].number - 0.8, shown[-1].number + 0.8)
    # Where there is one collision, its number is the only tick.
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=12, min_n_ticks=1))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="y", which="major", color="0.85", linewidth=0.6)
    axes.set_axisbelow(True)
    units = sorted({f"{force_unit(mechanism, stop)} s" for stop in mechanism.stops})
    tidy(axes, "number of the collision", f"impulse [{' or '.join(units)}]")
    figure.legend(loc="outside lower center", ncols=4, fontsize=TEXT, frameon=False)
    return figure


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


def _visible(t: FloatArray, gap: FloatArray, collisions: list[float]) -> FloatArray:
    """Gap without the ends of bounces, which a logarithmic axis cannot show."""
    shown = gap.copy()
    for begin, end in pairwise(collisions):
        bounce = (t >= begin) & (t <= end)
        foot = bounce & (gap < _DEPTH * gap[bounce].max())
        shown[foot] = np.nan
    return shown
