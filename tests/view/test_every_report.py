"""Every number of the study's tables and figures, of a sweep's figures and a benchmark's tables.

Numbers of the study are compared with runs of the model files, read by :mod:`judge`; figures of
sweeps and tables of benchmarks with made-up numbers that differ in every place.
"""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import replace
from typing import Any, cast
from xml.etree import ElementTree

import numpy as np
import plate_frames
import pyarrow as pa
import pytest
from judge import Judge
from matplotlib.collections import PolyCollection

from benchmarks.run_time.benchmark import Benchmark
from benchmarks.run_time.work_precision import Row, Stated
from benchmarks.views import benchmark_report
from nipper_pin import Case, DriveMode, Mechanism, Window, load, simulate
from nipper_pin.hybrid.event import Event
from nipper_pin.study.paper import PaperStudy
from nipper_pin.study.paper import shares as shares_of
from nipper_pin.study.paper.drives import DriveComparison, DriveEffect, _numbers
from nipper_pin.study.paper.kinematics import kinematics
from nipper_pin.study.paper.published import published
from nipper_pin.study.paper.ratios import Ratio, ratios
from nipper_pin.study.paper.shares import Shares
from nipper_pin.study.paper.studies import run_studies
from nipper_pin.study.sensitivity import QUANTITIES, Sensitivities, Sensitivity
from nipper_pin.study.sweep import SweepTable
from nipper_pin.view.paper import kinematic_figures, published_figures, question_figures, report
from nipper_pin.view.paper.canvas import Plate, new_figure, plate
from nipper_pin.view.paper.kinematic_figures import kinematic_plates
from nipper_pin.view.paper.published_figures import published_plates
from nipper_pin.view.paper.supplements import sensitivity_plate, sensitivity_table
from nipper_pin.view.paper.tables import (
    COUNTED_AT,
    Table,
    count_table,
    drive_table,
    published_tables,
    ratio_table,
    rest_table,
)
from nipper_pin.view.paper.terms import terms
from nipper_pin.view.studies.sweep_figures.columns import Parameter, Quantity
from nipper_pin.view.studies.sweep_figures.main_effects import main_effects

# The studies of the paper take a quarter of a minute.
pytestmark = pytest.mark.slow

GIVEN = published()
# Peaks are read from 200 places a flight; last digits of the reduced and the direct engine.
NEAR = 2e-6
STOP = "jaw"
SHARES = np.array([0.1, 0.2, 0.35])
EFFECTS = tuple(
    DriveEffect(factor, speed, *(k * 1e-4 * factor * speed / 450.0 for k in (1, -2, 3, 4, 5)))
    for factor in (0.1, 1.0, 3.0, 10.0)
    for speed in GIVEN.speeds_rpm
)


@pytest.fixture(scope="module")
def study(e62: Mechanism) -> PaperStudy:
    """The parts of a study that its tables of transitions need."""
    studies = run_studies(e62, GIVEN)
    speeds = np.array(GIVEN.speeds_rpm)
    shares = np.arange(9.0).reshape(3, 3) / 10.0
    none = cast("Any", None)
    return PaperStudy(
        mechanism=e62,
        published=GIVEN,
        studies=studies,
        ratios=ratios(studies, GIVEN),
        identified=(),
        motions=tuple(simulate(e62, Case(speed_rpm=speed)) for speed in GIVEN.speeds_rpm),
        kinematics=none,
        counts=none,
        drives=DriveComparison({}, EFFECTS, ()),
        phase_one=cast("Any", type("PhaseOne", (), {"stop": "steeve"})()),
        fixed_step=None,
        shares=Shares(speeds, SHARES, shares, 1.0 - SHARES**2, {}),
        designs=none,
    )


CASES = {
    "table_3": [(speed, GIVEN.common_restitution, 9000.0) for speed in GIVEN.speeds_rpm],
    "table_4": [(GIVEN.common_speed_rpm, e, 9000.0) for e in GIVEN.restitutions],
    "table_5": [
        (GIVEN.common_speed_rpm, GIVEN.common_restitution, k) for k in GIVEN.stiffnesses
    ],
}  # fmt: skip


def solved(case: tuple[float, float, float], rest_rate: float | None = None) -> Judge:
    """A transition of the model files with other values."""
    speed, e, k = case
    values = {"stops.jaw.restitution": e, "springs.steeve.stiffness_N_per_m": k}
    run = simulate(load("e62", values), Case(speed_rpm=speed, rest_rate=rest_rate))
    return Judge(run)


def hits(judge: Judge) -> list[Event]:
    return [event for event in judge.hits if STOP in event.stops]


