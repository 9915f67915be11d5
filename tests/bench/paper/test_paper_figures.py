"""Figures and table of the published study, from results that are made up.

They are compared with closed forms of results that differ in every place, so that one that is taken
from another place, or in another unit, is seen.
"""

from __future__ import annotations

import io
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from rich.console import Console

from benchmarks.paper import figures
from benchmarks.paper.counts import Counts, collision_counts
from benchmarks.paper.drives import FACTORS, DriveComparison, DriveEffect
from benchmarks.paper.fixed_step import FixedStep, Rule
from benchmarks.paper.phases import PhaseOne, Release
from benchmarks.paper.published import published
from benchmarks.paper.ratios import Ratio
from benchmarks.paper.report import print_paper, sheet
from benchmarks.paper.shares import MAP_RESTITUTIONS, DurationMap, Shares
from benchmarks.paper.studies import Studies
from benchmarks.paper.study import PaperStudy
from nipper_pin import Mechanism

GIVEN = published()
DECELERATION = 40.0


def series(rate: float, e: float) -> tuple[list[float], list[float]]:
    """Separation rates of bounces under a constant force [rad/s], and times of collisions [s]."""
    rates, times = [rate], [0.0]
    while rates[-1] > 1e-6:
        times.append(times[-1] + 2.0 * rates[-1] / DECELERATION)
        rates.append(e * rates[-1])
    return rates, times


def bounces(name: str, values: Any, cases: list[tuple[float, float]]) -> Any:
    """A study whose transitions are geometric series."""
    found = [series(*case) for case in cases]
    most = max(len(rates) for rates, _ in found)
    fill = np.full((2, len(cases), most), np.nan)
    for place, (rates, times) in enumerate(found):
        fill[0, place, : len(rates)], fill[1, place, : len(times)] = rates, times
    count = len(cases)
    return SimpleNamespace(
        name=name, values=np.array(values), rates=fill[0], bounces=SimpleNamespace(time=fill[1]),
        table=SimpleNamespace(duration=1e-3 * (2.0 + np.arange(count) + len(name)),
                              first_two_share=0.9 + 0.011 * np.arange(count)),
        amplitudes=np.ones((count, 2)), times=np.ones((count, 2)),
    )  # fmt: skip


RESTITUTION = [(0.1 + 0.1 * i, e) for i, e in enumerate(GIVEN.restitutions)]
STIFFNESS = [(0.45 - 0.06 * i, 0.2) for i in range(len(GIVEN.stiffnesses))]
SPEED = [(0.2 + 0.11 * i, 0.2) for i in range(len(GIVEN.speeds_rpm))]
EFFECTS = tuple(
    DriveEffect(factor, speed, *(s * 1e-3 * (j + 2) * (i + 1) ** s / factor
                                 for j, s in enumerate((1, -1, 1, -1, 1))))
    for i, speed in enumerate(GIVEN.speeds_rpm)
    for factor in FACTORS
)  # fmt: skip
INDEX = np.linspace(24.0, 33.0, 37)
STEPS = np.array([1e-6, 3e-7, 1e-8])


def rule(name: str, size: float) -> Rule:
    errors = size * np.outer(STEPS / STEPS[0], [1.0, -3.0, 5.0, 7.0]) * (1.0 + 0.1 * np.arange(4))
    return Rule(name, STEPS, errors, 0.9 + 1e3 * size, 1e-9 * size * np.array([1, 2, -4, 8.0]))


