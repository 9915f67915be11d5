"""How fast a machine can run, as a figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...outputs import check_file, complete_file
from ...study.speed_limit import SpeedLimit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FORMATS = ("png", "svg", "pdf")


def check_figure(path: str | Path) -> str:
    """Return the format of a figure's file by its suffix, if it can be written.

    Args:
        path: The file.

    Raises:
        InputError: It cannot be written, or has another suffix.
    """
    kind = Path(path).suffix.removeprefix(".").lower()
    if kind not in _FORMATS:
        message = f"{path}: a figure is written as .png, .svg or .pdf; end its name so"
        raise InputError(message, file=str(path), formats=_FORMATS)
    check_file(path)
    return kind


def plot_speed_limit(result: SpeedLimit, path: str | Path) -> Path:
    """Write the figure; the file appears only when it is complete.

    Args:
        result: The study.
        path: The file, in the format of its suffix.

    Raises:
        InputError: The file cannot be written, or is none of a figure.
    """
    from ..plain_texts import plain

    target, kind = Path(path), check_figure(path)
    with complete_file(target) as partial:
        plain(speed_limit_figure(result)).savefig(partial, format=kind)
    return target


def speed_limit_figure(result: SpeedLimit) -> Figure:
    """Indices of first touch, rest and opening by speed, with all turns that go on; time clamped.

    Args:
        result: The study.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from ..style import LINES, SMALL, TEXT, WIDTH_IN, tidy

    figure = Figure(figsize=(WIDTH_IN, 5.6), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(f"{result.title}: how fast it can run", fontsize=TEXT)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    speed = np.repeat(result.speed_rpm, result.rests.shape[1])
    for values, colour, text in (
        (result.rests, LINES[0], "at rest"), (result.touches, LINES[1], "touches first"),
    ):  # fmt: skip
        above.plot(speed, values.ravel(), ".", color=colour, markersize=1.5,
                   label=f"{result.stop} {text}")  # fmt: skip
    above.plot(result.speed_rpm, result.opening, color=LINES[2], linewidth=1.0,
               label=f"{result.stop} opens")  # fmt: skip
    below.plot(result.speed_rpm, result.clamped_share, color=LINES[0], linewidth=1.0)
    for limit, text in ((result.settles_rpm, "no rest"), (result.repeats_rpm, "turns differ")):
        if limit is not None:
            for axes in (above, below):
                axes.axvline(limit, color="0.4", linewidth=0.8, linestyle="--")
            above.annotate(f" {text}: {limit:.4g} r/min", (limit, 1.0), va="top", fontsize=SMALL,
                           xycoords=("data", "axes fraction"), rotation=90)  # fmt: skip
    above.legend(fontsize=SMALL, loc="center left", markerscale=4.0)
    tidy(above, "", "index, counted from 24")
    tidy(below, "cylinder speed [r/min]", "clamped share")
    return figure
