"""Labels, scales, letters and legends of the study's figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

from nipper_pin.view.paper.canvas import Plate

SPEEDS = ["450 r/min", "550 r/min", "650 r/min"]
COUNTED = ["threshold 0.001 rad/s", "threshold 0.02 rad/s", "threshold 0.06 rad/s"]
_TURN, _INDEX = "index of the comb cycle (40 to a turn)", "index (40 to a turn)"
_INERTIA = "shaft inertia by that of the model [-]"
_BAR = ("", "linear", "function", "")
# By figure and panel: labels of x and y, their scales, title, and entries of the legend.
PANELS: dict[str, list[tuple[Any, ...]]] = {
    "figure_11": [
        ("", "jaw angle [mdeg]", "linear", "linear", "(a)  450 r/min"),
        ("", "jaw angle [mdeg]", "linear", "linear", "(b)  550 r/min"),
        ("time from the first collision [ms]", "jaw angle [mdeg]", "linear", "linear",
         "(c)  650 r/min"),
    ],
    "figure_12": [
        ("number of the collision", "impulse [N s]", "linear", "linear", "(a)", *SPEEDS),
        ("number of the collision", "impulse [N s]", "linear", "log", "(b)  logarithmic"),
    ],
    "figure_13": [
        ("restitution e [-]", "time to rest [ms]", "linear", "linear", "(a)", "ours",
         "published ratio"),
        ("restitution e [-]", "collisions", "linear", "linear", "(b)", *COUNTED),
    ],
    "figure_14": [
        ("spring rate [N/mm]", "time [ms]", "linear", "linear", "(a)", "time to rest",
         "first rebound", "published ratio", "second rebound"),
        ("spring rate [N/mm]", "collisions", "linear", "linear", "(b)", *COUNTED),
    ],
    "guide": [
        ("", "pendulum\nangle [deg]", "linear", "linear", "(a)"),
        ("", "pendulum\nrate [rad/s]", "linear", "linear", "(b)", *SPEEDS),
        (_TURN, "pendulum\nacceleration [rad/s²]", "linear", "linear", "(c)"),
    ],
    "links": [
        ("", "rotation [deg]", "linear", "linear", "(a)"),
        ("", "angular rate\n[rad/s]", "linear", "linear", "(b)"),
        (_TURN, "angular acceleration\n[rad/s²]", "linear", "linear", "(c)"),
    ],
    "both_stops": [
        ("", "jaw angle\n[deg]", "linear", "linear", "(a)"),
        ("", "stroke s\n[mm]", "linear", "linear", "(b)"),
        ("", "rate of jaw angle\n[rad/s]", "linear", "linear", "(c)"),
        ("", "rate of stroke s\n[m/s]", "linear", "linear", "(d)"),
        (_INDEX, "acceleration of jaw angle\n[rad/s²]", "linear", "linear", "(e)"),
        (_INDEX, "acceleration of stroke s\n[m/s²]", "linear", "linear", "(f)"),
    ],
    "thresholds": [
        ("threshold [rad/s]", "collisions", "log", "linear", "(a)", "e = 0.05", "e = 0.15",
         "e = 0.25", "rebounds +300 %"),
        ("threshold [rad/s]", "increase of the\ntime to rest [-]", "log", "linear", "(b)",
         "stop at the threshold", "limit of the series", "published"),
    ],
    "drives": [
        (_INERTIA, "change of the\nfirst rebound amplitude [%]", "log", "log", "(a)", *SPEEDS),
        (_INERTIA, "change of the\ntime to rest [%]", "log", "log", "(b)"),
    ],
    "stop_force": [
        (_INDEX, "stop force with the jaw open [N]", "linear", "linear", "(a)", *SPEEDS),
        ("cylinder speed [r/min]", "preload [mm]", "linear", "linear", "(b)", "lets go beyond"),
        (_BAR[0], "smallest stop force [N]", *_BAR[1:]),
    ],
    "fixed_step": [
        ("step [s]", "relative error", "log", "log", "(a)  forward"),
        ("step [s]", "relative error", "log", "log", "(b)  semi-implicit"),
    ],
    "shares": [
        ("restitution e [-]", "share of the first two rebounds [%]", "linear", "linear", "(a)",
         "1 - e²", *SPEEDS, "published"),
        ("restitution e [-]", "difference from 1 - e²\n[points of %]", "linear", "linear",
         "(b)"),
    ],
    "designs": [
        ("speed [r/min]", "restitution e [-]", "linear", "linear", "(a)  7 N/mm"),
        ("speed [r/min]", "", "linear", "linear", "(b)  9 N/mm"),
        ("speed [r/min]", "", "linear", "linear", "(c)  11 N/mm"),
        (_BAR[0], "time to rest [ms]", *_BAR[1:]),
    ],
}  # fmt: skip
# Figures with the same series in every panel, in one order and in the same colours.
_ALIKE = ("figure_12", "guide", "links", "drives", "fixed_step")


def check(plates: Sequence[Plate], names: Sequence[str], mark: str) -> None:
    """Compare all panels of some figures with the table, and what holds of any of them."""
    assert [item.name for item in plates] == list(names)
    for plate in plates:
        figure = plate.figure
        assert [text.get_text() for text in figure.texts] == [mark], plate.name
        assert figure.texts[0].get_position()[1] < 0.05
        panels = figure.axes
        assert [described(axes) for axes in panels] == PANELS[plate.name], plate.name
        for axes in panels:
            lines = [line for line in axes.lines if len(line.get_xdata()) > 2]
            looks = [(line.get_color(), line.get_linestyle()) for line in lines]
            assert len(set(looks)) == len(looks), plate.name
            if lines:
                _fills(axes, plate.name)
        if plate.name in _ALIKE:
            every = [[to_hex(line.get_color()) for line in axes.lines] for axes in panels]
            assert all(colours == every[0] for colours in every), plate.name


def described(axes: Axes) -> tuple[Any, ...]:
    """The panel as the table has it."""
    found = axes.get_legend()
    words = [text.get_text() for text in found.get_texts()] if found else []
    scales = (axes.get_xscale(), axes.get_yscale())
    return (axes.get_xlabel(), axes.get_ylabel(), *scales, axes.get_title(loc="left"), *words)


def _fills(axes: Axes, name: str) -> None:
    """Everything drawn is inside, and takes a good part of the panel where it has its own axes."""
    # Limits are found when they are asked for.
    assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()
    figure_to_axes = axes.transData + axes.transAxes.inverted()
    shared = [axes, *axes.get_shared_y_axes().get_siblings(axes)]
    points = np.concatenate([
        figure_to_axes.transform(np.asarray(line.get_xydata(), dtype=float))
        for item in shared for line in item.lines
        if line.get_transform() == item.transData and len(line.get_xdata())
    ])  # fmt: skip
    points = points[np.isfinite(points).all(axis=1)]
    assert points.min() > -1e-9, name
    assert points.max() < 1.0 + 1e-9, name
    assert points.max(axis=0).min() > 0.4, name
    assert np.ptp(points[:, 0]) > 0.4, name