@pytest.fixture(scope="module")
def study(e62: Mechanism) -> PaperStudy:
    """Made-up results."""
    studies = Studies(
        bounces("speed", GIVEN.speeds_rpm, SPEED),
        bounces("restitution", GIVEN.restitutions, RESTITUTION),
        bounces("stiffness", GIVEN.stiffnesses, STIFFNESS),
    )
    speeds = np.linspace(400.0, 700.0, 61)
    e = np.linspace(0.02, 0.5, 25)
    numbers = np.arange(1, len(GIVEN.ratios) + 1)
    ours = [
        Ratio(name, value, value * (1.0 + 0.011 * k * (-1) ** k))
        for k, (name, value) in zip(numbers, GIVEN.ratios.items(), strict=True)
    ]
    place = np.linspace(0.0, 1.0, len(INDEX))
    # Falls with speed and restitution as planes do, so that lines of equal time are straight.
    durations = 1e-3 * (
        np.array([2.0, 3.0, 4.0])[:, None, None]
        + 10.0 * MAP_RESTITUTIONS[None, :, None]
        + 0.01 * (speeds - 400.0)[None, None, :]
    )
    return PaperStudy(
        mechanism=e62,
        published=GIVEN,
        studies=studies,
        ratios=tuple(ours),
        identified=tuple(replace(item, ours=item.published * 1.05) for item in ours[:7])
        + tuple(replace(item, ours=item.published * 0.97) for item in ours[7:]),
        motions=(),
        kinematics=cast("Any", None),
        counts=collision_counts(studies, GIVEN),
        drives=DriveComparison(
            {"pendulum": 1.25, "tension": 0.375},
            EFFECTS,
            tuple(replace(item, ours=item.ours * (1.0 + 1e-4 * k)) for k, item in enumerate(ours)),
        ),
        phase_one=PhaseOne(
            stop="steeve",
            preload=11e-3,
            preloads=np.linspace(5e-3, 17e-3, 9),
            speeds_rpm=np.linspace(400.0, 800.0, 11),
            index=INDEX,
            per_preload=9000.0 + 3000.0 * place,
            weight=4.0 - 2.0 * place,
            per_speed2=0.02 - 0.05 * place,
            releases=(
                Release(450.0, None, 0.0, 0.0),
                Release(550.0, 27.125, 3.3e-6, 1.7e-3),
                Release(650.0, 28.625, 4.7e-5, 2.9e-3),
            ),
        ),
        fixed_step=FixedStep(650.0, 1_234_567, 89, 3.1e-15, (rule("forward", 1e-4),
                                                              rule("semi-implicit", 3e-5))),
        shares=Shares(
            np.array(GIVEN.speeds_rpm), e,
            1.0 - e**2 + 0.04 * e[None] * np.array([[0.5], [1.0], [1.5]]),
            1.0 - e**2, dict(zip(GIVEN.ratios, 0.5 + 0.01 * numbers, strict=True)),
        ),
        durations=DurationMap(np.array([7e3, 9e3, 11e3]), speeds, durations),
    )  # fmt: skip


def smallest(preload: float, rpm: float) -> float:
    """Least force of the made-up stop [N]."""
    omega = math.tau * rpm / 60.0
    place = np.linspace(0.0, 1.0, len(INDEX))
    force = preload * (9000.0 + 3000.0 * place) + 4.0 - 2.0 * place
    return float((force + omega**2 * (0.02 - 0.05 * place)).min())


def threshold(preload: float) -> float:
    """Speed at which that becomes zero [r/min], by halving."""
    low, high = 0.0, 1e4
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if smallest(preload, middle) > 0.0 else (low, middle)
    return low


def number(case: tuple[float, float], limit: float) -> int:
    """Collisions until the first rebound slower than a limit."""
    rate, e = case
    return next(k for k in range(1, 10_000) if rate * e ** (k - 1) < limit)


def lasting(case: tuple[float, float], limit: float) -> float:
    """Time of the last of these collisions [s]: a geometric sum."""
    rate, e = case
    return 2.0 * rate / DECELERATION * (1.0 - e ** (number(case, limit) - 1)) / (1.0 - e)


def test_counts_are_those_of_geometric_series(study: PaperStudy) -> None:
    """All numbers of the document, and the stretches of thresholds, at random thresholds."""
    counts: Counts = study.counts
    found = counts.record()
    limits = found["threshold_rad_s"]
    assert limits == pytest.approx([10.0 ** (-4.0 + 0.5 * k) for k in range(9)], rel=1e-9)
    for key, cases in (
        ("by_restitution", RESTITUTION), ("by_stiffness", STIFFNESS), ("by_speed", SPEED),
    ):  # fmt: skip
        assert found[key] == [[number(case, limit) for case in cases] for limit in limits], key
    for limit, told in zip(limits, found["transition_time_increase"], strict=True):
        first, last = lasting(RESTITUTION[0], limit), lasting(RESTITUTION[-1], limit)
        assert told == (pytest.approx(last / first - 1.0, rel=1e-9) if first > 0.0 else None)
    most = 0.0
    for limit in 10.0 ** np.random.default_rng(8).uniform(-5.0, 1.0, 300):
        few, many = number(RESTITUTION[0], limit), number(RESTITUTION[-1], limit)
        most = max(most, many / few)
        same = len({number(case, limit) for case in STIFFNESS}) == 1
        rebounds = few > 1 and many - 1 == 4 * (few - 1)
        wanted = {
            "collisions_grow_as_published": many == 4 * few,
            "rebounds_grow_as_published": rebounds,
            "collisions_grow_to_the_published_multiple": many == 3 * few,
            "unchanged_by_stiffness": same,
            "rebounds_as_published_and_unchanged_by_stiffness": rebounds and same,
        }
        for key, holds in wanted.items():
            assert holds == any(low < limit <= high for low, high in found[key]), (key, limit)
    assert found["rebounds_grow_as_published"]
    assert found["collisions_grow_to_the_published_multiple"]
    assert found["largest_increase_of_collisions"] == pytest.approx(most - 1.0, abs=1e-12)


