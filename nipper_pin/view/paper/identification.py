"""Results of an identification as a figure and tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...study.conclusions import label
from ...terms import digits, named
from ..style import LINES, MARKERS, SMALL, tidy
from .canvas import Plate, grid, letter, new_figure, plate
from .tables import Column, Table, percent


def identification_plate(document: Mapping[str, Any], mark: str) -> Plate:
    """Draw singular values, and how the misfit rises with single numbers.

    Args:
        document: What ``nipper-pin identify --json`` wrote.
        mark: What the figure says of its numbers.
    """
    figure = new_figure(3.6, mark)
    values, profiles = figure.subplots(1, 2)
    singular = np.array(document["singular_values"])
    place = np.arange(1, len(singular) + 1)
    known = document["identifiable_directions"]
    values.semilogy(place, singular, color="0.7", linewidth=0.8)
    for part, colour, words in (
        (place <= known, LINES[0], "narrowed to less than half"),
        (place > known, LINES[1], "left open"),
    ):
        values.semilogy(place[part], singular[part], "o", color=colour, markersize=4.0, label=words)
    values.legend(fontsize=SMALL, frameon=False)
    tidy(values, "direction", "singular value\n[sigmas over the range]")
    best = {item["path"]: item["identified"] for item in document["parameters"]}
    for i, item in enumerate(document["profiles"]):
        away = (np.array(item["values"]) - best[item["path"]]) / item["sigma"]
        style = {"color": LINES[i % len(LINES)], "linewidth": 1.1}
        profiles.plot(away, item["cost"], marker=MARKERS[i % len(MARKERS)],
                      markersize=4.0, label=label(item["path"]), **style)  # fmt: skip
        profiles.plot(away, item["quadratic"], linestyle=":", **style)
    profiles.axhline(0.5, color="0.5", linewidth=0.8)
    profiles.set_ylim(-0.2, 4.0)
    if document["profiles"]:
        profiles.legend(fontsize=SMALL, frameon=False)
    tidy(
        profiles,
        "distance of the number from its fit\n[its standard deviation]",
        "rise of half the sum\nof squares [-]",
    )
    for axes, text in ((values, "(a)"), (profiles, "(b)")):
        letter(axes, text)
        grid(axes)
    return plate(
        "identification",
        "What the targets determine",
        "(a) Singular values of the targets' derivatives by the free numbers: how many of their "
        "sigmas the targets change by along each direction, over the whole range. (b) Profile "
        "likelihood: the least misfit while one number is held and all others are fitted again; "
        "dotted, the linear model, by whose standard deviation the distance is measured; the grey "
        "line is one of them. A bound may cut a profile short.",
        figure,
    )


def identification_tables(document: Mapping[str, Any]) -> list[Table]:
    """Targets that were met, and what became of the free numbers."""
    return [
        Table(
            "identification_targets",
            "Targets of the identification",
            (
                Column("name", "target"),
                Column("wanted", "wanted", digits),
                Column("sigma", "±", digits),
                Column("found", "found", digits),
                Column("relative_deviation", "deviation", _percent),
                Column("residual_sigmas", "deviation [sigma]", lambda v: f"{v:+.2f}"),
                Column("outlier", "outlier", lambda v: "yes" if v else ""),
            ),
            tuple(
                (item["name"], item["wanted"], item["sigma"], item["found"],
                 item["relative_deviation"], item["residual_sigmas"], item["outlier"])
                for item in document["targets"]
            ),
        ),
        Table(
            "identified_numbers",
            "Numbers that were identified",
            (
                Column("path", "number", _with_unit),
                _of_parameter("before", "before", 1),
                _of_parameter("identified", "identified", 2),
                _of_parameter("standard_deviation", "±", 3),
                _of_parameter("standard_deviation_scaled", "± scaled", 4),
                _of_parameter("low", "from", 5),
                _of_parameter("high", "to", 6),
                Column("range_left", "range left", lambda v: f"{100.0 * v:.0f} %"),
                Column("determined", "determined", lambda v: "yes" if v else "no"),
            ),
            tuple(
                (item["path"], item["before"], item["identified"], item["standard_deviation"],
                 item["standard_deviation_scaled"], item["low"], item["high"], item["range_left"],
                 item["determined"])
                for item in document["parameters"]
            ),
        ),
    ]  # fmt: skip


def _percent(value: float | None) -> str:
    return "-" if value is None else percent(value)


def _with_unit(path: str) -> str:
    unit = named(path).unit
    return f"{label(path)} [{unit}]" if unit else label(path)


def _of_parameter(key: str, heading: str, place: int) -> Column:
    """A value of a parameter, whose path stands first in the row."""
    return Column(key, heading, of_row=lambda row: named(row[0]).text(row[place]))
