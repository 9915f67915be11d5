"""Figures of phases 1 and 2 over a turn: the oscillating guide, the links, jaw and steeve."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...arrays import FloatArray
from ...mechanism import INDEX_PER_TURN
from ...mechanism.drives import OscillatingGuide
from ...study.paper import PaperStudy
from ...units import DEG_PER_RAD
from ..phases import phase_tint
from ..style import LINES, SMALL, TEXT, tidy
from .canvas import Plate, grid, letter, new_figure, plate
from .terms import Terms, terms

_DASHES = ("-", "--", ":", "-.")


def kinematic_plates(study: PaperStudy) -> list[Plate]:
    """Draw the guide, if there is one, the links, and the coordinates of both stops."""
    guided = isinstance(study.mechanism.drives[0].law, OscillatingGuide)
    return [*([_guide(study)] if guided else []), _links(study), _stops(study)]


def _guide(study: PaperStudy) -> Plate:
    turn = study.kinematics
    figure = new_figure(5.8, terms(study).mark)
    panels = figure.subplots(3, 1, sharex=True)
    order, index = _order(study)
    drive = study.mechanism.drives[0].name
    for i, guide in enumerate(turn.guides):
        rows = (DEG_PER_RAD * guide.angle, guide.rate, guide.acceleration)
        for axes, values in zip(panels, rows, strict=True):
            axes.plot(index, values[order, 0], color=LINES[i], linestyle=_DASHES[i], linewidth=1.3,
                      label=f"{guide.speed_rpm:g} r/min")  # fmt: skip
    names = ("angle [deg]", "rate [rad/s]", "acceleration [rad/s²]")
    for number, (axes, name) in enumerate(zip(panels, names, strict=True)):
        _phases(study, axes)
        letter(axes, f"({'abc'[number]})")
        grid(axes)
        tidy(axes, "", f"{drive}\n{name}")
    panels[1].legend(fontsize=SMALL, frameon=False, ncols=3)
    tidy(panels[-1], "index of the comb cycle (40 to a turn)", f"{drive}\n{names[-1]}")
    swing = DEG_PER_RAD * float(np.ptp(turn.guides[0].angle[:, 0]))
    peak = float(np.abs(turn.guides[-1].acceleration[:, 0]).max())
    return plate(
        "guide",
        "Oscillating guide over a turn",
        f"Angle, rate and acceleration of the {drive} shaft, driven by the oscillating guide. It "
        f"swings by {swing:.2f} degrees whatever the speed; at "
        f"{turn.guides[-1].speed_rpm:g} r/min its acceleration reaches {peak:.0f} rad/s². "
        "Shaded: jaw closed.",
        figure,
    )


def _links(study: PaperStudy) -> Plate:
    turn = study.kinematics
    figure = new_figure(6.8, terms(study).mark)
    panels = figure.subplots(3, 1, sharex=True)
    order, index = _order(study)
    rows = (DEG_PER_RAD * turn.link_angles, turn.link_rates, turn.link_accelerations)
    names = ("rotation [deg]", "angular rate\n[rad/s]", "angular acceleration\n[rad/s²]")
    for number, (axes, values, name) in enumerate(zip(panels, rows, names, strict=True)):
        for i, link in enumerate(study.mechanism.links):
            shown = values[order, i]
            axes.plot(index, shown if number == 0 else _broken(turn.is_open[order], shown),
                      color=LINES[i % len(LINES)], linestyle=_DASHES[i // len(LINES)],
                      linewidth=1.2, label=link.replace("_", " "))  # fmt: skip
        _phases(study, axes)
        letter(axes, f"({'abc'[number]})")
        grid(axes)
        tidy(axes, "", name)
    panels[-1].set_xlabel("index of the comb cycle (40 to a turn)", fontsize=TEXT)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=4,
                  fontsize=SMALL, frameon=False)  # fmt: skip
    return plate(
        "links",
        "Motion of the links over a turn",
        "(a) Rotation of every link from the touch configuration, counter-clockwise in the side "
        f"view, (b) its angular rate and (c) its angular acceleration at {turn.speed_rpm:g} r/min, "
        "through phases 1 and 2. Positions do not depend on the speed, rates are proportional to "
        "it and accelerations to its square. Shaded: jaw closed. Links that a closed stop or a "
        "slide holds together turn together.",
        figure,
    )


def _stops(study: PaperStudy) -> Plate:
    turn = study.kinematics
    figure = new_figure(6.0, terms(study).mark)
    panels = figure.subplots(3, 2, sharex=True)
    order, index = _order(study)
    words = terms(study)
    columns = (("jaw angle", "deg", "rad/s", "rad/s²", DEG_PER_RAD, 1.0, turn.stop_jaw),
               (*_other_stop(words), turn.stop_steeve))  # fmt: skip
    for column, (name, unit, rate, acceleration, factor, other, place) in enumerate(columns):
        rows = (("q", unit, factor), ("v", rate, other), ("a", acceleration, other))
        for row, (quantity, text, scale) in enumerate(rows):
            axes = panels[row, column]
            values = scale * turn.of_phases(quantity, place)[order]
            if quantity != "q":
                values = _broken(turn.is_open[order], values)
            axes.plot(index, values, color=LINES[column], linewidth=1.3)
            _phases(study, axes)
            grid(axes)
            letter(axes, f"({'abcdef'[2 * row + column]})")
            kind = ("", "rate of ", "acceleration of ")[row]
            tidy(axes, "", f"{kind}{name}\n[{text}]")
    for axes in panels[-1]:
        axes.set_xlabel("index (40 to a turn)", fontsize=SMALL)
    return plate(
        "both_stops",
        f"Jaw and {words.stop} over a turn",
        f"Phases 1 and 2 at {turn.speed_rpm:g} r/min as kinematics, without bounces: the jaw "
        f"closes at index {turn.closing_index:.2f} and would open at {turn.opening_index:.2f}; it "
        f"opens to {DEG_PER_RAD * turn.largest_jaw_angle:.1f} degrees, and the {words.stop} moves "
        f"by {words.stroke.value(turn.largest_stroke):.2f} {words.stroke.unit} "
        "from its stop. At the change of phase the rates jump: that jump is the impact.",
        figure,
    )


def _other_stop(words: Terms) -> tuple[str, str, str, str, float, float]:
    """Name, units and factors of the coordinate of the stop that is closed with the jaw open."""
    unit, factor = words.stroke.unit, words.stroke.factor
    if words.stroke_si == "rad":
        return f"{words.stop} angle", unit, "rad/s", "rad/s²", factor, 1.0
    return "stroke s", unit, "m/s", "m/s²", factor, 1.0


def _order(study: PaperStudy) -> tuple[np.ndarray, FloatArray]:
    """Order of the places by their index in one turn from 0, and that index."""
    index = study.kinematics.index[:-1] % INDEX_PER_TURN
    order = np.argsort(index)
    return order, index[order]


def _broken(is_open: np.ndarray, values: FloatArray) -> FloatArray:
    """Values with a gap where the phase changes, so that no line is drawn through a jump."""
    shown = values.copy()
    shown[1:][np.diff(is_open.astype(int)) != 0] = np.nan
    return shown


def _phases(study: PaperStudy, axes: Axes) -> None:
    """Shade where the jaw is closed."""
    turn = study.kinematics
    tint = phase_tint(study.mechanism, frozenset({study.mechanism.transition_stop}))
    for begin, end in ((0.0, turn.opening_index), (turn.closing_index, INDEX_PER_TURN)):
        axes.axvspan(begin, end, facecolor=tint, alpha=0.45, linewidth=0, zorder=0)
    axes.set_xlim(0.0, INDEX_PER_TURN)
