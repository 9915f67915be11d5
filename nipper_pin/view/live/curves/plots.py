"""Curves of the present setting, of the one before it and of the pinned one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import numpy as np
import viser
from viser import uplot

from ....arrays import FloatArray
from ....hybrid.result.quantities import force_unit
from ....mechanism import Mechanism
from ....units import MM_PER_M
from ...naming import coordinate_shown
from ...reading import gap_noun
from ..answer import Answer
from ..panel.memory import Kept, Memory
from .axes import SteadyAxis, SteadyDecades

PINNED, BEFORE, NOW = "#E69F00", "#A6CDE6", "#0072B2"
"""Colours of the curves; of the dots as well."""
_HEIGHTS = (190, 170, 175)  # pixels, of the plots
_AXIS, _LABEL, _SIDE = 30, 18, 40  # pixels: axis below, its label, axis beside a plot
_DASH = (6, 3)
_TIME = "time from the first collision [ms]"
_DOT = 7.0  # pixels
_NONE = (np.zeros(1), np.zeros(1))
_Line = tuple[FloatArray, FloatArray]


class Plots:
    """Jaw angle with the gap at the contact, clamping force and impulses over one time.

    Attributes:
        legend: Which curve is which.
        gap, force, impulse: The plots. Their rows: time, pinned, before, now; of the first also
            the gap at the contact of the present setting, where the stop has lips.
    """

    def __init__(self, gui: viser.GuiApi, mechanism: Mechanism) -> None:
        """Put them there, empty."""
        stop = mechanism.stop(mechanism.transition_stop)
        term = coordinate_shown(mechanism, stop.index, small=True)
        unit = force_unit(mechanism, stop)
        self._lips = None
        if stop.contact is not None:
            self._lips = MM_PER_M * stop.lever / term.factor
        self._time, self._high, self._most = SteadyAxis(), SteadyAxis(), SteadyAxis()
        self._decades = SteadyDecades()
        gap = f"{stop.name} {gap_noun(mechanism, stop)} [{term.unit}]"
        self.legend = gui.add_html("")
        self.gap = _plot(gui, 0, gap, with_lips=self._lips is not None)
        self.force = _plot(gui, 1, f"clamping force [{unit}]")
        self.impulse = _plot(gui, 2, f"impulse [{unit} s]", dots=True)
        self._scale()

    @property
    def until(self) -> float:
        """End of the axis of time [ms]."""
        return self._time.top

    def forget(self) -> None:
        """Fit the axes to what is shown next."""
        for axis in (self._time, self._high, self._most, self._decades):
            axis.forget()

    def show(self, memory: Memory) -> None:
        """Draw the curves, or nothing where the present setting has none."""
        present = memory.present
        there = present is not None and not present.answer.message
        for part in (self.legend, self.gap, self.force, self.impulse):
            part.visible = there
        if not there:
            return
        kept = (memory.pinned, memory.before, present)
        self._hold([item.answer for item in kept if item is not None])
        gap = _together(kept, lambda item: (item.time, item.gap))
        if self._lips is not None:
            gap = (*gap, self._lips * gap[-1])
        force = _together(kept, lambda item: (item.force_time, item.force))
        impulse = _apart(kept)
        for plot, data in ((self.gap, gap), (self.force, force), (self.impulse, impulse)):
            plot.data = data
        self.legend.content = _legend(memory)

    def _hold(self, shown: Sequence[Answer]) -> None:
        """Let the axes hold all that is shown; they are sent only if one has changed."""
        before = self._ends()
        for item in shown:
            self._time.hold(float(item.force_time[-1]))
            self._high.hold(float(item.gap.max(initial=0.0)))
            self._most.hold(float(item.force.max(initial=0.0)))
        self._decades.hold(value for item in shown for value in item.impulse)
        if self._ends() != before:
            self._scale()

    def _ends(self) -> tuple[object, ...]:
        return self._time.top, self._high.top, self._most.top, self._decades.ends

    def _scale(self) -> None:
        x = uplot.Scale(time=False, range=(0.0, self._time.top))
        high = self._high.top
        self.gap.scales = {"x": x, "y": uplot.Scale(range=(0.0, high))}
        if self._lips is not None:
            lips = uplot.Scale(range=(0.0, self._lips * high))
            self.gap.scales = {**self.gap.scales, "lips": lips}
        self.force.scales = {"x": x, "y": uplot.Scale(range=(0.0, self._most.top))}
        self.impulse.scales = {"x": x, "y": uplot.Scale(distr=3, range=self._decades.ends)}
        # uPlot writes what is below a thousandth as 0.
        marks = self._decades.marks
        words = tuple(f"{mark:g}" for mark in marks)
        time, impulse = self.impulse.axes or ()
        self.impulse.axes = (time, {**impulse, "splits": marks, "values": words})


def _plot(
    gui: viser.GuiApi, place: int, label: str, *, dots: bool = False, with_lips: bool = False
) -> viser.GuiUplotHandle:
    """One plot; only the last one has the words of the time below it."""
    last = place == len(_HEIGHTS) - 1
    time = uplot.Axis(label=_TIME, size=_AXIS, labelSize=_LABEL) if last else uplot.Axis(size=_AXIS)
    axes, series = [time, _axis(label)], [uplot.Series(label=_TIME), *_series(dots=dots)]
    if with_lips:
        axes.append({**_axis("gap at the contact [mm]"), "side": 1, "scale": "lips"})
        series.append(uplot.Series(stroke="transparent", scale="lips"))
    drag = uplot.Cursor_Drag(x=False, y=False, setScale=False)
    return gui.add_uplot(
        _NONE[:1] * len(series),
        tuple(series),
        # Dragging would not be steady; the button beside a plot shows it larger.
        cursor=uplot.Cursor(drag=drag),
        axes=tuple(axes),
        legend=uplot.Legend(show=False),
        height=_HEIGHTS[place],
        padding=(10, 0 if with_lips else _SIDE + _LABEL, 0, 0),
    )


def _series(*, dots: bool) -> list[uplot.Series]:
    if dots:
        points = [uplot.Series_Points(show=True, size=_DOT, fill=colour, stroke=colour)
                  for colour in (PINNED, BEFORE, NOW)]  # fmt: skip
        return [uplot.Series(stroke="transparent", points=item) for item in points]
    hidden = uplot.Series_Points(show=False)
    return [
        uplot.Series(stroke=PINNED, width=1.5, dash=_DASH, points=hidden),
        uplot.Series(stroke=BEFORE, width=2.0, points=hidden),
        uplot.Series(stroke=NOW, width=2.0, points=hidden),
    ]


def _axis(label: str) -> uplot.Axis:
    """An upright axis, without the crowd of lines that a logarithmic one draws."""
    none = uplot.Axis_Ticks(show=False)
    grid = uplot.Axis_Grid(show=False)
    return uplot.Axis(label=label, size=_SIDE, labelSize=_LABEL, grid=grid, ticks=none)


def _together(
    kept: Sequence[Kept | None], line: Callable[[Answer], _Line]
) -> tuple[FloatArray, ...]:
    """Lines over all their times; each is straight between its own, and NaN beyond them."""
    lines = [None if item is None else line(item.answer) for item in kept]
    x = np.unique(np.concatenate([item[0] for item in lines if item is not None]))
    none = np.full(len(x), np.nan)
    return (
        x,
        *(none if item is None else np.interp(x, *item, left=np.nan, right=np.nan)
          for item in lines),
    )  # fmt: skip


def _apart(kept: Sequence[Kept | None]) -> tuple[FloatArray, ...]:
    """Impulses at the times of all collisions; NaN where a setting has none."""
    answers = [None if item is None else item.answer for item in kept]
    x = np.unique(np.concatenate([item.hit_time for item in answers if item is not None]))
    rows = [x]
    for item in answers:
        y = np.full(len(x), np.nan)
        if item is not None:
            y[np.searchsorted(x, item.hit_time)] = item.impulse
        rows.append(y)
    return tuple(rows)


def _legend(memory: Memory) -> str:
    """Which curve is which, with what is another number than now."""
    present = memory.present
    now = present.answer.parts if present is not None else ()
    lines = [_entry("now", NOW, "solid", "now")]
    for name, colour, style, words, kept in (
        ("before", BEFORE, "solid", "before", memory.before),
        ("pinned", PINNED, "dashed", "pinned", memory.pinned),
    ):
        if kept is not None:
            lines.append(_entry(name, colour, style, f"{words}: {unlike(kept, now)}"))
    return f'<div id="legend">{"".join(lines)}</div>'


def _entry(name: str, colour: str, style: str, words: str) -> str:
    line = f'<i style="border-top:3px {style} {colour}"></i>'
    return f'<span data-curve="{name}">{line}{escape(words)}</span>'


def unlike(kept: Kept, now: Sequence[str]) -> str:
    """The numbers of a setting that are others now.

    Args:
        kept: The setting.
        now: The present one in words.
    """
    other = kept.answer.parts
    return ", ".join(item for item in other if item not in now) or "the same setting"
