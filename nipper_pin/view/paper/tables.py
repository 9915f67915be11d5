"""Tables of the report, each as numbers for a CSV file and as text for people."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...study.paper import PaperStudy
from ...study.paper.counts import counted
from ...study.paper.fixed_step import FixedStep
from ...study.paper.published import published
from ...study.paper.studies import Study
from ...terms import digits
from ...units import M_PER_MM, MS_PER_S, US_PER_S
from .terms import REBOUND_TIME, SHARE, TIME, Terms, terms, unit_text

COUNTED_AT = (1e-4, 1e-3, 0.005, 0.02, 0.05, 0.06, 0.08, 0.1, 0.3, 0.9)
SHOWN_FACTORS = (0.1, 1.0, 10.0)


@dataclass(frozen=True)
class Column:
    """One column.

    Attributes:
        key: Name with the unit, in CSV files.
        heading: The same for people, who may see another unit.
        show: From the number to text.
        of_row: From the whole row to text instead, where the row says what the unit is.
    """

    key: str
    heading: str
    show: Callable[[Any], str] = str
    of_row: Callable[[Sequence[Any]], str] | None = None


@dataclass(frozen=True)
class Table:
    """One table.

    Attributes:
        name: Name of its file.
        title: What it holds.
        columns: Columns.
        rows: Numbers in SI units, one tuple a row.
    """

    name: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]

    @property
    def shown(self) -> list[list[str]]:
        """Rows as text."""
        return [
            [
                column.show(value) if column.of_row is None else column.of_row(row)
                for column, value in zip(self.columns, row, strict=True)
            ]
            for row in self.rows
        ]

    def csv_text(self) -> str:
        """Return the table as CSV, numbers as they are."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([column.key for column in self.columns])
        for row in self.rows:
            writer.writerow([v.item() if isinstance(v, np.generic) else v for v in row])
        return stream.getvalue()


def percent(value: float, decimals: int = 1) -> str:
    """Signed percentage."""
    # Negative round-off is written as zero without a sign.
    return f"{round(100.0 * value, decimals) + 0.0:+.{decimals}f} %"


def _scaled(factor: float) -> Callable[[Any], str]:
    return lambda value: "-" if value is None else digits(factor * float(value))


def _percent_or_none(value: float | None) -> str:
    return "-" if value is None else percent(value, 0)


def _general(value: float) -> str:
    return f"{value:g}"


def _rebounds(words: Terms) -> tuple[Column, ...]:
    """Amplitudes and times of the first two rebounds, and the time to rest."""
    angle = words.rebound
    return (
        Column("rebound_amplitude_1", f"A<sub>1</sub> [{unit_text(angle)}]", angle.text),
        Column("rebound_amplitude_2", f"A<sub>2</sub> [{unit_text(angle)}]", angle.text),
        Column("rebound_time_s_1", f"T<sub>1</sub> [{REBOUND_TIME.unit}]", REBOUND_TIME.text),
        Column("rebound_time_s_2", f"T<sub>2</sub> [{REBOUND_TIME.unit}]", REBOUND_TIME.text),
        Column("duration_s", TIME.label, TIME.text),
    )


def ratio_words(name: str) -> str:
    """A published ratio in words: what changes, and between which two cases.

    Args:
        name: Study and quantity, as in the JSON document.
    """
    study, _, quantity = name.partition(".")
    if quantity.startswith("first_two_share_"):
        return f"share of the first two rebounds, {quantity.rsplit('_', 1)[1]} r/min"
    given = published()
    values, unit = {
        "speed": (given.speeds_rpm, "{:g} to {:g} r/min"),
        "restitution": (given.restitutions, "e = {:g} to {:g}"),
        "stiffness": ([M_PER_MM * rate for rate in given.stiffnesses], "{:g} to {:g} N/mm"),
    }[study]
    what = quantity.rpartition("_")[0].replace("_", " ")
    return f"{what}, {unit.format(values[0], values[-1])}"


_RATIO = (
    Column("name", "ratio", ratio_words),
    Column("published", "published", _general),
    Column("ours", "ours", digits),
    Column("relative_deviation", "deviation", percent),
)