def test_figure_of_thresholds(study: PaperStudy) -> None:
    """Steps of three restitutions, the shaded stretch, and the growth of the time."""
    steps, time = figures._thresholds(study).axes
    lines = {line.get_label(): line for line in steps.lines}
    for place in (0, 2, 4):
        line = lines[f"e = {GIVEN.restitutions[place]:g}"]
        for x, y in list(zip(*line.get_data(), strict=True))[::53]:
            assert y == number(RESTITUTION[place], float(x) * (1.0 - 1e-12))
    spans = [(p.get_x(), p.get_x() + p.get_width()) for p in steps.patches]
    assert spans == [
        pytest.approx(item) for item in study.counts.matches["rebounds_grow_as_published"]
    ]
    curve, limit, given = time.lines
    for x, y in list(zip(*curve.get_data(), strict=True))[:-120:53]:
        first, last = (lasting(RESTITUTION[k], float(x) * (1.0 - 1e-12)) for k in (0, -1))
        assert y == pytest.approx(last / first - 1.0, rel=1e-9) if first else math.isnan(y)
    durations = study.studies.restitution.table.duration
    assert limit.get_ydata()[0] == pytest.approx(durations[-1] / durations[0] - 1.0)
    key = "restitution.transition_time_increase"
    assert given.get_ydata()[0] == GIVEN.ratios[key]


def test_figure_of_shafts(study: PaperStudy) -> None:
    """Sizes of changes in per cent by inertia and speed."""
    panels = figures._drives(study).axes
    for axes, name in zip(panels, ("first_amplitude", "transition_time"), strict=True):
        assert axes.get_ylabel().endswith("[%]")
        for i, speed in enumerate(GIVEN.speeds_rpm):
            line = next(item for item in axes.lines if item.get_label() == f"{speed:g} r/min")
            size = {"first_amplitude": 3e-3, "transition_time": 5e-3}[name] / (i + 1)
            wanted = [100.0 * size / factor for factor in FACTORS]
            assert line.get_xdata() == pytest.approx(FACTORS)
            assert line.get_ydata() == pytest.approx(wanted)


def test_figure_of_the_stop(study: PaperStudy) -> None:
    """Force along the phase, the map of the least force, and the line where it is zero."""
    curve, chart = figures._stop_force(study).axes[:2]
    place = np.linspace(0.0, 1.0, len(INDEX))
    for line, speed in zip(curve.lines, GIVEN.speeds_rpm, strict=False):
        omega2 = (math.tau * speed / 60.0) ** 2
        force = 11e-3 * (9000.0 + 3000.0 * place) + 4.0 - 2.0 * place
        wanted = force + omega2 * (0.02 - 0.05 * place)
        np.testing.assert_allclose(line.get_xdata(), INDEX)
        np.testing.assert_allclose(line.get_ydata(), wanted, rtol=1e-12)
    assert chart.get_ylabel() == "preload [mm]"
    limit = next(line for line in chart.lines if line.get_label() == "lets go beyond")
    for rpm, preload in list(zip(*limit.get_data(), strict=True)):
        assert rpm == pytest.approx(threshold(1e-3 * preload), rel=1e-9)
    assert (limit.get_ydata()[0], limit.get_ydata()[-1]) == pytest.approx((5.0, 17.0))
    marks = [line for line in chart.lines if len(line.get_xdata()) == 1]
    found = [(line.get_xdata()[0], line.get_ydata()[0], line.get_marker()) for line in marks]
    assert found == [(450.0, 11.0, "s"), (550.0, 11.0, "X"), (650.0, 11.0, "X")]
    filled = next(item for item in chart.collections if isinstance(item, ContourSet))
    corners = np.concatenate([path.vertices for path in filled.get_paths()])
    x, y = corners.T
    inside = corners[(x > 401.0) & (x < 799.0) & (y > 5.01) & (y < 16.99)]
    assert len(inside) > 50
    for rpm, preload in inside:
        # Straight between places of the map: a hundredth of the step from one level to the next.
        off = np.abs(filled.levels - smallest(1e-3 * preload, rpm)).min()
        assert off < 0.01 * float(np.diff(filled.levels)[0]) + 0.2


def test_figure_of_steps(study: PaperStudy) -> None:
    """Sizes of errors over the step, one line a quantity."""
    figure = figures._fixed_step(study)
    assert figure is not None
    factors = {"first rebound time": 1.0, "second rebound time": 3.3, "first amplitude": 6.0,
               "time to rest": 9.1}  # fmt: skip
    for axes, size in zip(figure.axes, (1e-4, 3e-5), strict=True):
        lines = {line.get_label(): line for line in axes.lines}
        for label, factor in factors.items():
            assert lines[label].get_xdata() == pytest.approx(STEPS)
            assert lines[label].get_ydata() == pytest.approx(size * STEPS / 1e-6 * factor)


