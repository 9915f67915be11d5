"""Figures 11 to 14 of the published study, and one for each question that it leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid.result.quantities import force_unit
from nipper_pin.units import MS_PER_S
from nipper_pin.view.reading import coordinate_shown, shown
from nipper_pin.view.run.sampling import sample_coordinates
from nipper_pin.view.style import LINES, MARKERS, SMALL, TITLE, WIDTH_IN, tidy

from .counts import counted
from .drives import FACTORS
from .report import spring_unit
from .shares import MAP_RESTITUTIONS
from .studies import Study
from .study import PaperStudy

_E62 = "estimate of the E62 class identified from the published ratios; not the maker's data"
_OTHER = "numbers of the model; those of the package's combers are estimates, no maker's data"
_REST = "time to rest [ms]"
# Thresholds at which collisions are counted in the paper's figures [rad/s].
_THRESHOLDS = (0.001, 0.02, 0.06)


def figures(study: PaperStudy) -> dict[str, Figure]:
    """Draw them all, by their names."""
    drawn = {name: draw(study) for name, draw in _DRAWN.items()}
    return {name: figure for name, figure in drawn.items() if figure is not None}


def _figure_11(study: PaperStudy) -> Figure:
    figure, panels = _panels(study, "Jaw angle during the transition", 5.4, len(study.motions), 1)
    jaw = study.mechanism.stop(study.mechanism.transition_stop).index
    noun = coordinate_shown(study.mechanism, jaw).words
    angle = shown(study.mechanism, "rebound_amplitude")
    ends = MS_PER_S * study.studies.speed.table.duration
    for axes, run, end in zip(panels, study.motions, ends, strict=True):
        t, q = sample_coordinates(run, *run.trajectory.span)
        axes.plot(MS_PER_S * t, angle.value(q[:, jaw]), color=LINES[0], linewidth=1.3,
                  label=f"{run.case.speed_rpm:g} r/min, at rest after {end:.3f} ms")  # fmt: skip
        axes.plot(end, 0.0, "s", color="black", markersize=3.5)
        tidy(axes, "time from the first collision [ms]", f"jaw {noun} [{angle.unit}]")
        axes.legend(fontsize=SMALL, frameon=False)
    return figure


def _figure_12(study: PaperStudy) -> Figure:
    figure, panels = _panels(study, "Impulse of each collision")
    table, mechanism = study.studies.speed.bounces, study.mechanism
    unit = force_unit(mechanism, mechanism.stop(mechanism.transition_stop))
    number = np.arange(1, 1 + min(8, table.impulse.shape[1]))
    series = _by_speed(study, [row[: len(number)] for row in table.impulse])
    for axes in panels:
        _draw(axes, "number of the collision", f"impulse [{unit} s]", number, series, marked=True)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    panels[1].set_yscale("log")
    return figure


def _figure_13(study: PaperStudy) -> Figure:
    data, name = study.studies.restitution, "restitution e [-]"
    figure, (time, number) = _panels(study, "Transition over the restitution")
    _draw(time, name, _REST, data.values, {"ours": MS_PER_S * data.table.duration}, marked=True)
    _cross(time, study, "restitution.transition_time_increase", data.values, data.table.duration)
    _draw_counts(number, name, data, data.values)
    return figure


def _figure_14(study: PaperStudy) -> Figure:
    data, (unit, factor) = study.studies.stiffness, spring_unit(study.mechanism, "stiffness")
    figure, (time, number) = _panels(study, "Transition over the spring rate, the preload kept")
    name, rates = f"spring rate [{unit}]", factor * data.values
    first, second = data.times.T
    series = {"time to rest": data.table.duration, "first rebound": first, "second rebound": second}
    times = {label: MS_PER_S * values for label, values in series.items()}
    _draw(time, name, "time [ms]", rates, times, marked=True)
    _cross(time, study, "stiffness.first_rebound_time_change", rates, first)
    _cross(time, study, "stiffness.second_rebound_time_change", rates, second)
    time.set_ylim(0.0, 1.25e3 * float(data.table.duration.max()))
    _draw_counts(number, name, data, rates)
    return figure


def _thresholds(study: PaperStudy) -> Figure:
    counts, data = study.counts, study.studies.restitution
    figure, (number, time) = _panels(study, "Collisions and time to rest over the threshold")
    series = {f"e = {data.values[i]:g}": counts.restitution[:, i] for i in (0, 2, 4)}
    _draw(number, "threshold [rad/s]", "collisions", counts.thresholds, series)
    for low, high in counts.matches["rebounds_grow_as_published"]:
        number.axvspan(low, high, facecolor="0.85", zorder=0, label="rebounds +300 %")
    _draw(time, "threshold [rad/s]", "increase of the time to rest [-]", counts.thresholds,
          {"stop at the threshold": counts.time_increase})  # fmt: skip
    limit = float(data.table.duration[-1] / data.table.duration[0] - 1.0)
    lines = {"limit of the series": limit}
    if study.compared:
        lines["published"] = study.published.ratios["restitution.transition_time_increase"]
    for i, (label, value) in enumerate(lines.items(), start=1):
        time.axhline(value, color=LINES[i], linestyle="--", linewidth=1.1, label=label)
    for axes in (number, time):
        axes.set_xscale("log")
        axes.legend(fontsize=SMALL, frameon=False)
    return figure


def _drives(study: PaperStudy) -> Figure:
    figure, panels = _panels(study, "Change by inertial shafts beside held ones; dotted: the model")
    names = {"first_amplitude": "first rebound", "transition_time": "time to rest"}
    for axes, (name, text) in zip(panels, names.items(), strict=True):
        sizes = [100.0 * abs(getattr(item, name)) for item in study.drives.effects]
        rows = np.reshape(sizes, (-1, len(FACTORS)))
        _draw(axes, "shaft inertia by that of the model [-]", f"change of the {text} [%]",
              np.array(FACTORS), _by_speed(study, rows), marked=True)  # fmt: skip
        axes.axvline(1.0, color="0.5", linewidth=0.8, linestyle=":")
        axes.set(xscale="log", yscale="log")
    return figure


def _stop_force(study: PaperStudy) -> Figure:
    stop, (unit, factor) = study.phase_one, spring_unit(study.mechanism, "preload")
    figure, (curve, chart) = _panels(study, f"Force on the stop of the {stop.stop} in phase 1", 3.6)
    forces = [stop.force(stop.preload, speed) for speed in study.published.speeds_rpm]
    _draw(curve, "index (40 to a turn)", "stop force with the jaw open [N]", stop.index,
          _by_speed(study, forces))  # fmt: skip
    curve.axhline(0.0, color="black", linewidth=0.8)
    smallest, preloads = stop.smallest_forces(), factor * stop.preloads
    most = np.abs(smallest).max()
    filled = chart.contourf(stop.speeds_rpm, preloads, smallest, levels=12, cmap="RdBu",
                            vmin=-most, vmax=most)  # fmt: skip
    figure.colorbar(filled, ax=chart, label="smallest stop force [N]")
    limit = [stop.threshold_rpm(float(p)) for p in stop.preloads]
    chart.plot(limit, preloads, color="black", linewidth=1.6, label="lets go beyond")
    for item in stop.releases:
        kind = "s" if item.index is None else "X"
        chart.plot(item.speed_rpm, factor * stop.preload, kind, color="black", markersize=6.0)
    chart.set_xlim(stop.speeds_rpm[0], stop.speeds_rpm[-1])
    chart.legend(fontsize=SMALL, loc="lower right")
    tidy(chart, "cylinder speed [r/min]", f"preload [{unit}]")
    return figure


def _fixed_step(study: PaperStudy) -> Figure | None:
    if study.fixed_step is None:
        return None
    figure, panels = _panels(study, "Error of fixed steps: forward, and semi-implicit", 3.6)
    labels = ("first rebound time", "second rebound time", "first amplitude", "time to rest")
    for axes, rule in zip(panels, study.fixed_step.rules, strict=True):
        series = dict(zip(labels, np.abs(rule.relative_errors).T, strict=True))
        _draw(axes, "step [s]", f"relative error, {rule.name}", rule.steps_s, series, marked=True)
        axes.set(xscale="log", yscale="log")
    return figure


def _shares(study: PaperStudy) -> Figure:
    data, given, name = study.shares, study.published, "restitution e [-]"
    figure, panels = _panels(study, "Share of the first two rebounds, and its difference from 1-e²")
    shares = _by_speed(study, 100.0 * data.shares)
    _draw(panels[0], name, "share [%]", data.restitutions, shares)
    panels[0].plot(data.restitutions, 100.0 * data.ballistic, color="black", linestyle="--",
                   label="1 - e²")  # fmt: skip
    off = _by_speed(study, 100.0 * (data.shares - data.ballistic))
    _draw(panels[1], name, "difference [points of %]", data.restitutions, off)
    e = given.common_restitution
    for i, speed in enumerate(data.speeds_rpm):
        value = given.ratios.get(f"speed.first_two_share_{speed:g}", np.nan)
        for axes, y in zip(panels, (value, value - 1.0 + e**2), strict=True):
            axes.plot(e, 100.0 * y, "x", color=LINES[i], markersize=6.0,
                      label="published" if study.compared and i == 0 else None)  # fmt: skip
            axes.legend(fontsize=SMALL, frameon=False)
    return figure


def _designs(study: PaperStudy) -> Figure:
    data, (unit, factor) = study.durations, spring_unit(study.mechanism, "stiffness")
    title = "Time to rest in ms (full lines) and in units of the index (dashed), the preload kept"
    figure, panels = _panels(study, title, 3.2, 1, len(data.stiffnesses))
    times = MS_PER_S * data.durations
    levels = np.arange(0.0, float(np.nanmax(times)) + 1.0)
    grid = (data.speeds_rpm, MAP_RESTITUTIONS)
    for axes, time, index, rate in zip(panels, times, data.index_units, data.stiffnesses,
                                       strict=True):  # fmt: skip
        filled = axes.contourf(*grid, time, levels=levels, cmap="YlOrBr", alpha=0.75)
        full = axes.contour(*grid, time, levels=levels, colors="black", linewidths=0.8)
        dashed = axes.contour(*grid, index, levels=[1.0, 2.0, 3.0, 4.0], colors=LINES[0],
                              linewidths=0.9, linestyles="--")  # fmt: skip
        for lines in (full, dashed):
            lines.clabel(fmt="%g", fontsize=SMALL - 1.0)
        axes.set_title(f"{factor * rate:.3g} {unit}", fontsize=SMALL)
        tidy(axes, "speed [r/min]", "restitution e [-]")
    figure.colorbar(filled, ax=panels, label=_REST)
    return figure


_DRAWN = {
    "figure_11": _figure_11, "figure_12": _figure_12, "figure_13": _figure_13,
    "figure_14": _figure_14, "thresholds": _thresholds, "drives": _drives,
    "stop_force": _stop_force, "fixed_step": _fixed_step, "shares": _shares, "designs": _designs,
}  # fmt: skip
NAMES = tuple(_DRAWN)
"""Names of all figures; those with a number are the paper's."""