def rest(judge: Judge) -> float:
    """Time from the first collision to rest [s]."""
    end = next(e for e in judge.run.events if e.kind.value == "rest" and STOP in e.stops)
    return end.t - hits(judge)[0].t


def numbers(judge: Judge) -> dict[str, float]:
    """Rebounds and time of a transition in SI units, by the names of the document."""
    first, second, third = hits(judge)[:3]
    duration = rest(judge)
    found = {"duration_s": duration, "first_two_share": (third.t - first.t) / duration}
    for number, event in enumerate((first, second), start=1):
        height, time = judge.rebound(event, STOP) or (math.nan, math.nan)
        found[f"rebound_amplitude_{number}"], found[f"rebound_time_s_{number}"] = height, time
    return found


@pytest.fixture(scope="module")
def read() -> dict[str, list[dict[str, float]]]:
    """Numbers of all cases of the three tables."""
    return {name: [numbers(solved(case)) for case in cases] for name, cases in CASES.items()}


FACTORS = {"mdeg": 180e3 / math.pi, "ms": 1e3, "%": 100.0, "N/mm": 1e-3, "rad/s": 1.0, "µs": 1e6}


def shown(table: Table, column: str) -> list[float]:
    """Cells of a column as people see them, in SI units by the unit in heading or cell."""
    place = [item.key for item in table.columns].index(column)
    heading = table.columns[place].heading
    unit = heading.rpartition("[")[2].rstrip("]") if "[" in heading else ""
    found = []
    for row in table.shown:
        value, _, behind = row[place].partition(" ")
        found.append(float(value) / FACTORS.get(behind or unit, 1.0))
    return found


def stored(table: Table) -> dict[str, list[str]]:
    """Columns of the CSV text."""
    rows = list(csv.DictReader(io.StringIO(table.csv_text())))
    return {key: [row[key] for row in rows] for key in rows[0]}


def test_tables_3_to_5(study: PaperStudy, read: dict[str, list[dict[str, float]]]) -> None:
    """Amplitudes, times and shares, as stored and as shown."""
    tables = {item.name: item for item in published_tables(study)}
    assert set(tables) == set(CASES)
    heads = {"table_3": "speed_rpm", "table_4": "restitution", "table_5": "stiffness_N_per_m"}
    for place, (name, head) in enumerate(heads.items()):
        table, columns = tables[name], stored(tables[name])
        values = [case[place] for case in CASES[name]]
        assert [float(x) for x in columns.pop(head)] == values
        assert shown(table, head) == pytest.approx(values, rel=1e-3)
        given = columns.pop("published_share", None)
        if given is not None:
            wanted = [GIVEN.ratios[f"speed.first_two_share_{speed:g}"] for speed in values]
            assert [float(x) for x in given] == wanted
            assert shown(table, "published_share") == pytest.approx(wanted, abs=6e-5)
        assert set(columns) == set(read[name][0])
        for key, texts in columns.items():
            wanted = [item[key] for item in read[name]]
            assert [float(x) for x in texts] == pytest.approx(wanted, rel=NEAR), (name, key)
            assert shown(table, key) == pytest.approx(wanted, rel=6e-4), (name, key)


def test_ratios(study: PaperStudy, read: dict[str, list[dict[str, float]]]) -> None:
    """Changes from the first to the last case of a table, and what they deviate."""
    ours = {}
    for item in read["table_3"]:
        speed = GIVEN.speeds_rpm[read["table_3"].index(item)]
        ours[f"speed.first_two_share_{speed:g}"] = item["first_two_share"]
    words = {
        "first_rebound_amplitude": "rebound_amplitude_1",
        "second_rebound_amplitude": "rebound_amplitude_2",
        "first_rebound_time": "rebound_time_s_1", "second_rebound_time": "rebound_time_s_2",
        "transition_time": "duration_s",
    }  # fmt: skip
    for name, kind in zip(CASES, ("speed", "restitution", "stiffness"), strict=True):
        first, last = read[name][0], read[name][-1]
        for word, key in words.items():
            for end in ("increase", "change"):
                ours[f"{kind}.{word}_{end}"] = last[key] / first[key] - 1.0
    table = ratio_table(study)
    columns = stored(table)
    assert columns["name"] == list(GIVEN.ratios)
    wanted = [ours[name] for name in columns["name"]]
    deviations = [
        mine / GIVEN.ratios[name] - 1.0 for name, mine in zip(columns["name"], wanted, strict=True)
    ]
    assert [float(x) for x in columns["published"]] == list(GIVEN.ratios.values())
    assert [float(x) for x in columns["ours"]] == pytest.approx(wanted, rel=1e-4)
    assert [float(x) for x in columns["relative_deviation"]] == pytest.approx(deviations, abs=1e-4)
    assert shown(table, "ours") == pytest.approx(wanted, rel=6e-4)
    assert shown(table, "relative_deviation") == pytest.approx(deviations, abs=6e-4)
    assert Ratio("x", 4.0, 3.0).relative_deviation == -0.25


