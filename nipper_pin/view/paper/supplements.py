"""Results of other studies in the report: sensitivities and an identification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...study.conclusions import label
from ...study.paper.designer import Designer
from ...study.sensitivity import QUANTITIES, Sensitivities, Sensitivity
from ...terms import named
from ..style import LINES, SMALL, tidy
from .canvas import Plate, grid, letter, new_figure, plate
from .tables import Column, Table
from .terms import TIME

_SHOWN = 5
_WORDS = ("first rebound amplitude", TIME.words, named("clamping_force_N").words)


@dataclass(frozen=True)
class Supplements:
    """Results of other studies.

    Attributes:
        sensitivities: Sensitivities of the model.
        identification: What ``nipper-pin identify --json`` wrote.
        designer: What a designer wants to know first.
    """

    sensitivities: Sensitivities | None = None
    identification: Mapping[str, Any] | None = None
    designer: Designer | None = None


def sensitivity_plate(found: Sensitivities, mark: str) -> Plate:
    """Draw the numbers of the model that matter most, for each quantity.

    Args:
        found: The sensitivities.
        mark: What the figure says of its numbers.
    """
    figure = new_figure(7.6, mark)
    panels = figure.subplots(len(QUANTITIES), 1)
    for place, (axes, quantity) in enumerate(zip(panels, QUANTITIES, strict=True)):
        ranked = found.ranked(quantity)
        # Percent and millimetres are grouped apart, since their bars differ in length.
        sized = [row for row in ranked if row.unit != "%"][:_SHOWN]
        relative = [row for row in ranked if row.unit == "%"][:_SHOWN]
        rows = [*sized, *relative][::-1]
        values = [row.per[place] for row in rows]
        bars = axes.barh(range(len(rows)), values,
                         color=[LINES[0] if v > 0 else LINES[1] for v in values])  # fmt: skip
        axes.bar_label(bars, [_change(value) for value in values], fontsize=SMALL - 1.0, padding=2)
        axes.margins(x=0.12)
        axes.set_yticks(range(len(rows)), [f"{label(r.path)} [{r.unit}]" for r in rows])
        axes.axvline(0.0, color="black", linewidth=0.8)
        axes.axhline(len(relative) - 0.5, color="0.5", linewidth=0.8, linestyle=":")
        letter(axes, f"({'abc'[place]})")
        grid(axes)
        tidy(axes, f"change of the {_WORDS[place]} [%]", "")
        axes.tick_params(axis="y", labelsize=SMALL - 1.0)
    return plate(
        "sensitivities",
        "What changes bounce, time and clamping most",
        f"Relative change of (a) the first rebound amplitude, (b) the time to rest and (c) the "
        f"mean clamping force for one unit more of a number of the model, at "
        f"{found.speed_rpm:g} r/min: above the dotted line 1 mm of a length or 1 degree of an "
        "angle (of a number that is zero the amount in its brackets), below it 1 % of all others; "
        "the strongest of each kind.",
        figure,
    )


def sensitivity_table(found: Sensitivities) -> Table:
    """All sensitivities, by their effect on the first amplitude."""
    return Table(
        "sensitivities",
        "Sensitivities to every number of the model",
        (
            Column("path", "number", label),
            Column("value", "value", of_row=lambda row: named(row[0]).phrase(row[1])),
            Column("unit", "one"),
            Column("rebound_amplitude_1_percent", "A<sub>1</sub> [%]", _change),
            Column("duration_percent", f"{TIME.words} [%]", _change),
            Column("clamping_force_percent", "clamping force [%]", _change),
            Column("disagreement_percent", "two ways differ by", lambda v: f"{v:.0e}"),
        ),
        tuple(_row(item) for item in found.ranked(QUANTITIES[0])),
    )


def _row(item: Sensitivity) -> tuple[Any, ...]:
    return (item.path, item.value, item.unit, *item.per.tolist(), item.disagreement)


def _change(value: float) -> str:
    return "0" if np.abs(value) < 5e-5 else f"{value:+.2g}"
