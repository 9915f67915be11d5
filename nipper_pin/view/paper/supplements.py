"""What other studies add to the report: sensitivities, and the outcome of an identification."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...study.sensitivity import QUANTITIES, Sensitivities, Sensitivity, label
from ..reading import digits
from ..style import LINES, SMALL, tidy
from .canvas import Plate, grid, letter, new_figure
from .tables import Column, Table, percent

_SHOWN = 8
_WORDS = ("first amplitude", "transition time", "clamping force")
_KEYS = {"title", "model", "caution", "seed", "targets", "free", "within_4_percent"}
_TARGET_KEYS = {"name", "wanted", "found", "relative_deviation"}
_FREE_KEYS = {"path", "low", "high", "before", "identified", "range_left", "determined"}


@dataclass(frozen=True)
class Supplements:
    """Results of other studies.

    Attributes:
        sensitivities: Sensitivities of the model.
        identification: What ``nipper-pin identify --json`` wrote.
    """

    sensitivities: Sensitivities | None = None
    identification: Mapping[str, Any] | None = None


def read_identification(path: str | Path) -> dict[str, Any]:
    """Read what ``nipper-pin identify --json FILE`` wrote.

    Args:
        path: The file.

    Raises:
        InputError: It cannot be read, or is not such a document.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        message = (
            f"{path}: cannot be read as JSON ({error}); write it by nipper-pin identify --json"
        )
        raise InputError(message, file=str(path)) from error
    right = isinstance(document, dict) and document.keys() >= _KEYS
    for key, needed in (("targets", _TARGET_KEYS), ("free", _FREE_KEYS)):
        rows = document[key] if right else None
        right = isinstance(rows, list) and all(
            isinstance(row, dict) and row.keys() >= needed for row in rows
        )
    if not right:
        message = f"{path}: is no identification; write it by nipper-pin identify --json"
        raise InputError(message, file=str(path))
    return dict(document)


def sensitivity_plate(found: Sensitivities) -> Plate:
    """Draw the numbers of the model that matter most, for each quantity."""
    figure = new_figure(6.6)
    panels = figure.subplots(len(QUANTITIES), 1)
    for place, (axes, quantity) in enumerate(zip(panels, QUANTITIES, strict=True)):
        rows = found.ranked(quantity)[:_SHOWN][::-1]
        values = [row.per[place] for row in rows]
        axes.barh(range(len(rows)), values, color=[LINES[0] if v > 0 else LINES[1] for v in values])
        axes.set_yticks(range(len(rows)), [f"{label(r.path)} [{r.unit}]" for r in rows])
        axes.axvline(0.0, color="black", linewidth=0.8)
        letter(axes, f"({'abc'[place]})")
        grid(axes)
        tidy(axes, f"change of the {_WORDS[place]} [%]", "")
        axes.tick_params(axis="y", labelsize=SMALL - 1.0)
    return Plate(
        "sensitivities",
        "What changes bounce, time and clamping most",
        f"Relative change of (a) the first rebound amplitude, (b) the transition time and (c) the "
        f"mean clamping force for one unit more of a number of the model, at "
        f"{found.speed_rpm:g} r/min: 1 mm of a length, 1 degree of an angle, 1 % of all others.",
        figure,
    )


def sensitivity_table(found: Sensitivities) -> Table:
    """All sensitivities, by their effect on the first amplitude."""
    return Table(
        "sensitivities",
        "Sensitivities to every number of the model",
        (
            Column("path", "number"),
            Column("value", "value", digits),
            Column("unit", "one"),
            Column("first_amplitude_percent", "A<sub>1</sub> [%]", _change),
            Column("transition_time_percent", "transition [%]", _change),
            Column("clamping_force_percent", "clamping [%]", _change),
            Column("disagreement_percent", "two ways differ by", lambda v: f"{v:.0e}"),
        ),
        tuple(_row(item) for item in found.ranked(QUANTITIES[0])),
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
                Column("found", "found", digits),
                Column("relative_deviation", "deviation", percent),
            ),
            tuple(
                (item["name"], item["wanted"], item["found"], item["relative_deviation"])
                for item in document["targets"]
            ),
        ),
        Table(
            "identified_numbers",
            "Numbers that were identified",
            (
                Column("path", "number"),
                Column("before", "before", digits),
                Column("identified", "identified", digits),
                Column("low", "from", digits),
                Column("high", "to", digits),
                Column("range_left", "range left", lambda v: f"{100.0 * v:.0f} %"),
                Column("determined", "determined", lambda v: "yes" if v else "no"),
            ),
            tuple(
                (item["path"], item["before"], item["identified"], item["low"], item["high"],
                 item["range_left"], item["determined"])
                for item in document["free"]
            ),
        ),
    ]  # fmt: skip


def _row(item: Sensitivity) -> tuple[Any, ...]:
    return (item.path, item.value, item.unit, *item.per.tolist(), item.disagreement)


def _change(value: float) -> str:
    return "0" if np.abs(value) < 5e-5 else f"{value:+.2g}"