def test_counts_and_rest_by_a_threshold(study: PaperStudy) -> None:
    """Collisions up to the first rebound slower than a threshold, and the time until then."""
    fast = 1e-6

    def rates(judge: Judge) -> list[float]:
        return [judge.rate(STOP, event.v_after) for event in hits(judge)]

    def counted(found: list[float], threshold: float) -> int:
        return next(k for k, rate in enumerate(found, start=1) if rate < threshold)

    by_e = [rates(solved(case, fast)) for case in CASES["table_4"]]
    by_k = [rates(solved(case, fast)) for case in CASES["table_5"]]
    columns = stored(count_table(study))
    assert [float(x) for x in columns["threshold_rad_s"]] == list(COUNTED_AT)
    text = count_table(study).shown
    for row, threshold in enumerate(COUNTED_AT):
        found = [counted(item, threshold) for item in by_e]
        keys = [f"collisions_e_{e:g}" for e in GIVEN.restitutions]
        assert [int(columns[key][row]) for key in keys] == found
        assert [int(x) for x in text[row][1 : 1 + len(found)]] == found
        growth = found[-1] / found[0] - 1.0
        assert float(columns["increase"][row]) == pytest.approx(growth, abs=1e-12)
        more = (found[-1] - 1) / (found[0] - 1) - 1.0 if found[0] > 1 else None
        cell = columns["rebounds_increase"][row]
        assert (float(cell) if cell else None) == (more and pytest.approx(more))
        other = [counted(item, threshold) for item in by_k]
        assert int(columns["stiffness_from"][row]) == min(other)
        assert int(columns["stiffness_to"][row]) == max(other)
    case = (GIVEN.common_speed_rpm, GIVEN.common_restitution, 9000.0)
    bounces, limit = solved(case, fast), rest(solved(case))
    columns = stored(rest_table(study))
    for row, threshold in enumerate(COUNTED_AT):
        number = counted(rates(bounces), threshold)
        end = hits(bounces)[number - 1].t - hits(bounces)[0].t
        assert int(columns["collisions"][row]) == number
        assert float(columns["time_s"][row]) == pytest.approx(end, rel=1e-9)
        assert float(columns["missing_s"][row]) == pytest.approx(limit - end, abs=1e-12)
        missing = pytest.approx((limit - end) / limit, abs=1e-9)
        assert float(columns["missing_share"][row]) == missing
    table = rest_table(study)
    for key in ("time_s", "missing_s", "missing_share"):
        assert shown(table, key) == pytest.approx([float(x) for x in columns[key]], rel=6e-2)


def test_effects_of_inertial_shafts(study: PaperStudy) -> None:
    """Columns of the table by name, of the factors that are shown."""
    table = drive_table(study)
    names = {
        "speed_rpm": "speed_rpm", "inertia_factor": "factor",
        "first_impulse_change": "first_impulse", "rebound_amplitude_1_change": "first_amplitude",
        "rebound_amplitude_2_change": "second_amplitude", "duration_change": "transition_time",
        "shaft_rate_jump": "shaft_jump",
    }  # fmt: skip
    columns = stored(table)
    assert set(columns) == set(names)
    kept = [item for item in EFFECTS if item.factor in (0.1, 1.0, 10.0)]
    for key, name in names.items():
        wanted = [getattr(item, name) for item in kept]
        assert [float(x) for x in columns[key]] == wanted
        assert shown(table, key) == pytest.approx(wanted, rel=1e-2, abs=6e-6)


