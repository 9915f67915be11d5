"""Figures along a run: motion of the stops' coordinates, forces of the stops, phases."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ...hybrid import EventKind, Solution, Window
from ...mechanism import INDEX_PER_TURN, Stop
from ...units import MS_PER_S
from ..phases import intervals
from ..reading import (
    coordinate_shown,
    force_name,
    gap_noun,
    in_sight,
    index_at,
    shown_events,
    shown_until,
)
from ..style import (
    SMALL,
    TEXT,
    index_scale,
    legend_below,
    line_colour,
    new_figure,
    phase_patches,
    shade_phases,
    tidy,
)
from .bounces import TIME, contact_scale, draw_rebounds
from .sampling import sample_coordinates, sample_forces

_PANEL_IN = 2.2
# Marker, face colour and size of an event; a rest lies at the end of its collisions.
_EVENTS = {
    EventKind.COLLISION: ("|", "black", 9.0),
    EventKind.REST: ("s", "black", 4.0),
    EventKind.RELEASE: ("o", "white", 5.0),
}
# Boundaries of phases closer than this [index] share one label.
_CLOSEST_LABELS = 0.6
_NARROWEST_LABEL = 0.55
_CLOSED = "0.35"
_UNKNOWN = "0.8"
# Round-off by which a whole turn may fall short.
_PART_OF_TURN = 1e-9


def motion_figure(solution: Solution) -> Figure:
    """Gaps of all stops against time and index; below, the rebounds of a cycle's transition.

    Beside the wide open jaw of a cycle its rebounds are too small to be seen. A run of the
    transition alone shows them as it is, in the unit of rebounds.
    """
    mechanism = solution.mechanism
    bounced = [item for item in in_sight(solution, solution.transitions) if item.collisions > 1]
    enlarged = bounced[:1] if solution.case.window is Window.CYCLE else []
    count = len(mechanism.stops)
    rows = count + len(enlarged)
    t, q = sample_coordinates(solution, 0.0, shown_until(solution))
    figure = new_figure(solution, "Motion at the stops", 1.5 + _PANEL_IN * rows)
    every = list[Axes](figure.subplots(rows, 1, squeeze=False).flat)
    panels, below = every[:count], every[count:]
    for axes in panels[1:]:
        axes.sharex(panels[0])
    for axes, stop in zip(panels, mechanism.stops, strict=True):
        small = stop.name == mechanism.transition_stop
        small &= solution.case.window is Window.TRANSITION
        term = coordinate_shown(mechanism, stop.index, small=small)
        y = term.value(stop.gaps(q))
        axes.plot(MS_PER_S * t, y, color=line_colour(mechanism, stop.name), linewidth=1.4)
        noun = gap_noun(mechanism, stop)
        tidy(axes, "", f"{stop.name} {noun} [{term.unit}]")
        low, high = min(0.0, float(y.min())), float(y.max())
        height = (high - low) or 1.0
        axes.set_ylim(low - 0.08 * height, high + 0.24 * height)
        contact_scale(axes, stop, term.factor)
        _mark_events(solution, axes, stop)
        shade_phases(solution, axes, numbered=True)
    _time_axes(solution, panels)
    for axes, transition in zip(below, enlarged, strict=True):
        draw_rebounds(axes, solution, transition)
        axes.set_title(f"rebounds of the {mechanism.transition_stop}, enlarged", fontsize=TEXT)
    legend_below(figure, phase_patches(solution), _event_handles(solution))
    return figure


def force_figure(solution: Solution) -> Figure:
    """Normal forces of all stops while they are closed, against time and index."""
    mechanism = solution.mechanism
    figure = new_figure(
        solution, "Forces of closed stops (normal, between collisions)",
        1.3 + _PANEL_IN * len(mechanism.stops),
    )  # fmt: skip
    panels = list[Axes](figure.subplots(len(mechanism.stops), 1, sharex=True, squeeze=False).flat)
    sampled = sample_forces(solution, 0.0, shown_until(solution))
    for axes, stop in zip(panels, mechanism.stops, strict=True):
        t, force = sampled[stop.name]
        axes.plot(MS_PER_S * t, force, color=line_colour(mechanism, stop.name), linewidth=1.4)
        tidy(axes, "", f"{stop.name}:\n{force_name(mechanism, stop.name)}")
        axes.set_ylim(0.0, 1.2 * float(np.nanmax(force, initial=0.0)) or 1.0)
        shade_phases(solution, axes, numbered=True)
    _time_axes(solution, panels)
    legend_below(figure, phase_patches(solution))
    return figure


def phase_figure(solution: Solution) -> Figure:
    """Phases and closed stops as bands over the index, one group of rows for each turn shown."""
    mechanism = solution.mechanism
    rows = ["phase", *(f"{stop.name} closed" for stop in mechanism.stops)]
    turns = math.ceil(shown_until(solution) / solution.shaft.period - _PART_OF_TURN)
    figure = new_figure(solution, "Phases over the index", 2.1 + 0.36 * len(rows) * turns)
    axes = figure.add_subplot()
    for turn in range(turns):
        _draw_turn(solution, axes, turn, -turn * (len(rows) + 1.0))
    ticks = [-turn * (len(rows) + 1.0) - row for turn in range(turns) for row in range(len(rows))]
    named = [f"turn {turn + 1}: {rows[0]}" if turns > 1 else rows[0] for turn in range(turns)]
    axes.set_yticks(ticks, [name for first in named for name in (first, *rows[1:])])
    tidy(axes, "index of the comb cycle (40 to a turn)", "")
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(0.0, INDEX_PER_TURN)
    axes.set_ylim(min(ticks) - 0.6, 1.6)
    axes.set_xticks(range(0, int(INDEX_PER_TURN) + 1, 2))
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    others: list[Artist] = [Patch(facecolor=_CLOSED, label="stop closed")]
    if shown_until(solution) < (1.0 - _PART_OF_TURN) * turns * solution.shaft.period:
        others.append(
            Patch(facecolor="white", edgecolor=_UNKNOWN, hatch="////", label="not simulated")
        )
    legend_below(figure, phase_patches(solution), others)
    return figure


def _time_axes(solution: Solution, panels: list[Axes]) -> None:
    """Time below the last panel, the index above the first."""
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    panels[-1].set_xlabel(TIME, fontsize=TEXT)
    index_scale(solution, panels[0])


def _mark_events(solution: Solution, axes: Axes, stop: Stop) -> None:
    """Mark a stop's events where they happen: at zero gap."""
    until = shown_until(solution)
    for kind in _EVENTS:
        events = [item for item in shown_events(solution, kind) if stop.name in item.stops]
        if not events:
            continue
        # A rest may lie just past the last state that was computed.
        t = [MS_PER_S * min(item.t, until) for item in events]
        axes.plot(t, [0.0] * len(t), **_marks(kind), clip_on=False, zorder=4)


