"""Every number of the benchmark's costs, tables and figure, with a clock that is made up.

Times are what the made-up clock says, counts are those of the machines in closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from benchmarks.run_time import certified, cost, turns
from benchmarks.run_time.benchmark import Benchmark
from benchmarks.run_time.certified import certified_cycle
from benchmarks.run_time.timing import Timing
from benchmarks.run_time.work_precision import Row
from benchmarks.views import benchmark_report
from benchmarks.views.work_precision_plot import work_precision_figure
from nipper_pin import Case, InputError, Mechanism, Window, simulate

MEDIAN, FASTEST = 12.0, 7.0


@pytest.fixture(name="clock")
def made_up_clock(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Every run takes 12 ms by the median and 7 ms at best; what is run is kept."""
    kept: list[Any] = []

    def timed(function: Callable[[], object], repeats: int, _budget_s: float = 1.0) -> Timing:
        kept.append(function())
        return Timing(90.0, MEDIAN, FASTEST, 3.0, repeats)

    monkeypatch.setattr(cost, "timed", timed)
    return kept


def test_turns_with_and_without_reuse(clock: list[Any], e62: Mechanism) -> None:
    """Each count of turns once in each way; both times are told by their name."""
    rows = cost.turn_cost(e62, (1, 2), 3, 0.1)
    assert [row["turns"] for row in rows] == [1, 2]
    assert set(rows[0]) == {"turns", "reuse_ms", "no_reuse_ms"}
    cases = [(run.case.cycles, run.case.reuse_cycles, run.case.window) for run in clock]
    assert cases == [
        (1, True, Window.CYCLE), (1, False, Window.CYCLE),
        (2, True, Window.CYCLE), (2, False, Window.CYCLE),
    ]  # fmt: skip