def test_figures_12_to_14(study: PaperStudy, read: dict[str, list[dict[str, float]]]) -> None:
    """Impulses, times and crosses of the study's figures in the units of their labels."""
    motion, impulses, restitution, stiffness = (item.figure for item in published_plates(study))
    for axes, run in zip(motion.axes, study.motions, strict=True):
        assert axes.get_ylabel() == "jaw angle [mdeg]"
        judge = Judge(run)
        curve, marks, square = axes.lines
        start = hits(judge)[0].t
        times = [1e3 * (event.t - start) for event in hits(judge)]
        np.testing.assert_allclose(marks.get_xdata(), times, atol=1e-9)
        assert float(square.get_xdata()[0]) == pytest.approx(1e3 * rest(judge), rel=1e-9)
        t, angle = (np.asarray(values) for values in curve.get_data())
        for i in range(5, len(t) - 5, 31):
            q = judge.state(start + 1e-3 * t[i], left=True)[0]
            wanted = 1e3 * math.degrees(judge.gap(STOP, q))
            assert angle[i] == pytest.approx(wanted, rel=1e-5, abs=1e-6)
        # The inset: from the second collision on.
        (inset,) = axes.child_axes
        small, strokes = inset.lines
        assert inset.get_ylabel() == "[mdeg]"
        later = t >= times[1] - 1e-12
        np.testing.assert_allclose(small.get_xdata(), t[later])
        np.testing.assert_allclose(small.get_ydata(), angle[later], atol=1e-9)
        np.testing.assert_allclose(strokes.get_xdata(), times[1:], atol=1e-9)
    for axes in impulses.axes:
        assert axes.get_ylabel() == "impulse [N s]"
        for line, case in zip(axes.lines, CASES["table_3"], strict=True):
            judge = solved(case)
            lever = judge.stops[STOP].lever or 1.0
            wanted = [judge.impulses(event)[0][STOP] / lever for event in hits(judge)[:4]]
            assert line.get_ydata()[:4] == pytest.approx(wanted, rel=1e-7)
            assert list(line.get_xdata()[:4]) == [1, 2, 3, 4]
    durations = [1e3 * item["duration_s"] for item in read["table_4"]]
    time = restitution.axes[0]
    assert time.get_ylabel() == "time to rest [ms]"
    assert time.lines[0].get_ydata() == pytest.approx(durations, rel=NEAR)
    grown = durations[0] * (1.0 + GIVEN.ratios["restitution.transition_time_increase"])
    assert float(time.lines[1].get_ydata()[0]) == pytest.approx(grown, rel=NEAR)
    time = stiffness.axes[0]
    assert (time.get_xlabel(), time.get_ylabel()) == ("spring rate [N/mm]", "time [ms]")
    lines = {line.get_label(): line for line in time.lines if len(line.get_xdata()) > 1}
    for label, key in (
        ("time to rest", "duration_s"), ("first rebound", "rebound_time_s_1"),
        ("second rebound", "rebound_time_s_2"),
    ):  # fmt: skip
        wanted = [1e3 * item[key] for item in read["table_5"]]
        assert lines[label].get_ydata() == pytest.approx(wanted, rel=NEAR)
        assert lines[label].get_xdata() == pytest.approx([1e-3 * k for k in GIVEN.stiffnesses])


def test_figure_of_shares(study: PaperStudy) -> None:
    """Shares by speed, 1 - e^2, their difference in points of per cent, and published marks."""
    axes, difference = question_figures._shares(study).figure.axes
    ballistic = [1.0 - e * e for e in SHARES]
    lines = {line.get_label(): line for line in axes.lines}
    np.testing.assert_allclose(
        lines["1 - e²"].get_ydata(), [100.0 * x for x in ballistic], rtol=1e-12
    )
    curves = [line for line in difference.lines if len(line.get_xdata()) > 1]
    marks = [line for line in difference.lines if len(line.get_xdata()) == 1]
    crosses = [line for line in axes.lines if line.get_marker() == "x" and len(line.get_xdata())]
    e = GIVEN.common_restitution
    for i, speed in enumerate(GIVEN.speeds_rpm):
        line = lines[f"{speed:g} r/min"]
        np.testing.assert_allclose(line.get_xdata(), SHARES)
        np.testing.assert_allclose(line.get_ydata(), 100.0 * study.shares.shares[i])
        points = 100.0 * (study.shares.shares[i] - ballistic)
        np.testing.assert_allclose(curves[i].get_ydata(), points, atol=1e-12)
        given = GIVEN.ratios[f"speed.first_two_share_{speed:g}"]
        assert crosses[i].get_xydata().tolist() == [[e, pytest.approx(100.0 * given)]]
        wanted = 100.0 * (given - 1.0 + e * e)
        assert marks[i].get_xydata()[0].tolist() == pytest.approx([e, wanted])


