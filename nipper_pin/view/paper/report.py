"""The study as one self-contained page: figures included, no network and no other files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from importlib.metadata import version
from typing import Any

import numpy as np

from ...study.conclusions import conclusions
from ...study.paper import PaperStudy
from ...study.paper.counts import HIGHEST, LOWEST
from ...study.paper.ratios import within
from ...study.paper.study import FAR, IDENTIFIED, NEAR, note
from ...terms import digits
from ...units import MM_PER_M, MS_PER_S
from ..reading import spring_text
from .canvas import Plate
from .front_page import front_page
from .identification import identification_plate, identification_tables
from .kinematic_figures import kinematic_plates
from .machine_figure import machine_plate
from .outline import by_name, outline
from .published_figures import published_plates
from .question_figures import question_plates
from .supplements import (
    Supplements,
    sensitivity_plate,
    sensitivity_table,
)
from .tables import (
    Table,
    count_table,
    drive_table,
    force_table,
    inertial_ratio_table,
    percent,
    published_tables,
    ratio_table,
    rest_table,
    step_table,
    stop_table,
)
from .terms import terms, unit_text

_TEMPLATE = "report.html.j2"


@dataclass(frozen=True)
class Material:
    """Figures and tables of the report.

    Attributes:
        plates: Figures in the order of their numbers.
        tables: Tables in the order of theirs.
    """

    plates: tuple[Plate, ...]
    tables: tuple[Table, ...]


def study_plates(
    study: PaperStudy, progress: Callable[[int, int], None] | None = None
) -> list[Plate]:
    """Draw the figures of the study itself: the map of the first page, the machine, all others.

    Args:
        study: The study.
        progress: Called with (groups of figures drawn, groups in all).
    """
    groups: list[list[Plate]] = []
    draw = (lambda study: [machine_plate(study)], published_plates, kinematic_plates,
            question_plates)  # fmt: skip
    for group in draw:
        groups.append(group(study))
        if progress is not None:
            progress(len(groups), len(draw))
    machine, published, kinematic, (*questions, chart) = groups
    return [chart, *machine, *published, *kinematic, *questions]


def material(study: PaperStudy, supplements: Supplements, drawn: Sequence[Plate]) -> Material:
    """Fill all tables, and add the figures of other studies to those of this one.

    Args:
        study: The study.
        supplements: Results of other studies.
        drawn: Figures of the study.
    """
    plates = list(drawn)
    tables = [
        *([ratio_table(study)] if study.compared else []),
        *published_tables(study),
        count_table(study),
        rest_table(study),
        drive_table(study),
        *([inertial_ratio_table(study)] if study.compared else []),
        stop_table(study),
        *([] if study.fixed_step is None else [step_table(study.fixed_step)]),
        *([force_table(study)] if study.compared else []),
    ]
    if supplements.sensitivities is not None:
        plates.append(sensitivity_plate(supplements.sensitivities, terms(study).mark))
        tables.append(sensitivity_table(supplements.sensitivities))
    if supplements.identification is not None:
        plates.append(identification_plate(supplements.identification, terms(study).mark))
        tables.extend(identification_tables(supplements.identification))
    return Material(tuple(plates), tuple(tables))


def _subscripts(heading: str) -> str:
    """The heading of a column, escaped but for its subscripts."""
    text = escape(heading)
    for tag in ("sub", "/sub"):
        text = text.replace(f"&lt;{tag}&gt;", f"<{tag}>")
    return text


def _glued(text: str) -> str:
    """Sentences in which no line breaks between a number and its unit."""
    return re.sub(r"(?<=\d) (?=(?:mdeg|µm|ms|mm/s|r/min|N|index)\b|%)", "\u00a0", text)


def report_html(study: PaperStudy, supplements: Supplements, content: Material) -> str:
    """Return the page.

    Args:
        study: The study.
        supplements: Results of other studies.
        content: Their figures and tables.
    """
    # Imported here: drawing a figure does not need templates.
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("nipper_pin.view.paper", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["subscripts"] = _subscripts
    environment.filters["glued"] = _glued
    figure_numbers = numbers([plate.name for plate in content.plates])
    table_numbers = numbers([table.name for table in content.tables])
    plates = {
        plate.name: {"number": figure_numbers[plate.name], "plate": plate, "svg": plate.inline_svg}
        for plate in content.plates
    }
    tables = {
        table.name: {"number": table_numbers[table.name], "table": table}
        for table in content.tables
    }
    template = environment.get_template(_TEMPLATE)
    contents = outline(study, supplements)
    return template.render(
        study=study,
        words=terms(study),
        plates=plates,
        tables=tables,
        note=note(study),
        identified_model=IDENTIFIED,
        near=NEAR,
        far=FAR,
        springs=spring_text(study.mechanism),
        version=version("nipper-pin"),
        facts=_facts(study, supplements),
        contents=contents,
        sections=by_name(contents),
        front=None if supplements.designer is None else front_page(study, supplements.designer),
        unit_text=unit_text,
        digits=digits,
        percent=percent,
        intervals=_intervals,
        conclusions=conclusions(found) if (found := supplements.sensitivities) else (),
        sensitivities=supplements.sensitivities,
        identification=supplements.identification,
    )


def numbers(names: Sequence[str]) -> dict[str, str]:
    """Numbers of figures or tables by name: those of the paper for its own, A1, A2, ... for others.

    Args:
        names: Names in the order in which they appear.
    """
    found: dict[str, str] = {}
    added = 0
    for name in names:
        kind, _, number = name.partition("_")
        if kind in ("figure", "table") and number.isdigit():
            found[name] = number
        else:
            added += 1
            found[name] = f"A{added}"
    return found


def _facts(study: PaperStudy, supplements: Supplements) -> dict[str, Any]:
    """Numbers of the text that are in no table."""
    studies, given = study.studies, study.published
    common = given.speeds_rpm.index(given.common_speed_rpm)
    worst = max(study.ratios, key=lambda item: abs(item.relative_deviation), default=None)
    own = [item for item in study.drives.effects if item.factor == 1.0]
    rules = () if study.fixed_step is None else study.fixed_step.rules
    threshold = study.phase_one.threshold_rpm(study.phase_one.preload)
    released = [item for item in study.phase_one.releases if item.index is not None]
    found = supplements.sensitivities
    low, high = given.restitutions[0], given.restitutions[-1]
    return {
        "worst": worst,
        "identified_near": within(study.identified, NEAR),
        "identified_far": within(study.identified, FAR),
        "thresholds": f"{LOWEST:g} to {HIGHEST:g}",
        "duration_ms": MS_PER_S * float(studies.speed.durations[common]),
        "share": float(studies.speed.shares[common]),
        "limit_increase": math.log(low) / math.log(high) - 1.0,
        "lever_mm": MM_PER_M * study.mechanism.stop(study.mechanism.transition_stop).lever,
        "drive_amplitude": max(abs(item.first_amplitude) for item in own),
        "drive_time": max(abs(item.transition_time) for item in own),
        "drive_ratio": max(
            abs(inertial.ours / held.ours - 1.0)
            for inertial, held in zip(study.drives.ratios, study.ratios, strict=True)
        )
        if study.compared
        else None,
        "threshold_rpm": threshold if math.isfinite(threshold) else None,
        "released": released,
        "without_turn": [(item.name, item.without_turn) for item in studies if item.without_turn],
        "last_errors": {rule.name: float(abs(rule.errors[-1, -1])) for rule in rules},
        "rules": rules,
        "duration_errors": studies.speed.table.duration_error.tolist(),
        "disagreement": None if found is None else max(row.disagreement for row in found.rows),
        "time_range_ms": [
            MS_PER_S * float(np.nanmin(study.designs.durations)),
            MS_PER_S * float(np.nanmax(study.designs.durations)),
        ],
    }


def _intervals(items: Sequence[tuple[float, float]]) -> str:
    """Intervals of thresholds as text."""
    if not items:
        return "none"
    return ", ".join(f"{low:.3g} to {high:.3g}" for low, high in items)