def ratio_table(study: PaperStudy) -> Table:
    """Published ratios beside ours, and beside those of the identified model."""
    title = "Published ratios beside ours"
    rows = [(i.name, i.published, i.ours, i.relative_deviation) for i in study.ratios]
    if not study.identified:
        return Table("ratios", title, _RATIO, tuple(rows))
    columns = (
        *_RATIO,
        Column("identified", "identified", digits),
        Column("identified_deviation", "deviation", percent),
    )
    more = [(i.ours, i.relative_deviation) for i in study.identified]
    return Table("ratios", title, columns, tuple((*a, *b) for a, b in zip(rows, more, strict=True)))


def inertial_ratio_table(study: PaperStudy) -> Table:
    """Published ratios beside ours with inertial shafts."""
    rows = tuple((i.name, i.published, i.ours, i.relative_deviation) for i in study.drives.ratios)
    return Table("ratios_inertial_shafts", "The same with inertial shafts", _RATIO, rows)


def published_tables(study: PaperStudy) -> list[Table]:
    """Tables 3, 4 and 5 of the paper."""
    studies, words = study.studies, terms(study)
    share = Column("first_two_share", SHARE.words, lambda v: f"{100.0 * v:.2f} %")
    stated = Column("published_share", "published", lambda v: f"{100.0 * v:.2f} %")
    rows, last = _rows(studies.speed), [share]
    if study.compared:
        given = study.published.ratios
        shares = [given[f"speed.first_two_share_{value:g}"] for value in studies.speed.values]
        rows = tuple((*row, value) for row, value in zip(rows, shares, strict=True))
        last.append(stated)
    stiffness = Column(f"stiffness_{words.rate_si}", f"k [{words.rate.unit}]",
                       lambda v: f"{words.rate.value(v):.4g}")  # fmt: skip
    return [
        Table("table_3", f"Rebounds over the speed{words.of_paper('table 3')}",
              (Column("speed_rpm", "speed [r/min]", _general), *_rebounds(words), *last),
              rows),
        Table("table_4", f"Rebounds over the restitution{words.of_paper('table 4')}",
              (Column("restitution", "e [-]", _general), *_rebounds(words), share),
              _rows(studies.restitution)),
        Table("table_5", f"Rebounds over the spring rate{words.of_paper('table 5')}",
              (stiffness, *_rebounds(words), share), _rows(studies.stiffness)),
    ]  # fmt: skip


def count_table(study: PaperStudy) -> Table:
    """Collisions by threshold and restitution."""
    data = study.studies.restitution
    counts = counted(data.rates, np.array(COUNTED_AT))
    stiff = counted(study.studies.stiffness.rates, np.array(COUNTED_AT))
    columns = [Column("threshold_rad_s", "threshold [rad/s]", _general)]
    columns += [Column(f"collisions_e_{value:g}", f"e = {value:g}") for value in data.values]
    columns += [
        Column("increase", "increase", lambda v: percent(v, 0)),
        Column("rebounds_increase", "of the rebounds", _percent_or_none),
        Column("stiffness_from", "over k, least"),
        Column("stiffness_to", "most"),
    ]
    rows = []
    for threshold, row, other in zip(COUNTED_AT, counts, stiff, strict=True):
        bounces = row - 1
        growth = float(bounces[-1] / bounces[0] - 1.0) if bounces[0] else None
        ends = (int(other.min()), int(other.max()))
        rows.append((threshold, *row.tolist(), float(row[-1] / row[0] - 1.0), growth, *ends))
    return Table("collision_counts", "Number of collisions over the threshold", tuple(columns),
                 tuple(rows))  # fmt: skip


def rest_table(study: PaperStudy) -> Table:
    """Times to rest by a threshold beside the limit, at the common speed and restitution."""
    given = study.published
    speeds = study.studies.speed
    case = given.speeds_rpm.index(given.common_speed_rpm)
    limit = float(speeds.durations[case])
    rows = []
    for threshold in COUNTED_AT:
        number = int(counted(speeds.rates[case : case + 1], np.array([threshold]))[0, 0])
        end = float(speeds.bounces.time[case, number - 1])
        rows.append((threshold, number, end, limit - end, 1.0 - end / limit))
    return Table(
        "rest_time",
        f"Time to rest by a threshold, {given.common_speed_rpm:g} r/min, "
        f"e = {given.common_restitution:g}",
        (
            Column("threshold_rad_s", "threshold [rad/s]", _general),
            Column("collisions", "collisions"),
            Column("time_s", "time [ms]", _scaled(MS_PER_S)),
            Column("missing_s", "missing to the limit [µs]", _scaled(US_PER_S)),
            Column("missing_share", "of the limit", lambda v: f"{100.0 * v:.2g} %"),
        ),
        tuple(rows),
    )