def test_kinematic_figures(study: PaperStudy, e62: Mechanism) -> None:
    """Guide, links and stops over a turn: a closed form, and the states of a simulated turn."""
    turn = kinematics(e62, GIVEN.speeds_rpm)
    guide, links, stops = (
        item.figure for item in kinematic_plates(replace(study, kinematics=turn))
    )
    speed = GIVEN.speeds_rpm[0]
    run = simulate(e62, Case(speed_rpm=speed, window=Window.CYCLE))
    judge = Judge(run)
    law = judge.document["drives"]["pendulum"]
    arm = np.subtract(law["crank_axis_mm"], law["guide_axis_mm"])

    def bar(psi: float) -> float:
        r = law["crank_radius_mm"]
        return math.atan2(arm[1] + r * math.sin(psi), arm[0] + r * math.cos(psi))

    touch = math.radians(judge.document["cylinder"]["angle_at_touch_deg"])
    units = ("deg", "rad/s", "rad/s²")
    for axes, unit, order in zip(guide.axes, units, range(3), strict=True):
        assert unit_in(axes.get_ylabel()) == unit
        for line, rpm in zip(axes.lines, GIVEN.speeds_rpm, strict=True):
            omega, h = -math.tau * rpm / 60.0, 1e-3
            for i in range(3, len(line.get_xdata()), 71):
                place = float(line.get_xdata()[i])
                psi = touch - math.tau * (place - turn.closing_index) / 40.0
                left, here, right = bar(psi - h), bar(psi), bar(psi + h)
                wanted = (
                    math.degrees(here - bar(touch)),
                    omega * (right - left) / (2.0 * h),
                    omega**2 * (right - 2.0 * here + left) / h**2,
                )[order]
                size = np.abs(line.get_ydata()).max()
                assert line.get_ydata()[i] == pytest.approx(wanted, abs=1e-4 * size)
    assert [unit_in(axes.get_ylabel()) for axes in links.axes] == list(units)
    labels = [line.get_label().replace(" ", "_") for line in links.axes[0].lines]
    assert labels == list(e62.links)
    held = [item for item in judge.phases if len(item[0]) == 1 and item[2] - item[1] > 1e-3]
    for _, begin, end in held:
        for share in (0.3, 0.7):
            t, h = begin + share * (end - begin), 1e-6
            place = judge.index(t)
            q, v, _ = judge.state(t, left=True)
            rest = judge.places(np.zeros(len(q)))
            angles = {n: math.degrees(x[2] - rest[n][2]) for n, x in judge.places(q).items()}
            rates = {name: x[0] for name, x in judge.links(q, v).items()}
            ahead, behind = (judge.links(*judge.state(t + step, left=True)[:2]) for step in (h, -h))
            faster = {name: (ahead[name][0] - behind[name][0]) / (2.0 * h) for name in rates}
            for axes, found in zip(links.axes, (angles, rates, faster), strict=True):
                for line, link in zip(axes.lines, labels, strict=True):
                    size = float(np.nanmax(np.abs(line.get_ydata()))) + 1e-9
                    drawn = float(np.interp(place, line.get_xdata(), line.get_ydata()))
                    assert drawn == pytest.approx(found[link], abs=2e-3 * size), link
            factors = {"jaw": 180.0 / math.pi, "steeve": 1e3}
            for column, name in enumerate(("jaw", "steeve")):
                gap, rate = factors[name] * judge.gap(name, q), judge.rate(name, v)
                rise = [judge.rate(name, judge.state(t + s, left=True)[1]) for s in (h, -h)]
                found = (gap, rate, (rise[0] - rise[1]) / (2.0 * h))
                for row, wanted in enumerate(found):
                    axes = stops.axes[2 * row + column]
                    (line,) = axes.lines
                    size = float(np.nanmax(np.abs(line.get_ydata()))) + 1e-9
                    drawn = float(np.interp(place, line.get_xdata(), line.get_ydata()))
                    assert drawn == pytest.approx(wanted, abs=2e-3 * size), (name, row)
    shown = [unit_in(axes.get_ylabel()) for axes in stops.axes]
    assert shown == ["deg", "mm", "rad/s", "m/s", "rad/s²", "m/s²"]


def unit_in(label: str) -> str:
    return label.rpartition("[")[2].rstrip("]")


def in_caption(text: str, pattern: str) -> list[float]:
    """Numbers of a caption."""
    found = re.search(pattern.replace("#", r"(-?[\d.]+)"), text)
    assert found is not None, pattern
    return [float(item) for item in found.groups()]