def _event_handles(solution: Solution) -> list[Artist]:
    shown = (kind for kind in _EVENTS if shown_events(solution, kind))
    return [Line2D([], [], label=kind.value, **_marks(kind)) for kind in shown]


def _marks(kind: EventKind) -> dict[str, Any]:
    shape, face, size = _EVENTS[kind]
    return {"linestyle": "none", "marker": shape, "markersize": size, "markerfacecolor": face,
            "markeredgecolor": "black", "markeredgewidth": 0.9}  # fmt: skip


def _draw_turn(solution: Solution, axes: Axes, turn: int, top: float) -> None:
    """Bands of one turn: phases in the row at ``top``, closed stops below."""
    mechanism, period = solution.mechanism, solution.shaft.period
    begin, end = turn * period, min((turn + 1) * period, shown_until(solution))
    if end - begin < (1.0 - _PART_OF_TURN) * period:
        axes.barh(top, INDEX_PER_TURN, height=0.8, facecolor="white", edgecolor=_UNKNOWN,
                  hatch="////", linewidth=0.6)  # fmt: skip
    boundaries = []
    for item in intervals(solution):
        t_start, t_end = max(item.start, begin), min(item.end, end)
        if t_end <= t_start:
            continue
        start = index_at(solution, t_start)
        width = INDEX_PER_TURN * (t_end - t_start) / period
        boundaries += [start, index_at(solution, t_end)]
        # A band that passes the end of the scale goes on at its beginning.
        for left in (start, start - INDEX_PER_TURN):
            if left + width <= 0.0:
                continue
            axes.barh(top, width, left=left, height=0.8, facecolor=item.tint,
                      edgecolor="0.4", linewidth=0.6)  # fmt: skip
            seen_left, seen_right = max(left, 0.0), min(left + width, INDEX_PER_TURN)
            if item.number is not None and seen_right - seen_left > _NARROWEST_LABEL:
                axes.text(0.5 * (seen_left + seen_right), top, str(item.number), fontsize=SMALL,
                          ha="center", va="center")  # fmt: skip
            for row, stop in enumerate(mechanism.stops, start=1):
                if stop.name in item.closed:
                    axes.barh(top - row, width, left=left, height=0.5, color=_CLOSED)
    _label_boundaries(axes, boundaries, top + 0.48)


def _label_boundaries(axes: Axes, boundaries: list[float], height: float) -> None:
    """Write the indices of phase boundaries, in the order of time, where there is room."""
    labelled: list[float] = []
    for index in boundaries:
        if all(abs(index - other) > _CLOSEST_LABELS for other in labelled):
            axes.text(index, height, f"{index:.2f}", fontsize=SMALL - 1.0, rotation=90.0,
                      ha="center", va="bottom")  # fmt: skip
            labelled.append(index)
