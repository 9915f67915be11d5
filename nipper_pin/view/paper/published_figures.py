"""Figures 11 to 14 of the published study, or the same of another machine."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ...arrays import FloatArray
from ...hybrid.result.quantities import force_unit
from ...study.paper import PaperStudy
from ...study.paper.counts import counted
from ...study.paper.studies import Study
from ...units import MS_PER_S
from ..naming import coordinate_shown
from ..run.sampling import sample_coordinates
from ..style import LINES, MARKERS, SMALL, tidy
from .canvas import Plate, grid, letter, new_figure, plate
from .terms import TIME, terms

# Thresholds at which collisions are counted in figures and tables [rad/s].
THRESHOLDS = (0.001, 0.02, 0.06)


def published_plates(study: PaperStudy) -> list[Plate]:
    """Draw figures 11, 12, 13 and 14."""
    return [_angle(study), _impulses(study), _restitution(study), _stiffness(study)]


def _angle(study: PaperStudy) -> Plate:
    figure = new_figure(5.4, terms(study).mark)
    panels = figure.subplots(len(study.motions), 1, sharex=True, sharey=True)
    jaw = study.mechanism.stop(study.mechanism.transition_stop)
    angle, noun = terms(study).rebound, coordinate_shown(study.mechanism, jaw.index).words
    gap = f"jaw {noun} [{angle.unit}]"
    durations = MS_PER_S * study.studies.speed.durations
    for number, (axes, solution) in enumerate(zip(panels, study.motions, strict=True)):
        t, q = sample_coordinates(solution, *solution.trajectory.span)
        axes.plot(MS_PER_S * t, angle.value(q[:, jaw.index]), color=LINES[0], linewidth=1.3)
        at = [MS_PER_S * item.t for item in solution.collisions]
        axes.plot(at, np.zeros(len(at)), "|", color="black", markersize=8.0)
        axes.plot(durations[number], 0.0, "s", color="black", markersize=3.5)
        _close_up(axes, MS_PER_S * t, angle.value(q[:, jaw.index]), at, angle.unit)
        letter(axes, f"({'abc'[number]})  {solution.case.speed_rpm:g} r/min")
        grid(axes)
        tidy(axes, "", gap)
    tidy(panels[-1], "time from the first collision [ms]", gap)
    shown = ", ".join(f"{value:.3f}" for value in durations)
    return plate(
        "figure_11",
        "Jaw angle during the transition",
        "Jaw angle against time from the first collision at three speeds"
        f"{terms(study).of_paper('figure 11')}. "
        "Strokes mark collisions, the square the time of rest as the limit of the series: "
        f"{shown} ms. Insets: from the second collision on.",
        figure,
    )


def _close_up(axes: Axes, t: FloatArray, angle: FloatArray, at: list[float], unit: str) -> None:
    """Show the second rebound and what follows, which are small beside the first.

    Args:
        axes: The panel.
        t: Times, shape (K,) [ms].
        angle: Jaw angles, shape (K,), in ``unit``.
        at: Times of the collisions [ms].
        unit: That of the angles.
    """
    inner = axes.inset_axes((0.855, 0.42, 0.14, 0.52))
    later = t >= at[1]
    inner.plot(t[later], angle[later], color=LINES[0], linewidth=1.1)
    inner.plot(at[1:], np.zeros(len(at) - 1), "|", color="black", markersize=5.0)
    inner.tick_params(labelsize=SMALL - 1.5)
    inner.xaxis.set_major_locator(MaxNLocator(2))
    inner.yaxis.set_major_locator(MaxNLocator(3))
    inner.set_ylabel(f"[{unit}]", fontsize=SMALL - 1.5)
    grid(inner)


def _impulses(study: PaperStudy) -> Plate:
    figure = new_figure(3.2, terms(study).mark)
    linear, log = figure.subplots(1, 2)
    table, mechanism = study.studies.speed.bounces, study.mechanism
    unit = f"{force_unit(mechanism, mechanism.stop(mechanism.transition_stop))} s"
    for i, speed in enumerate(study.studies.speed.values):
        impulse = table.impulse[i][np.isfinite(table.impulse[i])][:8]
        number = np.arange(1, len(impulse) + 1)
        style = {"color": LINES[i], "marker": MARKERS[i], "markersize": 4.0, "linewidth": 1.0}
        for axes in (linear, log):
            axes.plot(number, impulse, label=f"{speed:g} r/min", **style)
    log.set_yscale("log")
    for axes, text in ((linear, "(a)"), (log, "(b)  logarithmic")):
        letter(axes, text)
        grid(axes)
        tidy(axes, "number of the collision", f"impulse [{unit}]")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    linear.legend(fontsize=SMALL, frameon=False)
    first = ", ".join(f"{value:.3f}" for value in table.impulse[:, 0])
    seconds = table.impulse[:, 1] / table.impulse[:, 0]
    low, high = float(seconds.min()), float(seconds.max())
    return plate(
        "figure_12",
        "Impulse of each collision",
        "Normal impulse at the lips in each collision, one series a speed"
        f"{terms(study).of_paper('figure 12')}. The first impulses, {first} {unit}, are "
        "proportional to the speed, because with held shafts nothing but the approach rate sets "
        f"them. The second is {low:.3f} to {high:.3f} of the first; what it lacks to "
        f"e = {study.published.common_restitution:g} is the change of the closing force during the "
        "long first rebound. Later rebounds are short, and impulses fall by nearly e.",
        figure,
    )


def _restitution(study: PaperStudy) -> Plate:
    data = study.studies.restitution
    figure = new_figure(3.2, terms(study).mark)
    time, number = figure.subplots(1, 2)
    time.plot(data.values, MS_PER_S * data.durations, color=LINES[0], marker="o", markersize=4.0,
              linewidth=1.2, label="ours")  # fmt: skip
    cross = ""
    if study.compared:
        published = 1.0 + study.published.ratios["restitution.transition_time_increase"]
        time.plot(data.values[-1], MS_PER_S * data.durations[0] * published, "x", color="black",
                  label="published ratio")  # fmt: skip
        cross = (
            "Cross: the published ratio applied to our value at the smallest restitution. The "
            "number depends on the separation rate at which one stops to count, which is not "
            "published."
        )
    time.legend(fontsize=SMALL, frameon=False)
    letter(time, "(a)")
    grid(time)
    tidy(time, "restitution e [-]", TIME.label)
    _draw_counts(number, data)
    tidy(number, "restitution e [-]", "collisions")
    for axes in (time, number):
        axes.set_xticks(data.values)
    speed = study.published.common_speed_rpm
    return plate(
        "figure_13",
        "Transition over the restitution",
        f"(a) Time to rest and (b) number of collisions against the restitution at {speed:g} "
        f"r/min{terms(study).of_paper('figure 13')}. {cross}",
        figure,
    )


def _stiffness(study: PaperStudy) -> Plate:
    data = study.studies.stiffness
    figure = new_figure(3.2, terms(study).mark)
    time, number = figure.subplots(1, 2)
    words = terms(study)
    rates = words.rate.value(data.values)
    series = (
        (TIME.words, data.durations, None),
        ("first rebound", data.times[:, 0], "stiffness.first_rebound_time_change"),
        ("second rebound", data.times[:, 1], "stiffness.second_rebound_time_change"),
    )
    for i, (label, values, ratio) in enumerate(series):
        time.plot(rates, MS_PER_S * values, color=LINES[i], marker=MARKERS[i], markersize=4.0,
                  linewidth=1.2, label=label)  # fmt: skip
        if ratio is not None and study.compared:
            change = 1.0 + study.published.ratios[ratio]
            time.plot(rates[-1], MS_PER_S * values[0] * change, "x", color="black", zorder=5,
                      label="published ratio" if i == 1 else None)  # fmt: skip
    time.set_ylim(0.0, 1.25e3 * float(data.durations.max()))
    time.legend(fontsize=SMALL, frameon=False, ncols=2)
    letter(time, "(a)")
    grid(time)
    tidy(time, words.rate.label, "time [ms]")
    _draw_counts(number, data, words.rate.factor)
    tidy(number, words.rate.label, "collisions")
    for axes in (time, number):
        axes.set_xticks(rates)
    speed = study.published.common_speed_rpm
    crosses = "Crosses: published ratios applied to our value at the smallest rate."
    return plate(
        "figure_14",
        "Transition over the spring rate",
        f"(a) Times and (b) number of collisions against the spring rate at {speed:g} r/min, the "
        f"preload kept{words.of_paper('figure 14')}. {crosses if words.compared else ''}",
        figure,
    )


def _draw_counts(panel: Axes, data: Study, factor: float = 1.0) -> None:
    numbers = counted(data.rates, np.array(THRESHOLDS))
    for i, threshold in enumerate(THRESHOLDS):
        panel.plot(factor * data.values, numbers[i], color=LINES[i], marker=MARKERS[i],
                   markersize=4.0, linewidth=1.0, linestyle="--",
                   label=f"threshold {threshold:g} rad/s")  # fmt: skip
    panel.set_ylim(0.0, 1.45 * numbers.max())
    panel.yaxis.set_major_locator(MaxNLocator(integer=True))
    panel.legend(fontsize=SMALL, frameon=False, loc="upper right")
    letter(panel, "(b)")
    grid(panel)
