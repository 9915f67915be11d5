"""A drawing of a mechanism by the symbols of textbooks: links, joints, springs, drives, stops."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon
from scipy.spatial import ConvexHull, QhullError

from ...arrays import FloatArray
from ...mechanism import Mechanism
from ...units import MM_PER_M
from ..figure_file import write_figure
from ..scene.colours import SPRING, STOP, link_colour
from ..style import SMALL, TEXT, WIDTH_IN, blank
from .places import Node, Sketch, sketch

# Places that are tried: directions and distances by the size of the drawing.
_DIRECTIONS = 16
_DISTANCES = (0.05, 0.08, 0.12, 0.17, 0.23, 0.3)
# Size of a character and of a line, by that of the drawing.
_WIDE, _HIGH, _PAD = 0.0125, 0.026, 0.006
_INK, DRIVE = "#1c2430", "#0072B2"
# Sizes of symbols by that of the mechanism.
_PIN, _BAR, _COIL, _ARROW = 0.013, 9.0, 0.09, 0.07


def write_sketch(mechanism: Mechanism, path: str | Path) -> Path:
    """Write the labelled drawing of a mechanism in its touch configuration.

    Args:
        path: File to write, ``NAME.svg``, ``.png`` or ``.pdf``; it appears when it is complete.

    Raises:
        InputError: The file cannot be written, or its suffix names no format.
    """
    return write_figure(drawn(sketch(mechanism)), path)


def drawn(shown: Sketch) -> Figure:
    """The figure of a sketch."""
    figure = blank(WIDTH_IN)
    axes = figure.add_subplot()
    points = np.concatenate(
        [link.points for link in shown.links] + [ends for _, ends in shown.struts]
    )
    if shown.crank is not None:
        axis, radius = shown.crank
        points = np.concatenate([points, axis + radius * np.array([[-1, -1], [1, 1]])])
    points = MM_PER_M * points
    # A machine without any length is drawn in a square of one metre, as it is viewed.
    extent = float(np.ptp(points, axis=0).max())
    size = extent or MM_PER_M
    labels = symbols(axes, shown, size).labels
    _opening(axes, shown, size)
    room = (0.16 if extent else 0.5) * size
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]", fontsize=SMALL)
    axes.set_ylabel("z [mm]", fontsize=SMALL)
    axes.tick_params(labelsize=SMALL)
    for label in placed(labels, low, high):
        line = {"arrowstyle": "-", "color": label.colour, "lw": 0.5}
        paper = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.8}
        axes.annotate(
            label.text, (label.at[0], label.at[1]), label.text_at, fontsize=SMALL, ha="center",
            va="center", color=label.colour, arrowprops=line, bbox=paper, parse_math=False,
        )  # fmt: skip
    title = textwrap.fill(f"{shown.title}: touch configuration", 80)
    axes.set_title(title, fontsize=TEXT, parse_math=False)
    figure.supxlabel(
        "circle: pin; dashed circle: pin that closes a loop; box: slide; hatched: joint with the "
        "frame;\nblue: driven; red: spring; orange: stop, the arrow shows how it opens",
        fontsize=SMALL,
    )
    return figure


@dataclass(frozen=True)
class Label:
    """A text and what it names.

    Attributes:
        at: What it names, shape (2,), in the unit of the drawing.
        colour: As in #RRGGBB.
        text_at: Middle of the text, shape (2,).
    """

    text: str
    at: FloatArray
    colour: str
    text_at: tuple[float, float] = (0.0, 0.0)


def placed(labels: Sequence[Label], low: FloatArray, high: FloatArray) -> list[Label]:
    """Labels with places: each at the nearest one that covers no other label and nothing named.

    Args:
        low: Lower left corner of the drawing, shape (2,).
        high: Upper right one.
    """
    size = float((high - low).max())
    named = np.array([label.at for label in labels])
    taken: list[FloatArray] = []
    found = []
    for label in labels:
        lines = label.text.splitlines()
        half = 0.5 * size * np.array([_WIDE * max(map(len, lines)), _HIGH * len(lines)])
        half += _PAD * size
        best, least = label.at, np.inf
        for distance in _DISTANCES:
            for turn in np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False):
                way = np.array([np.cos(turn), np.sin(turn)])
                middle = label.at + way * (distance * size + np.abs(way) * half)
                cost = _cost(middle, half, low, high, taken, named) + distance
                if cost < least:
                    best, least = middle, cost
        taken.append(np.array([best - half, best + half]))
        found.append(replace(label, text_at=(float(best[0]), float(best[1]))))
    return found


def _cost(
    middle: FloatArray,
    half: FloatArray,
    low: FloatArray,
    high: FloatArray,
    taken: list[FloatArray],
    named: FloatArray,
) -> float:
    """How many labels, named places and edges of the drawing a label there would cover."""
    begin, end = middle - half, middle + half
    cost = 3.0 * float((begin < low).any() or (end > high).any())
    cost += 2.0 * sum(float((begin < other[1]).all() and (end > other[0]).all()) for other in taken)
    return cost + float(((named > begin) & (named < end)).all(axis=1).sum())


@dataclass
class Symbols:
    """What is drawn of a sketch, in mm.

    Attributes:
        labels: Names, and what they name.
        links: Bar or plate of each link.
        struts: Line of each spring or damper between two points.
        carried: All others that move, each with the place of the link that carries it.
    """

    labels: list[Label] = field(default_factory=list)
    links: list[Polygon] = field(default_factory=list)
    struts: list[Line2D] = field(default_factory=list)
    carried: list[tuple[int, Artist]] = field(default_factory=list)


def symbols(axes: Axes, shown: Sketch, size: float) -> Symbols:
    """Draw links, joints, springs and stops in axes of a size, both in mm."""
    made = Symbols()
    _links(axes, shown, made)
    _crank(axes, shown, made)
    for name, ends in shown.struts:
        begin, end = MM_PER_M * ends
        made.struts.append(_coil(axes, begin, end, _PIN * size))
        made.labels.append(Label(name, 0.5 * (begin + end), SPRING))
    for node in shown.nodes:
        _node(axes, node, size, made)
    for stop in shown.stops:
        at = MM_PER_M * stop.place
        cross = axes.plot(*at, marker="x", color=STOP, ms=7, mew=2, zorder=6)
        made.carried.append((stop.body, cross[0]))
        made.labels.append(Label(f"stop: {stop.name}", at, STOP))
    return made


def _links(axes: Axes, shown: Sketch, made: Symbols) -> None:
    """Bars and plates through the points of each link."""
    for link in shown.links:
        colour = link_colour(link.body)
        corners = MM_PER_M * np.unique(link.points.round(9), axis=0)
        if len(corners) > 2:
            try:
                corners = corners[ConvexHull(corners).vertices]
            except QhullError:
                # Points on one line: a bar between the outermost ones.
                along = corners[-1] - corners[0]
                corners = corners[np.argsort(corners @ along)][[0, -1]]
        # Paler by itself: what is transparent would show where the edge covers the face.
        pale = tuple(0.45 + 0.55 * part for part in colour)
        made.links.append(Polygon(corners, closed=len(corners) > 2, fc=pale, ec=pale, lw=_BAR,
                                  joinstyle="round", capstyle="round", zorder=1))  # fmt: skip
        axes.add_patch(made.links[-1])
        made.labels.append(Label(link.name.replace("_", " "), corners.mean(axis=0), _INK))


def _node(axes: Axes, node: Node, size: float, made: Symbols) -> None:
    """The symbol of a joint, and of what acts on it."""
    at, radius = MM_PER_M * node.place, _PIN * size
    colour = DRIVE if node.driven else _INK
    if node.ground:
        foot = np.array([[0.0, 0.0], [-2.0, -3.0], [2.0, -3.0]]) * radius + at
        axes.add_patch(Polygon(foot, fc="white", ec=_INK, lw=0.8, hatch="////", zorder=3))
    symbol: Patch
    if node.kind in ("slide", "slot"):
        # A block that slides along a direction.
        across = np.array([-node.along[1], node.along[0]])
        corners = np.array([[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]]) * radius
        symbol = Polygon(at + corners @ [node.along, across], fc="white", ec=colour, lw=1.4,
                         zorder=5)  # fmt: skip
    else:
        style = "--" if node.kind == "cut pin" else "-"
        symbol = Circle((at[0], at[1]), radius, fc="white", ec=colour, lw=1.4, ls=style, zorder=5)
    axes.add_patch(symbol)
    made.carried.append((node.body, symbol))
    if node.spring and node.along.any():
        coil = _coil(axes, at, at + _COIL * size * node.along, radius)
        made.carried.append((node.body, coil))
    name = node.name.replace("_", " ")
    if node.driven:
        name = f"{name}\ndriven: {node.driven}"
    if node.spring:
        name = f"{name}\nspring: {node.spring}"
    made.labels.append(Label(name, at, colour))


def _coil(axes: Axes, begin: FloatArray, end: FloatArray, radius: float) -> Line2D:
    """A zigzag between two points."""
    share = np.linspace(0.0, 1.0, 14)
    along = end - begin
    across = np.array([-along[1], along[0]]) / np.hypot(*along)
    swing = np.where(np.arange(14) % 2 == 0, 1.0, -1.0)
    swing[[0, -1]] = 0.0
    line = begin + share[:, None] * along + 0.8 * radius * swing[:, None] * across
    return axes.plot(*line.T, color=SPRING, lw=1.0, zorder=4)[0]


def _opening(axes: Axes, shown: Sketch, size: float) -> None:
    """How stops open."""
    for stop in shown.stops:
        at = MM_PER_M * stop.place
        if stop.along.any():
            tip = at + _ARROW * size * stop.along / np.hypot(*stop.along)
            arrow = {"arrowstyle": "->", "color": STOP, "lw": 1.4}
            axes.annotate("", (tip[0], tip[1]), (at[0], at[1]), arrowprops=arrow, zorder=6)


def _crank(axes: Axes, shown: Sketch, made: Symbols) -> None:
    """The circle of the cylinder's crank pin."""
    if shown.crank is None:
        return
    axis, radius = MM_PER_M * shown.crank[0], MM_PER_M * shown.crank[1]
    axes.add_patch(
        Circle((axis[0], axis[1]), radius, fc="none", ec=DRIVE, lw=0.9, ls=":", zorder=2)
    )
    axes.plot(*axis, marker="+", color=DRIVE, ms=8, zorder=2)
    at = axis + radius * np.array([0.7, -0.7])
    made.labels.append(Label("crank pin of the cylinder", at, DRIVE))