def drive_table(study: PaperStudy) -> Table:
    """Effects of inertial shafts, for some inertias."""
    shown = [item for item in study.drives.effects if item.factor in SHOWN_FACTORS]
    change = lambda v: percent(v, 3)  # noqa: E731
    return Table(
        "drives",
        "Inertial shafts: change against held ones",
        (
            Column("speed_rpm", "speed [r/min]", _general),
            Column("inertia_factor", "inertia factor", _general),
            Column("first_impulse_change", "first impulse", lambda v: percent(v, 4)),
            Column("rebound_amplitude_1_change", "A<sub>1</sub>", change),
            Column("rebound_amplitude_2_change", "A<sub>2</sub>", change),
            Column("duration_change", TIME.words, change),
            Column("shaft_rate_jump", "shaft's rate jumps by", lambda v: f"{100.0 * v:.4f} %"),
        ),
        tuple((i.speed_rpm, i.factor, i.first_impulse, i.first_amplitude, i.second_amplitude,
               i.transition_time, i.shaft_jump) for i in shown),
    )  # fmt: skip


def stop_table(study: PaperStudy) -> Table:
    """Releases of the stop that is closed in phase 1, by speed."""
    stop, words = study.phase_one, terms(study)
    lift = words.lift
    return Table(
        "stop_in_phase_1",
        f"The stop of the {stop.stop} in phase 1, simulated turns",
        (
            Column("speed_rpm", "speed [r/min]", _general),
            Column("smallest_force_N", "smallest force [N]", digits),
            Column("release_index", "lets go at index",
                   lambda v: "stays closed" if v is None else f"{v:.3f}"),
            Column(f"lift_{words.stroke_si}", f"lift [{unit_text(lift)}]",
                   lambda v: "-" if v == 0.0 else lift.text(v)),
            Column("duration_s", "for [ms]", lambda v: "-" if v == 0.0 else digits(MS_PER_S * v)),
        ),
        tuple((i.speed_rpm, float(stop.force(stop.preload, i.speed_rpm).min()), i.index,
               i.lift, i.duration_s) for i in stop.releases),
    )  # fmt: skip


def step_table(data: FixedStep) -> Table:
    """Errors of the fixed-step scheme."""
    error = lambda v: f"{v:+.1e}"  # noqa: E731
    return Table(
        "fixed_step",
        "Relative errors of fixed steps",
        (
            Column("rule", "rule"),
            Column("step_s", "step [µs]", _scaled(US_PER_S)),
            Column("first_time_error", "T<sub>1</sub>", error),
            Column("second_time_error", "T<sub>2</sub>", error),
            Column("rebound_amplitude_1_error", "A<sub>1</sub>", error),
            Column("duration_error", TIME.words, error),
        ),
        tuple((rule.name, float(step), *errors.tolist())
              for rule in data.rules
              for step, errors in zip(rule.steps_s, rule.errors, strict=True)),
    )  # fmt: skip


def force_table(study: PaperStudy) -> Table:
    """Published ratios beside those of a constant closing force."""
    constant = study.shares.ballistic_ratios
    return Table(
        "constant_force",
        "What a constant closing force alone would give",
        (
            Column("name", "ratio", ratio_words),
            Column("constant_force", "constant force", digits),
            Column("ours", "ours", digits),
            Column("published", "published", _general),
        ),
        tuple((i.name, constant[i.name], i.ours, i.published)
              for i in study.ratios if i.name in constant),
    )  # fmt: skip


def _rows(data: Study) -> tuple[tuple[Any, ...], ...]:
    return tuple(
        (float(value), *data.amplitudes[i].tolist(), *data.times[i].tolist(),
         float(data.durations[i]), float(data.shares[i]))
        for i, value in enumerate(data.values)
    )  # fmt: skip
