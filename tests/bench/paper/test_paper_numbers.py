"""Numbers of the study and of its figures 11 to 14, compared with runs of the model files.

The runs are read by :mod:`judge`, which shares no code with the study.
"""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from judge import Judge

from benchmarks.paper import figures
from benchmarks.paper.drives import _numbers
from benchmarks.paper.published import published
from benchmarks.paper.ratios import ratios
from benchmarks.paper.shares import Shares, shares
from benchmarks.paper.studies import run_studies
from benchmarks.paper.study import PaperStudy
from nipper_pin import Case, DriveMode, Mechanism, load, simulate
from nipper_pin.hybrid.event import Event

# The studies of the paper take a quarter of a minute.
pytestmark = pytest.mark.slow

GIVEN = published()
# Peaks are read from 200 places a flight; last digits of the reduced and the direct engine.
NEAR = 2e-6
STOP = "jaw"
SHARES = np.array([0.1, 0.2, 0.35])


@pytest.fixture(scope="module")
def study(e62: Mechanism) -> PaperStudy:
    """The parts of a study that its tables of transitions need."""
    studies = run_studies(e62, GIVEN)
    speeds = np.array(GIVEN.speeds_rpm)
    rows = np.arange(9.0).reshape(3, 3) / 10.0
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
        drives=none,
        phase_one=none,
        fixed_step=None,
        shares=Shares(speeds, SHARES, rows, 1.0 - SHARES**2, {}),
        durations=none,
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
    assert [item.name for item in study.ratios] == list(GIVEN.ratios)
    for item in study.ratios:
        assert item.published == GIVEN.ratios[item.name]
        assert item.ours == pytest.approx(ours[item.name], rel=1e-4)


def test_figures_11_to_14(study: PaperStudy, read: dict[str, list[dict[str, float]]]) -> None:
    """Impulses, times and crosses of the study's figures in the units of their labels."""
    motion, impulses, restitution, stiffness = (
        draw(study)
        for draw in (figures._figure_11, figures._figure_12, figures._figure_13, figures._figure_14)
    )
    for axes, run in zip(motion.axes, study.motions, strict=True):
        assert axes.get_ylabel() == "jaw angle [mdeg]"
        judge = Judge(run)
        curve, square = axes.lines
        start = hits(judge)[0].t
        assert float(square.get_xdata()[0]) == pytest.approx(1e3 * rest(judge), rel=1e-9)
        t, angle = (np.asarray(values) for values in curve.get_data())
        for i in range(5, len(t) - 5, 31):
            q = judge.state(start + 1e-3 * t[i], left=True)[0]
            wanted = 1e3 * math.degrees(judge.gap(STOP, q))
            assert angle[i] == pytest.approx(wanted, rel=1e-5, abs=1e-6)
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
    axes, difference = figures._shares(study).axes
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


@pytest.mark.slow
def test_shares_are_those_of_runs(e62: Mechanism) -> None:
    """The study's shares at some restitutions and speeds."""
    found = shares(e62, GIVEN)
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
