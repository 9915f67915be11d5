"""Figures of what the published study leaves open."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...arrays import FloatArray
from ...study.paper import PaperStudy
from ...study.paper.designs import RESTITUTIONS
from ...study.paper.drives import FACTORS
from ...study.paper.fixed_step import FixedStep
from ...units import MS_PER_S
from ..style import LINES, MARKERS, SMALL, TEXT, tidy
from .canvas import Plate, grid, letter, new_figure, plate
from .terms import SHARE, TIME, terms

# Where lines of time and of index are labelled, in parts of the range of speeds, how far a label
# may go from there, and how far it stands from the frame.
_LABELLED = (0.13, 0.8)
_AWAY = 0.37
_MARGIN = 0.012


def question_plates(study: PaperStudy) -> list[Plate]:
    """Draw one figure for each open question."""
    steps = [] if study.fixed_step is None else [_fixed_step(study.fixed_step, terms(study).mark)]
    return [
        _thresholds(study), _drives(study), _stop_force(study), *steps, _shares(study),
        _designs(study),
    ]  # fmt: skip


def _thresholds(study: PaperStudy) -> Plate:
    counts = study.counts
    figure = new_figure(3.4, terms(study).mark)
    number, time = figure.subplots(1, 2)
    values = study.studies.restitution.values
    for i, column in enumerate((0, 2, 4)):
        number.step(counts.thresholds, counts.restitution[:, column], where="post",
                    color=LINES[i], linewidth=1.3, label=f"e = {values[column]:g}")  # fmt: skip
    for low, high in counts.rebounds_match:
        number.axvspan(low, high, facecolor="0.85", linewidth=0, zorder=0,
                       label="rebounds +300 %")  # fmt: skip
    number.set_xscale("log")
    number.yaxis.set_major_locator(MaxNLocator(integer=True))
    number.set_ylim(0.0, 1.35 * counts.restitution.max())
    number.legend(fontsize=SMALL, frameon=False, ncols=2, loc="upper right")
    tidy(number, "threshold [rad/s]", "collisions")
    time.semilogx(counts.thresholds, counts.time_increase, color=LINES[0], linewidth=1.3,
                  label="stop at the threshold")  # fmt: skip
    durations = study.studies.restitution.durations
    time.axhline(durations[-1] / durations[0] - 1.0, color=LINES[1], linestyle="--", linewidth=1.1,
                 label="limit of the series")  # fmt: skip
    if study.compared:
        time.axhline(study.published.ratios["restitution.transition_time_increase"], color="black",
                     linestyle=":", linewidth=1.1, label="published")  # fmt: skip
    time.legend(fontsize=SMALL, frameon=False)
    tidy(time, "threshold [rad/s]", f"increase of the\n{TIME.words} [-]")
    for axes, text in ((number, "(a)"), (time, "(b)")):
        letter(axes, text)
        grid(axes)
    shaded = "Shaded: where the number of rebounds grows as published. "
    return plate(
        "thresholds",
        "Collisions and time to rest over the threshold",
        "(a) Number of collisions against the separation rate at which one stops to count, for "
        f"three restitutions. {shaded if study.compared else ''}(b) Increase "
        "of the time to rest from the smallest to the largest restitution when the transition "
        "ends at that collision; beyond the end of the line one of the two transitions has no "
        "length.",
        figure,
    )


def _drives(study: PaperStudy) -> Plate:
    figure = new_figure(3.3, terms(study).mark)
    panels = figure.subplots(1, 2, sharex=True)
    names = (("first_amplitude", "first rebound amplitude"), ("transition_time", TIME.words))
    for axes, (name, text), mark in zip(panels, names, "ab", strict=True):
        for i, speed in enumerate(study.published.speeds_rpm):
            rows = [item for item in study.drives.effects if item.speed_rpm == speed]
            sizes = [100.0 * abs(getattr(item, name)) for item in rows]
            axes.loglog(FACTORS, sizes, color=LINES[i], marker=MARKERS[i], markersize=4.0,
                        linewidth=1.1, label=f"{speed:g} r/min")  # fmt: skip
        axes.axvline(1.0, color="0.5", linewidth=0.8, linestyle=":")
        letter(axes, f"({mark})")
        grid(axes)
        tidy(axes, "shaft inertia by that of the model [-]", f"change of the\n{text} [%]")
    panels[0].legend(fontsize=SMALL, frameon=False)
    own = (item for item in study.drives.effects if item.factor == 1.0)
    worst = 100.0 * max(abs(item.first_amplitude) for item in own)
    return plate(
        "drives",
        "Inertial shafts beside held ones",
        "Size of the change of (a) the first rebound amplitude and (b) the time to rest when "
        "an impact is free to change the speed of the shafts, against their reflected inertia. "
        f"With the model's own inertias (dotted) the amplitude changes by at most {worst:.2g} %; "
        "the change falls with the inertia, so held shafts are the limit.",
        figure,
    )


def _stop_force(study: PaperStudy) -> Plate:
    stop, words = study.phase_one, terms(study)
    figure = new_figure(3.6, terms(study).mark)
    curve, chart = figure.subplots(1, 2)
    for i, speed in enumerate(study.published.speeds_rpm):
        curve.plot(stop.index, stop.force(stop.preload, speed), color=LINES[i], linewidth=1.3,
                   label=f"{speed:g} r/min")  # fmt: skip
    curve.axhline(0.0, color="black", linewidth=0.8)
    curve.legend(fontsize=SMALL, frameon=False)
    tidy(curve, "index (40 to a turn)", "stop force with the jaw open [N]")
    forces = stop.smallest_forces()
    preloads = words.preload.value(stop.preloads)
    filled = chart.contourf(stop.speeds_rpm, preloads, forces, levels=12, cmap="RdBu",
                            vmin=-np.abs(forces).max(), vmax=np.abs(forces).max())  # fmt: skip
    _bar(figure, filled, [chart], "smallest stop force [N]")
    limit = [stop.threshold_rpm(float(p)) for p in stop.preloads]
    chart.plot(limit, preloads, color="black", linewidth=1.6, label="lets go beyond")
    for item in stop.releases:
        stays = item.index is None
        chart.plot(item.speed_rpm, words.preload.value(stop.preload),
                   "s" if stays else "X", markersize=6.0,
                   color="black", markeredgecolor="white", markeredgewidth=0.6)  # fmt: skip
    chart.set_xlim(stop.speeds_rpm[0], stop.speeds_rpm[-1])
    chart.legend(fontsize=SMALL, loc="lower right")
    tidy(chart, "cylinder speed [r/min]", words.preload.label)
    letter(curve, "(a)")
    letter(chart, "(b)")
    grid(curve)
    threshold = stop.threshold_rpm(stop.preload)
    begins = (
        f"With the model's preload that begins at {threshold:.1f} r/min. "
        if np.isfinite(threshold)
        else ""
    )
    return plate(
        "stop_force",
        f"Force on the stop of the {words.stop} in phase 1",
        "(a) Force of the stop while the jaw is open, preload "
        f"{words.preload.value(stop.preload):g} {words.preload.unit}, as if "
        "it could pull. (b) Its smallest value over speed and preload; right of the line the "
        f"{words.stop} leaves its stop. {begins}Marks: simulated turns, squares where "
        "it stays, crosses where it lets go.",
        figure,
    )


def _fixed_step(data: FixedStep, mark: str) -> Plate:
    figure = new_figure(3.6, mark)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    labels = ("first rebound time", "second rebound time", "first amplitude", TIME.words)
    for axes, rule, mark in zip(panels, data.rules, "ab", strict=True):
        for i, label in enumerate(labels):
            axes.loglog(rule.steps_s, np.abs(rule.errors[:, i]), color=LINES[i], marker=MARKERS[i],
                        markersize=4.0, linewidth=1.1, label=label)  # fmt: skip
        steps = rule.steps_s[[0, -1]]
        axes.loglog(steps, steps / steps[0] * 3e-3, color="black", linestyle=":", linewidth=1.0,
                    label="order 1")  # fmt: skip
        letter(axes, f"({mark})  {rule.name}")
        grid(axes)
        tidy(axes, "step [s]", "relative error")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=5,
                  fontsize=SMALL, frameon=False)  # fmt: skip
    return plate(
        "fixed_step",
        "Error of fixed steps",
        "Relative errors of the fixed-step scheme against our solution for two explicit rules; "
        "the study does not say which it uses. The smallest step is the published one.",
        figure,
    )


def _shares(study: PaperStudy) -> Plate:
    data = study.shares
    figure = new_figure(3.5, terms(study).mark)
    axes, rest = figure.subplots(1, 2)
    axes.plot(data.restitutions, SHARE.value(data.ballistic), color="black", linestyle="--",
              linewidth=1.2, label="1 - e²")  # fmt: skip
    for i, speed in enumerate(data.speeds_rpm):
        axes.plot(data.restitutions, SHARE.value(data.shares[i]), color=LINES[i], linewidth=1.2,
                  label=f"{speed:g} r/min")  # fmt: skip
        rest.plot(data.restitutions, 100.0 * (data.shares[i] - data.ballistic), color=LINES[i],
                  linewidth=1.2)  # fmt: skip
        value = study.published.ratios.get(f"speed.first_two_share_{speed:g}", np.nan)
        common = study.published.common_restitution
        axes.plot(common, SHARE.value(value), "x", color=LINES[i], markersize=6.0)
        rest.plot(common, 100.0 * (value - 1.0 + common**2), "x", color=LINES[i], markersize=6.0)
    if study.compared:
        axes.plot([], [], "x", color="0.3", label="published")
    axes.legend(fontsize=SMALL, frameon=False)
    tidy(axes, "restitution e [-]", SHARE.label)
    tidy(rest, "restitution e [-]", "difference from 1 - e²\n[points of %]")
    for panel, text in ((axes, "(a)"), (rest, "(b)")):
        letter(panel, text)
        grid(panel)
    return plate(
        "shares",
        "Share of the first two rebounds",
        "(a) Share of the first two rebounds in the time to rest against the restitution, and "
        "1 - e², what a constant closing force gives. (b) The difference: the closing force "
        "changes during the longer rebounds.",
        figure,
    )


def _designs(study: PaperStudy) -> Plate:
    data, words = study.designs, terms(study)
    speeds = data.speeds_rpm
    places = speeds[0] + np.array(_LABELLED) * (speeds[-1] - speeds[0])
    figure = new_figure(3.2, terms(study).mark)
    panels = figure.subplots(1, len(data.stiffnesses), sharex=True, sharey=True)
    most = float(np.nanmax(data.durations)) * MS_PER_S
    levels = np.arange(0.0, most + 1.0)
    for number, axes in enumerate(panels):
        times = MS_PER_S * data.durations[number]
        filled = axes.contourf(speeds, RESTITUTIONS, times, levels=levels, cmap="YlOrBr",
                               alpha=0.75)  # fmt: skip
        lines = axes.contour(speeds, RESTITUTIONS, times, levels=levels, colors="black",
                             linewidths=0.8)  # fmt: skip
        _label(lines, places[1], speeds)
        index = axes.contour(speeds, RESTITUTIONS, data.index_units[number],
                             levels=[1.0, 2.0, 3.0, 4.0], colors=LINES[0], linewidths=0.9,
                             linestyles="--")  # fmt: skip
        _label(index, places[0], speeds)
        stiffness = words.rate.value(float(data.stiffnesses[number]))
        letter(axes, f"({'abc'[number]})  {stiffness:.3g} {words.rate.unit}")
        tidy(axes, "speed [r/min]", "restitution e [-]" if number == 0 else "")
    _bar(figure, filled, list(panels), TIME.label)
    return plate(
        "designs",
        "Time to rest over speed, restitution and spring rate",
        "Full lines: time to rest in ms. Dashed: the same in units of the index, 40 to a turn, "
        "the part of the cycle in which the jaw does not hold. The preload is kept.",
        figure,
    )


def _bar(figure: Figure, filled: ContourSet, panels: list[Axes], text: str) -> None:
    """Add a colour bar with letters of the size of the other ones."""
    bar = figure.colorbar(filled, ax=panels)
    bar.set_label(text, fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)


def _label(lines: ContourSet, speed_rpm: float, speeds: FloatArray) -> None:
    """Write the value on each line where it comes nearest to a speed, clear of the frame.

    Two sets of lines that are labelled at different speeds do not write over one another.
    """
    places = []
    low, high = (RESTITUTIONS[0] + _MARGIN, RESTITUTIONS[-1] - _MARGIN)
    reach = _AWAY * (speeds[-1] - speeds[0])
    for path in lines.get_paths():
        x, y = np.asarray(path.vertices, dtype=float).reshape(-1, 2).T
        inside = (y > low) & (y < high) & (np.abs(x - speed_rpm) < reach)
        if inside.any():
            nearest = np.argmin(np.where(inside, np.abs(x - speed_rpm), np.inf))
            places.append((float(x[nearest]), float(y[nearest])))
    lines.clabel(fmt="%g", fontsize=SMALL - 1.0, manual=places)