def _panels(
    study: PaperStudy, title: str, height_in: float = 3.4, rows: int = 1, columns: int = 2
) -> tuple[Figure, list[Axes]]:
    """An empty figure that says what it shows, and of what kind its numbers are."""
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=TITLE)
    figure.supxlabel(_E62 if study.compared else _OTHER, fontsize=6.0, color="0.45")
    return figure, list(figure.subplots(rows, columns, squeeze=False).flat)


def _draw(
    axes: Axes, name: str, value: str, x: FloatArray, series: Mapping[str, Any], *,
    marked: bool = False,
) -> None:  # fmt: skip
    """Draw lines over one quantity, with their labels."""
    for i, (label, y) in enumerate(series.items()):
        axes.plot(x, y, color=LINES[i], marker=MARKERS[i] if marked else None, markersize=4.0,
                  linewidth=1.2, label=label)  # fmt: skip
    axes.grid(visible=True, which="major", color="0.9", linewidth=0.6)
    axes.legend(fontsize=SMALL, frameon=False)
    tidy(axes, name, value)


def _by_speed(study: PaperStudy, rows: Any) -> dict[str, FloatArray]:
    return dict(zip((f"{n:g} r/min" for n in study.published.speeds_rpm), rows, strict=True))


def _cross(axes: Axes, study: PaperStudy, name: str, x: FloatArray, seconds: FloatArray) -> None:
    """The published ratio applied to our value of the first case."""
    if study.compared:
        last = MS_PER_S * seconds[0] * (1.0 + study.published.ratios[name])
        label = None if "x" in (line.get_marker() for line in axes.lines) else "published ratio"
        axes.plot(x[-1], last, "x", color="black", zorder=5, label=label)
        axes.legend(fontsize=SMALL, frameon=False)


def _draw_counts(axes: Axes, name: str, data: Study, x: FloatArray) -> None:
    numbers = counted(data.rates, np.array(_THRESHOLDS))
    series = {f"threshold {v:g} rad/s": row for v, row in zip(_THRESHOLDS, numbers, strict=True)}
    _draw(axes, name, "collisions", x, series, marked=True)
    axes.set_ylim(0.0, 1.45 * numbers.max())
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