def test_map_of_designs(study: PaperStudy) -> None:
    """Lines of whole milliseconds and of whole indices lie where the plane has these values."""
    figure = figures._designs(study)
    panels = figure.axes[:3]
    titles = [axes.get_title().split() for axes in panels]
    assert titles == [["7", "N/mm"], ["9", "N/mm"], ["11", "N/mm"]]
    assert figure.axes[-1].get_ylabel() == "time to rest [ms]"
    for base, axes in zip((2.0, 3.0, 4.0), panels, strict=True):
        assert axes.get_xlabel() == "speed [r/min]"
        sets = [item for item in axes.collections if isinstance(item, ContourSet)]
        (times,) = (s for s in sets if not s.filled and to_hex(s.get_edgecolors()[0]) == "#000000")
        (turns,) = (s for s in sets if not s.filled and to_hex(s.get_edgecolors()[0]) != "#000000")
        checked = 0
        for lines, of_index in ((times, False), (turns, True)):
            for level, path in zip(lines.levels, lines.get_paths(), strict=True):
                for speed, e in path.vertices:
                    ms = base + 10.0 * e + 0.01 * (speed - 400.0)
                    # 40 indices a turn of 60 s by the speed; straight between places of the map.
                    value = 40.0 * ms * 1e-3 * speed / 60.0 if of_index else ms
                    assert value == pytest.approx(level, rel=1e-4)
                    checked += 1
        assert checked > 100
    found = study.durations.record()
    assert found["speed_rpm"] == [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0]
    assert found["restitution"] == pytest.approx([0.02, 0.07, 0.12, 0.17, 0.22, 0.27, 0.32])
    assert found["stiffness"] == [7e3, 9e3, 11e3]
    for base, panel in zip((2.0, 3.0, 4.0), found["duration_s"], strict=True):
        for e, row in zip(found["restitution"], panel, strict=True):
            wanted = [1e-3 * (base + 10.0 * e + 0.01 * (n - 400.0)) for n in found["speed_rpm"]]
            assert row == pytest.approx(wanted, rel=1e-12)


def test_table_and_sentences(study: PaperStudy) -> None:
    """Every ratio beside the published one with what it is off by, and how many are near."""
    off = [0.011 * k for k in range(1, len(GIVEN.ratios) + 1)]
    near, far = (sum(value <= limit for value in off) for limit in (0.04, 0.10))
    stream = io.StringIO()
    print_paper(study, Console(file=stream, width=300))
    printed = stream.getvalue()
    assert f"e62: {near} of {len(off)} within 4 %, {far} within 10 %" in printed
    rest = len(off) - 7
    assert f"e62_identified: {rest} of {len(off)} within 4 %, {len(off)} within 10 %" in printed
    assert "estimate of the E62 class identified from the published ratios" in printed
    assert "never the maker's data; that they agree with these ratios validates nothing" in printed
    assert [row[0] for row in sheet(study).rows][::4] == [
        "first rebound amplitude, 450 to 650 r/min", "share of the first two rebounds, 650 r/min",
        "first rebound amplitude, 7 to 11 N/mm",
    ]  # fmt: skip
    marked = sheet(study).markdown().splitlines()
    assert marked[2:4] == [
        "| ratio | published | ours | deviation |",
        "| --- | ---: | ---: | ---: |",
    ]
    for k, (value, row) in enumerate(zip(GIVEN.ratios.values(), sheet(study).rows, strict=True), 1):
        assert f"| {' | '.join(row)} |" in marked
        assert all(cell in printed for cell in row)
        change = 0.011 * k * (-1) ** k
        assert [float(cell.removesuffix(" %")) for cell in row[1:]] == [
            value, pytest.approx(value * (1.0 + change), rel=6e-4),
            pytest.approx(100.0 * change, abs=0.06),
        ]  # fmt: skip


def test_every_figure_says_what_its_numbers_are(study: PaperStudy) -> None:
    """An estimate, whatever is drawn; and each panel has its labels."""
    drawn: list[Figure | None] = [
        figures._thresholds(study), figures._drives(study), figures._stop_force(study),
        figures._fixed_step(study), figures._shares(study), figures._designs(study),
        figures._figure_13(study), figures._figure_14(study),
    ]  # fmt: skip
    for figure in drawn:
        assert figure is not None
        assert figure.get_supxlabel().endswith("published ratios; not the maker's data")
        assert figure.get_suptitle()
        for axes in figure.axes:
            assert axes.get_xlabel() or axes.get_label() == "<colorbar>"
            assert axes.get_ylabel()
