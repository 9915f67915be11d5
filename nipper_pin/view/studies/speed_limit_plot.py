"""How fast a machine can run, as a figure."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, MultipleLocator

from ...hybrid import START_INDEX
from ...mechanism import INDEX_PER_TURN, counted_from
from ...study.speed_limit import SpeedLimit, Verdict, where
from ...terms import TERMS
from ..style import LINES, SMALL, framed, tidy

_INDEX_TICKS = 2.0
_DOTS = "A dot is a turn that goes on; several at one speed are turns that differ."
_RESTS = {Verdict.YES: "at rest before it opens", Verdict.NO: "not at rest before it opens",
          Verdict.UNKNOWN: "not known"}  # fmt: skip
_REPEATS = {Verdict.YES: "turns repeat", Verdict.NO: "turns differ from one another",
            Verdict.UNKNOWN: "not known"}  # fmt: skip
_MOST_LINES = 5


def speed_limit_figure(result: SpeedLimit) -> Figure:
    """Indices of first touch, rest and opening by speed, of all turns that go on; time clamped."""
    figure = framed(_answer(result), (result.title, _DOTS), 5.8)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    _indices(result, above)
    share = TERMS["clamped_share"].shown()
    below.plot(result.speed_rpm, share.value(result.clamped_share), color=LINES[0], linewidth=1.2)
    below.set_ylim(bottom=0.0)
    for ranges, texts in ((result.settled, _RESTS), (result.single, _REPEATS)):
        # More lines than these hide what they mark.
        for part in ranges[1:] if len(ranges) <= _MOST_LINES else ():
            for axes in (above, below):
                axes.axvline(part.low_rpm, color="0.4", linewidth=0.8, linestyle="--")
            above.annotate(
                f"from {part.low_rpm:,.0f} r/min: {texts[part.verdict]}", (part.low_rpm, 0.98),
                (3.0, 0.0), va="top", ha="left", xycoords=("data", "axes fraction"),
                textcoords="offset points", rotation=90, fontsize=SMALL,
                path_effects=[withStroke(linewidth=2.0, foreground="white")],
            )  # fmt: skip
    tidy(above, "", "index of the comb cycle (40 to a turn)")
    tidy(below, TERMS["speed_rpm"].shown().label, f"clamped\n[{share.unit} of a turn]")
    return figure


def _indices(result: SpeedLimit, axes: Axes) -> None:
    """First touch, rest and opening, and between the last two the time that clamps."""
    speed = np.repeat(result.speed_rpm, result.rests.shape[1])
    rest, opening, rests, touches = (
        counted_from(START_INDEX, index)
        for index in (result.rest, result.opening, result.rests, result.touches)
    )
    axes.fill_between(
        result.speed_rpm, rest, opening, color=LINES[0], alpha=0.12, linewidth=0,
        label=f"{result.stop} closed and at rest",
    )  # fmt: skip
    axes.plot(result.speed_rpm, opening, color=LINES[2], linewidth=1.4,
              label=f"{result.stop} opens")  # fmt: skip
    for values, colour, text in (
        (rests, LINES[0], "comes to rest"), (touches, LINES[1], "touches first"),
    ):  # fmt: skip
        axes.plot(speed, values.ravel(), ".", color=colour, markersize=1.5,
                  label=f"{result.stop} {text}")  # fmt: skip
    axes.yaxis.set_major_locator(MultipleLocator(_INDEX_TICKS))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value % INDEX_PER_TURN:g}"))
    axes.legend(fontsize=SMALL, loc="center left", markerscale=5.0)


def _answer(result: SpeedLimit) -> str:
    """The answer as the title of the figure."""
    rests = where(result.settled, Verdict.YES) or "at none of these speeds"
    unknown = where(result.settled, Verdict.UNKNOWN)
    known = f"\nnot known {unknown}" if unknown else ""
    return f"The {result.stop} is at rest before it opens {rests}{known}"