def test_chains_of_four_bars(clock: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """N four-bars have 2 N + 1 links and N cut pins; evaluations in microseconds."""
    monkeypatch.setattr(cost, "_evaluation_ms", lambda mechanism: 0.25 * len(mechanism.closures))
    rows = cost.link_cost((1, 2), 3, 0.1)
    for row, count, runs in zip(rows, (1, 2), (clock[:2], clock[2:]), strict=True):
        assert (row["four_bars"], row["links"], row["cut_pins"]) == (count, 2 * count + 1, count)
        assert len(runs[0].mechanism.joints) == 2 * count + 1
        assert row["evaluation_us"] == 250.0 * count
        for run, drive in zip(runs, ("held", "inertial"), strict=True):
            assert run.case.drive.value == drive
            assert row[f"{drive}_ms"] == MEDIAN
            assert row[f"{drive}_evaluations"] == run.evaluations
            assert row[f"{drive}_energy_balance"] == run.checks.energy_balance


def test_one_evaluation(clock: list[Any]) -> None:
    """The time of a batch by the number of its states, along the turn, with nothing closed."""
    chain = cost.four_bar_chain(1)
    assert cost._evaluation_ms(chain, states=20) == MEDIAN / 20.0
    turn = simulate(chain, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    times, system = np.linspace(*turn.trajectory.span, 20), turn.system
    states, phase = turn.trajectory.evaluate(times), system.constraint_set(frozenset())
    found = system.accelerations(system.shaft.driven(times), states.q, states.v, phase)
    np.testing.assert_array_equal(clock[-1][0], found[0])


def test_errors_of_a_turn() -> None:
    """The certified turn against itself, a collision of the second series later and harder.

    A series that one has further than the other is compared as far as both have it.
    """
    rows = certified_cycle("650")
    stops = [row["stop"] for row in rows]
    times = np.array([float(row["time_s"]) for row in rows])
    impulses = np.array([float(row.get("impulse_lip_N_s", row["impulse"])) for row in rows])
    assert turns._errors("650", stops, times, impulses) == (0.0, 0.0)
    place = next(n for n, stop in enumerate(stops) if stop != stops[0])
    late, hard = times.copy(), impulses.copy()
    late[place] += 1e-5
    hard[place] *= 1.001
    time, impulse = turns._errors("650", stops[:-1], late[:-1], hard[:-1])
    assert time == pytest.approx(1e-5 * 650.0 / 60.0, rel=1e-6)
    assert impulse == pytest.approx(1e-3, rel=1e-6)


# Tables and figure.


def made_up() -> Benchmark:
    """A benchmark whose numbers all differ."""
    row = Row("direct", "1e-12", 3.25, 9.0, 2.5, 0.1, 30, 2e-13, 7e-13, evaluations=212)
    rows = (
        row,
        Row("direct", "1e-8", 1.25, 8.0, 1.0, 0.2, 30, 3e-9, 5e-9, evaluations=112),
        Row("direct", "none", 1.0, 8.0, 0.5, 0.2, 30, None, None, evaluations=9),
    )
    peers = (
        Row("a peer (by hand)", "1e-6", 50.0, 99.0, 40.0, 5.0, 30, 2e-5, 4e-5, evaluations=999),
        Row("a peer (by hand)", "0", 60.0, 99.0, 45.0, 5.0, 30, 0.0, 0.0, evaluations=999),
    )
    names = ("turns", "links")
    return Benchmark(
        quick=True,
        environment={
            "date": "2026-01-02T03:04:05", "platform": "here", "processor": "chip", "cores": 6,
            "cores_allowed": 5, "load_average": [1.25, 2.5, 3.5], "python": "3.11.9",
            "threads": {"OMP_NUM_THREADS": None, "MKL_NUM_THREADS": "3"},
            "versions": {"numpy": "2.1", "pin": "3.2"},
        },
        engines=rows, accuracy=(row,), peers=peers,
        unavailable=("a peer: no bounce",),
        reduced={"build_ms": 812.5, "error": 4.5e-13}, turns=(),
        cost={name: [{"what": f"{name} {row}", "wall_ms": 10.0 * place + row, "small": 1e-7 * row,
                      "none": None, "count": 1000 * row}
                     for row in (1, 2)]
              for place, name in enumerate(names)},
    )  # fmt: skip


def test_sheets_of_costs() -> None:
    """Rows of each part under its own title; the machine above."""
    result = made_up()
    found = {sheet.title: sheet for sheet in benchmark_report.sheets(result)}
    titles = {
        "turns": "Growth with the number of turns at 650 r/min",
        "links": "Growth with the number of links: chain of N four-bars, one turn",
    }
    for place, (name, title) in enumerate(titles.items()):
        sheet = found[title]
        assert sheet.headings == ("what", "wall ms", "small", "none", "count")
        for row, cells in zip((1, 2), sheet.rows, strict=True):
            assert cells[0] == f"{name} {row}"
            assert float(cells[1]) == 10.0 * place + row
            assert float(cells[2]) == 1e-7 * row
            assert cells[3:] == ("-", str(1000 * row))
    assert found["Reduced engine"].rows == (("build_ms", "812"), ("error", "4.5e-13"))
    head = benchmark_report.header(result)
    assert head == [
        "2026-01-02T03:04:05, quick run",
        "here, chip, 6 cores (5 allowed), load 1.25",
        "Python 3.11.9, numpy 2.1, pin 3.2",
        "threads: OMP_NUM_THREADS not set, MKL_NUM_THREADS 3",
    ]
    text = benchmark_report.markdown(result)
    for sheet in found.values():
        for cells in (sheet.headings, *sheet.rows):
            assert f"| {' | '.join(cells)} |" in text


def test_figure_of_work_against_precision() -> None:
    """The fastest time over the worst error, one line for each solver that has an answer."""
    figure = work_precision_figure(made_up())
    (axes,) = figure.axes
    lines = [tuple(map(tuple, zip(*line.get_data(), strict=True))) for line in axes.lines]
    assert lines == [((7e-13, 2.5), (5e-9, 1.0)), ((4e-5, 40.0), (1e-16, 45.0))]
    assert "largest relative error" in axes.get_xlabel()
    assert axes.get_ylabel() == "computing time [ms]"
    assert "fastest of the repeats" in axes.get_title()
    assert axes.get_xlim()[0] > axes.get_xlim()[1]
    (legend,) = figure.legends
    assert [item.get_text() for item in legend.get_texts()] == [
        "nipper_pin, direct engine", "a peer",
    ]  # fmt: skip
    assert "2026-01-02" in axes.get_title()
    assert math.isfinite(axes.get_ylim()[1])


def test_a_reference_that_is_missing() -> None:
    with pytest.raises(InputError, match=r"nothing\.json is missing: get the checkout") as caught:
        certified._document("nothing.json")
    assert caught.value.evidence == {"file": "nothing.json"}