def test_frames_and_captions(
    study: PaperStudy, e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Labels, scales, letters, legends and limits of every panel; numbers below the figures."""
    for room in (published_figures, kinematic_figures):
        monkeypatch.setattr(
            room, "plate",
            lambda name, title, caption, figure: Plate(name, title, caption, figure, "", b""),
        )  # fmt: skip
    turn = kinematics(e62, GIVEN.speeds_rpm)
    complete = replace(study, kinematics=turn)
    plates = [*published_plates(complete), *kinematic_plates(complete)]
    names = ["figure_11", "figure_12", "figure_13", "figure_14", "guide", "links", "both_stops"]
    plate_frames.check(plates, names, terms(study).mark)
    panels = {item.name: item.figure.axes for item in plates}
    caption = {item.name: item.caption for item in plates}
    rests = [float(axes.lines[2].get_xdata()[0]) for axes in panels["figure_11"]]
    told = in_caption(caption["figure_11"], "limit of the series: #, #, # ms")
    assert told == pytest.approx(rests, abs=6e-4)
    impulses = np.array([line.get_ydata()[:2] for line in panels["figure_12"][0].lines])
    told = in_caption(caption["figure_12"], "first impulses, #, #, # N s")
    assert told == pytest.approx(impulses[:, 0].tolist(), abs=6e-4)
    share = impulses[:, 1] / impulses[:, 0]
    told = in_caption(caption["figure_12"], "The second is # to # of the first; .* e = #")
    assert told == pytest.approx([share.min(), share.max(), GIVEN.common_restitution], abs=6e-4)
    rates = [1e-3 * k for k in GIVEN.stiffnesses]
    for name, ticks in (("figure_13", list(GIVEN.restitutions)), ("figure_14", rates)):
        speed = in_caption(caption[name], "against the (?:restitution|spring rate) at # r/min")
        assert speed == [GIVEN.common_speed_rpm]
        for axes in panels[name]:
            assert axes.get_xticks() == pytest.approx(ticks)
        counts = panels[name][1]
        assert all(tick == round(tick) for tick in counts.get_yticks())
        for line, threshold in zip(counts.lines, (1e-3, 0.02, 0.06), strict=True):
            kind = study.studies.restitution if name == "figure_13" else study.studies.stiffness
            wanted = [
                1 + int(np.sum(rates[np.isfinite(rates)] >= threshold)) for rates in kind.rates
            ]
            assert list(line.get_xdata()) == pytest.approx(ticks)
            assert list(line.get_ydata()) == wanted
            assert line.get_label() == f"threshold {threshold:g} rad/s"
    crosses = [line for line in panels["figure_14"][0].lines if line.get_marker() == "x"]
    for line, place, key in zip(crosses, (0, 1), ("first", "second"), strict=True):
        grown = 1.0 + GIVEN.ratios[f"stiffness.{key}_rebound_time_change"]
        wanted = 1e3 * study.studies.stiffness.times[0, place] * grown
        assert line.get_xydata()[0] == pytest.approx([1e-3 * GIVEN.stiffnesses[-1], wanted])
    for name in ("guide", "links", "both_stops"):
        for axes in panels[name]:
            spans = [(item.get_x(), item.get_x() + item.get_width()) for item in axes.patches]
            assert spans == [
                pytest.approx((0.0, turn.opening_index)), pytest.approx((turn.closing_index, 40.0))
            ]  # fmt: skip
            assert axes.get_xlim() == (0.0, 40.0)
    angle = np.asarray(panels["guide"][0].lines[0].get_ydata())
    fast = np.asarray(panels["guide"][2].lines[-1].get_ydata())
    told = in_caption(caption["guide"], "swings by # degrees .* at # r/min its .* reaches # rad")
    wanted = [float(np.ptp(angle)), GIVEN.speeds_rpm[-1], float(np.abs(fast).max())]
    assert told == pytest.approx(wanted, rel=5e-4)
    # The largest size may be one against the sense of the drive.
    *others, last = turn.guides
    braked = replace(last, acceleration=last.acceleration - 300.0)
    doctored = replace(complete, kinematics=replace(turn, guides=(*others, braked)))
    told = in_caption(kinematic_plates(doctored)[0].caption, "acceleration reaches # rad")
    assert told == pytest.approx([300.0 - float(fast.min())], rel=5e-4)
    assert in_caption(caption["links"], "acceleration at # r/min") == [GIVEN.speeds_rpm[0]]
    words = [text.get_text() for text in plates[5].figure.legends[0].get_texts()]
    assert sorted(words) == sorted(link.replace("_", " ") for link in e62.links)
    jaw, stroke = (np.asarray(axes.lines[0].get_ydata()) for axes in panels["both_stops"][:2])
    told = in_caption(
        caption["both_stops"],
        "at # r/min as .* at index # and would open at #; it opens to # degrees, .* by # mm",
    )
    wanted = [turn.speed_rpm, turn.closing_index, turn.opening_index, jaw.max(), stroke.max()]
    assert told == pytest.approx(wanted, rel=3e-3)


def test_headings_are_texts_but_for_subscripts() -> None:
    assert report._subscripts("A<sub>1</sub> [deg]") == "A<sub>1</sub> [deg]"
    shown = report._subscripts(HOSTILE)
    assert "<img" not in shown
    assert '"' not in shown


HOSTILE = 'x"><img src=x onerror="PWN=1"> & <sub>'


@pytest.mark.parametrize("title", ["A title", HOSTILE])
def test_a_figure_as_files(title: str) -> None:
    """As an element of a page and as documents: named, without size, date and shared names.

    The name of a stop may be anything, and stays a text.
    """
    figure = new_figure(2.0, "estimates")
    figure.subplots().plot([1.0, 2.0])
    made = plate("some_name", title, "words", figure)
    root = ElementTree.fromstring(made.inline_svg)
    assert (root.get("role"), root.get("aria-label")) == ("img", title)
    assert not list(root.iter("{*}img"))
    assert root.get("viewBox")
    assert root.get("width") is root.get("height") is None
    names = [item.get("id") for item in root.iter() if item.get("id")]
    assert names
    assert all(str(name).startswith("some_name-") for name in names)
    assert not list(root.iter("{*}metadata"))
    assert "<dc:date>" not in made.svg
    assert title in {item.text for item in ElementTree.fromstring(made.svg).iter()}
    assert made.pdf.startswith(b"%PDF")
    assert b"CreationDate" not in made.pdf
    assert figure.get_size_inches()[1] == 2.0


@pytest.mark.slow
def test_shares_are_those_of_runs(e62: Mechanism) -> None:
    """The study's shares at some restitutions and speeds."""
    found = shares_of.shares(e62, GIVEN)
    for i, j in ((0, 8), (1, 18), (2, 28)):
        case = (float(found.speeds_rpm[i]), float(found.restitutions[j]), 9000.0)
        assert found.shares[i, j] == pytest.approx(
            numbers(solved(case))["first_two_share"], rel=1e-6
        )
    np.testing.assert_allclose(found.ballistic, 1.0 - found.restitutions**2, rtol=1e-14)


def test_first_effect_of_inertial_shafts(e62: Mechanism) -> None:
    """Relative changes and the jump of the shafts, by two runs read from their events."""
    speed = 650.0
    runs = [
        Judge(simulate(e62, Case(speed_rpm=speed, drive=drive)))
        for drive in (DriveMode.HELD, DriveMode.INERTIAL)
    ]
    held, free = (numbers(judge) for judge in runs)
    found = [_numbers(e62, speed, drive) for drive in (DriveMode.HELD, DriveMode.INERTIAL)]
    for place, key in ((1, "rebound_amplitude_1"), (2, "rebound_amplitude_2"), (3, "duration_s")):
        assert found[0][place] == pytest.approx(held[key], rel=NEAR)
        assert found[1][place] == pytest.approx(free[key], rel=NEAR)
    event = hits(runs[1])[0]
    jumps = [
        abs(event.v_after[column] - event.v_before[column]) / abs(event.v_before[column])
        for column in runs[1].drives.values()
    ]
    assert found[1][4] == pytest.approx(max(jumps), rel=1e-9)
    assert found[0][4] == 0.0


# Made-up numbers.


def sensitivity(path: str, unit: str, *per: float) -> Sensitivity:
    shifted = np.array(per)
    shifted[1] += 1e-3
    return Sensitivity(path=path, value=7.0, unit=unit, per=np.array(per), control=shifted)


def test_bars_and_table_of_sensitivities() -> None:
    """One bar a number, as long as its effect, by quantity and ranked within its kind of unit."""
    rows = (
        sensitivity("links.top_nipper.mass_kg", "%", 0.5, -0.25, 0.125),
        sensitivity("springs.steeve.preload_length_mm", "mm", -8.0, -4.0, 9.0),
        sensitivity("stops.jaw.restitution", "%", 1.9, 0.7, 0.0),
        sensitivity("points.pin.x_mm", "mm", 3.0, 6.0, -1.0),
    )
    found = Sensitivities(
        model="e62", stop="jaw", speed_rpm=650.0, amplitude_rad=5e-3, transition_time_s=6e-3,
        clamping_force_N=80.0, premise_holds=True, rows=rows,
    )  # fmt: skip
    figure = sensitivity_plate(found, "").figure
    words = ("first rebound amplitude", "time to rest", "clamping force")
    for place, (axes, word) in enumerate(zip(figure.axes, words, strict=True)):
        assert axes.get_xlabel() == f"change of the {word} [%]"
        order = sorted(rows, key=lambda row: (row.unit == "%", -abs(row.per[place])))[::-1]
        bars = [patch for patch in axes.patches if patch.get_height() > 0.0]
        assert [bar.get_width() for bar in bars] == [row.per[place] for row in order]
        labels = [label.get_text() for label in axes.get_yticklabels()]
        assert [text.rpartition("[")[2].rstrip("]") for text in labels] == [r.unit for r in order]
        said = [text.get_text() for text in axes.texts if text.get_text()[:1] in "+-0123456789"]
        assert [float(text) for text in said] == pytest.approx(
            [row.per[place] for row in order], rel=0.06
        )
    table = stored(sensitivity_table(found))
    ranked = sorted(rows, key=lambda row: -abs(row.per[0]))
    assert table["path"] == [row.path for row in ranked]
    assert table["unit"] == [row.unit for row in ranked]
    for place, name in enumerate(QUANTITIES):
        key = f"{name.removesuffix('_s').removesuffix('_N')}_percent"
        assert [float(x) for x in table[key]] == [row.per[place] for row in ranked]
    assert [float(x) for x in table["disagreement_percent"]] == pytest.approx([1e-3] * 4)


def test_bands_of_main_effects() -> None:
    """At every value the mean as a line and the 10th to 90th per cent of scenarios as a band."""
    random = np.random.default_rng(3)
    values = [1.0, 2.0, 4.0]
    x = np.repeat(values, 41)
    y = x**2 + random.exponential(size=len(x))
    axis = {"name": "k", "path": "k", "low": 1.0, "high": 4.0, "scale": "linear", "values": values}
    table = SweepTable(
        title="made up", model="none", axes=(axis,), quantities=("y",), scenarios=len(x),
        stored=len(x), table=pa.table({"k": x, "y": y}),
    )  # fmt: skip
    axes = main_effects(table, [Parameter.of(table, 0)], Quantity.of(table, "y")).axes[0]
    (line,) = axes.get_lines()
    (band,) = [item for item in axes.collections if isinstance(item, PolyCollection)]
    corners = {tuple(np.round(row, 9)) for row in band.get_paths()[0].vertices}
    for value, mean in zip(values, line.get_ydata(), strict=True):
        part = sorted(y[x == value])
        assert mean == pytest.approx(sum(part) / 41.0, rel=1e-12)
        # Of 41 sorted values the 5th and the 37th lie at a tenth and at nine tenths.
        for edge in (part[4], part[36]):
            assert (round(value, 9), round(float(edge), 9)) in corners
    for path, label in (
        ("springs.steeve.stiffness_N_per_m", "stiffness of spring steeve [N/mm]"), ("k", "k"),
    ):  # fmt: skip
        found = Parameter.of(replace(table, axes=({**axis, "path": path},)), 0)
        assert found.shown.label == label
        assert found.x == pytest.approx(x * (1e-3 if "N/mm" in label else 1.0), rel=1e-15)


def made_up_row(start: int) -> Row:
    """A row whose numbers all differ."""
    ms = [float(f"{start + k}.{k}") for k in range(4)]
    errors = [float(f"{start % 10 + 0.1 * k:.1f}e-{5 + k}") for k in range(6)]
    return Row(
        engine=f"engine {start}", setting="1e-9", wall_ms=ms[0], first_ms=ms[1], fastest_ms=ms[2],
        spread_ms=ms[3], runs=30, error_duration=errors[0], error_worst=errors[1],
        error_times=errors[2], error_impulses=errors[3], error_amplitudes=errors[4],
        error_trajectory=errors[5], evaluations=1000 + start, version=f"4.{start}",
    )  # fmt: skip


def test_tables_of_the_benchmark() -> None:
    """Every column of rows of engines and peers, and the largest of stated errors."""
    fields = {
        "engine": "engine", "peer": "engine", "version": "version", "setting": "setting",
        "ms": "wall_ms", "fastest": "fastest_ms", "spread": "spread_ms", "first": "first_ms",
        "worst of four": "error_worst", "transition": "error_duration",
        "times": "error_times", "impulses": "error_impulses", "amplitudes": "error_amplitudes",
        "trajectory": "error_trajectory", "evaluations": "evaluations",
    }  # fmt: skip
    rows = (made_up_row(11), made_up_row(27))
    for sheet in (
        benchmark_report._measured("", benchmark_report._ENGINES, rows, 2),
        benchmark_report._measured("", benchmark_report._PEERS, rows, 3),
    ):
        for cells, row in zip(sheet.rows, rows, strict=True):
            for heading, cell in zip(sheet.headings, cells, strict=True):
                wanted = getattr(row, fields[heading])
                if isinstance(wanted, str):
                    assert cell == wanted
                else:
                    assert float(cell) == pytest.approx(wanted, rel=6e-3), heading
    stated = tuple(
        Stated(case, tolerance, times, impulses)
        for case, tolerance, times, impulses in (
            ("a", 1e-4, 0.2, 0.7), ("b", 1e-4, 0.5, 0.3), ("a", 1e-8, 0.9, 0.1),
        )
    )  # fmt: skip
    result = cast("Benchmark", type("Result", (), {"stated": stated})())
    sheet = benchmark_report._stated(result)
    assert sheet.headings == ("tolerance", "times", "impulses")
    assert [[float(cell) for cell in row] for row in sheet.rows] == [
        [1e-4, 0.5, 0.7], [1e-8, 0.9, 0.1],
    ]  # fmt: skip
