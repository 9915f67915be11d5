"""Figures of the collisions: the transition close up, and the impulses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from ...arrays import FloatArray
from ...hybrid import Solution, Transition
from ...hybrid.result.quantities import force_unit
from ...units import MS_PER_S
from ..naming import coordinate_shown
from ..reading import in_sight
from ..style import SMALL, TEXT, line_colour, marker, new_figure, tidy
from .rebounds import draw_rebounds, series
from .sampling import sample_coordinates

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


def _visible(t: FloatArray, gap: FloatArray, collisions: list[float]) -> FloatArray:
    """Gap without the ends of bounces, which a logarithmic axis cannot show."""
    shown = gap.copy()
    for begin, end in pairwise(collisions):
        bounce = (t >= begin) & (t <= end)
        foot = bounce & (gap < _DEPTH * gap[bounce].max())
        shown[foot] = np.nan
    return shown
