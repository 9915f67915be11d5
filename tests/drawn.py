"""A figure as text: what stands in it, where, and in which colours.

Reviewed texts of figures say this once, for every figure.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation

# Of so few points each is told.
_FEW = 8
# Smaller parts of a curve's largest value, or of 1, are zero.
_ROUND_OFF = 1e-10


def drawn(figure: Figure) -> str:
    """Titles, axes, curves, areas, words and legends, a line for each."""
    figure.draw_without_rendering()
    lines = [*_words("title", figure.get_suptitle()), *_words("below", figure.get_supxlabel())]
    for legend in figure.legends:
        lines += _legend(legend)
    for axes in figure.axes:
        lines += ["", *_axes(axes)]
    return "\n".join(lines) + "\n"


def _words(kind: str, text: str) -> Iterator[str]:
    yield from (f"{kind}: {line}" for line in text.splitlines())


def _axes(axes: Axes) -> Iterator[str]:
    if not axes.axison:
        yield "axes, not drawn"
        return
    yield f"axes {axes.get_title(loc='left') or axes.get_title() or '-'}"
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        low, high = axis.get_view_interval()
        words = " ".join(axis.get_label_text().split()) or "-"
        group = axes.get_shared_x_axes() if name == "x" else axes.get_shared_y_axes()
        shared = ", shared" if len(group.get_siblings(axes)) > 1 else ""
        span = f"from {_number(low)} to {_number(high)}"
        yield f"  {name}: {words}, {axis.get_scale()} {span}{shared}"
        # Of panels above another the places have no labels.
        ticks = [
            text.get_text()
            for place, text in zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=False)
            if min(low, high) <= place <= max(low, high) and text.get_text()
        ]
        if ticks and axis.get_scale() == "linear":
            yield f"  {name} ticks: {' '.join(ticks)}"
    for line in axes.lines:
        yield f"  line {_line(line)}"
    yield from _areas(axes)
    for item in axes.collections:
        yield f"  {_collection(item)}"
    for text in axes.texts:
        x, y = text.xy if isinstance(text, Annotation) else text.get_position()
        yield f"  text at {_number(x)}, {_number(y)}: {text.get_text()}"
    if legend := axes.get_legend():
        yield from (f"  {line}" for line in _legend(legend))
    for child in axes.child_axes:
        low, high = child.get_ylim()
        if child.get_ylabel():
            yield f"  beside: {child.get_ylabel()}, from {_number(low)} to {_number(high)}"


def _line(line: Line2D) -> str:
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    label = str(line.get_label())
    seen = np.isfinite(x) & np.isfinite(y)
    found = f"{'-' if label.startswith('_') else label}, {_look(line)}, {len(x)} places"
    if len(x) != seen.sum():
        found += f", {len(x) - seen.sum()} left out"
    if not seen.any():
        return found
    x, y = (np.where(abs(v) < _ROUND_OFF * abs(v).max(), 0.0, v) for v in (x[seen], y[seen]))
    if len(x) <= _FEW:
        return f"{found}: {_points(np.column_stack([x, y]))}"
    ends = ", ".join(_number(values[place]) for place in (0, -1) for values in (x, y))
    return f"{found}, x {_range(x)}, y {_range(y)}, ends {ends}"


def _areas(axes: Axes) -> Iterator[str]:
    """Rectangles by their look, each with where it begins and ends."""
    groups: dict[str, list[str]] = {}
    for patch in axes.patches:
        if isinstance(patch, Rectangle):
            ends = patch.get_x(), patch.get_x() + patch.get_width()
            place = _number(patch.get_y() + 0.5 * patch.get_height())
            text = f"{_number(ends[0])}..{_number(ends[1])} at {place}"
            groups.setdefault(_look(patch), []).append(text)
    for look, places in groups.items():
        yield f"  areas {look}: {', '.join(places)}"


def _collection(item: Collection) -> str:
    if isinstance(item, ContourSet):
        kind = "filled" if item.filled else to_hex(item.get_edgecolors()[0])
        return f"levels {kind}: {', '.join(_number(level) for level in item.levels)}"
    ends = [path.vertices for path in item.get_paths()]
    values = item.get_array()
    if values is not None:
        return f"cells: {_range(np.ma.compressed(np.ma.masked_invalid(values)))}"
    points = np.concatenate(ends) if ends else np.empty((0, 2))
    name = type(item).__name__
    if isinstance(item, PolyCollection) and len(points) <= 2 * _FEW:
        return f"{name} {_look(item)}: {_points(points)}"
    return f"{name} {_look(item)}: {len(ends)}, x {_range(points[:, 0])}, y {_range(points[:, 1])}"


def _legend(legend: Legend) -> Iterator[str]:
    for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True):
        if text.get_text().strip():
            yield f"legend: {text.get_text()}, {_look(handle)}"


def _look(item: Artist | None) -> str:
    """Colour, mark and hatch."""
    shown: Any = item
    if isinstance(item, Line2D):
        if (mark := str(item.get_marker())) == "None":
            dashed = "" if item.get_linestyle() == "-" else " dashed"
            return to_hex(item.get_color()) + dashed
        return f"{to_hex(item.get_markeredgecolor())} {mark}"
    colour = shown.get_facecolor()
    if len(np.atleast_2d(colour)) == 0:
        colour = shown.get_edgecolor()
    return to_hex(np.atleast_2d(colour)[0]) + (" hatched" if shown.get_hatch() else "")


def _points(points: Iterable[Iterable[float]]) -> str:
    return ", ".join(f"({' '.join(_number(value) for value in point)})" for point in points)


def _range(values: Iterable[float]) -> str:
    found = np.asarray(list(values), dtype=float)
    return f"{_number(found.min())}..{_number(found.max())}" if found.size else "none"


def _number(value: float) -> str:
    """Four digits; what is round-off beside 1 is zero."""
    return f"{0.0 if abs(value) < _ROUND_OFF else float(value):.4g}"
