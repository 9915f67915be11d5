"""Bands of main effects and tables of a benchmark, with numbers that differ in every place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
from matplotlib.collections import PolyCollection

from benchmarks.run_time.work_precision import Row
from benchmarks.views import benchmark_report
from nipper_pin.study.sweep import SweepTable
from nipper_pin.view.studies.sweep_figures.columns import Parameter, Quantity
from nipper_pin.view.studies.sweep_figures.main_effects import main_effects


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
