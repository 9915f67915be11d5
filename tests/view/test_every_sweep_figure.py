"""All that the figures of a sweep show: places, colours, scales, words, and files.

Made-up sweeps whose means have a closed form, so that every line and level is known.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure

from nipper_pin import InputError, UnknownNameError
from nipper_pin.study.sweep import SweepTable
from nipper_pin.terms import Shown
from nipper_pin.view.studies import sweep_plots
from nipper_pin.view.studies.sweep_figures import (
    Parameter,
    Quantity,
    level_lines,
    main_effects,
)
from nipper_pin.view.studies.sweep_plots import plot_sweep

Array = Any


def axis(name: str, low: float, high: float, **more: object) -> dict[str, object]:
    return {"name": name, "path": name, "low": low, "high": high, "scale": "linear", "values": [],
            **more}  # fmt: skip


def made_up(axes: list[dict[str, object]], **columns: Array) -> SweepTable:
    n = len(next(iter(columns.values())))
    return SweepTable(
        title="a title", model="a model", axes=tuple(axes), quantities=("y", "z"), scenarios=3 * n,
        stored=2 * n, table=pa.table({"collisions": np.arange(n), **columns}),
    )  # fmt: skip


def quantity(values: Array) -> Quantity:
    """One in the unit of its values."""
    return Quantity(name="y", shown=Shown(words="y of it", unit="mdeg"), values=values)


def grid() -> SweepTable:
    """y = 100 a + log10(b) on a grid of 3 by 4, with one value missing; z is y backwards."""
    a, b = np.meshgrid([1.0, 2.0, 4.0], [1.0, 10.0, 100.0, 1000.0], indexing="ij")
    y = (100.0 * a + np.log10(b)).ravel()
    y[5] = np.nan
    return made_up(
        [axis("a", 1.0, 4.0, values=[1.0, 2.0, 4.0], path="springs.a.rate_N_per_m"),
         axis("b", 1.0, 1e3, values=[1.0, 10.0, 100.0, 1e3], scale="log")],
        a=a.ravel(), b=b.ravel(), y=y, z=y[::-1],
    )  # fmt: skip


def parameters(table: SweepTable) -> list[Parameter]:
    return [Parameter.of(table, place) for place in range(len(table.axes))]


def column(table: SweepTable, name: str = "y") -> Array:
    return np.array(table.table[name].to_numpy(), dtype=float)


def below(figure: Figure) -> list[str]:
    """The title, and the lines below the figure."""
    return [figure.get_suptitle(), *figure.get_supxlabel().splitlines()]


def written(axes: Any) -> list[str]:
    """Entries of a legend."""
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_parameters_and_their_cells() -> None:
    """Values of a grid are cells of their own; samples have 4 to 24 of about twelve values.

    Cells divide the range evenly, on a logarithmic scale by equal ratios.
    """
    a, b = parameters(grid())
    assert (a.name, a.shown.label, a.log) == ("a", "rate of spring a [N/mm]", False)
    assert (b.shown.label, b.log) == ("b", True)
    assert (a.grid, b.grid) == (True, True)
    np.testing.assert_allclose(a.centres, [1e-3, 2e-3, 4e-3], rtol=1e-15)
    np.testing.assert_allclose(a.x, 1e-3 * column(grid(), "a"), rtol=1e-15)
    assert a.ends == pytest.approx((1e-3, 4e-3), rel=1e-15)
    np.testing.assert_array_equal(a.cell, np.repeat([0, 1, 2], 4))
    np.testing.assert_array_equal(b.cell, np.tile([0, 1, 2, 3], 3))
    for count, cells in ((12, 4), (191, 4), (300, 5), (12 * 64, 8), (12 * 24**2 * 4, 24)):
        # As many different values, each of them twice.
        x = np.tile(np.linspace(2.0, 32.0, count), 2)
        for scale in ("linear", "log"):
            table = made_up([axis("x", 2.0, 32.0, scale=scale)], x=x, y=x)
            (item,) = parameters(table)
            assert len(item.centres) == cells
            edges = np.linspace(2.0, 32.0, cells + 1)
            middle = 0.5 * (edges[1:] + edges[:-1])
            if scale == "log":
                edges = np.geomspace(2.0, 32.0, cells + 1)
                middle = np.sqrt(edges[1:] * edges[:-1])
            np.testing.assert_allclose(item.centres, middle, rtol=1e-12)
            for cell in range(cells):
                inside = item.x[item.cell == cell]
                assert inside.min() >= edges[cell] * (1.0 - 1e-12)
                assert inside.max() <= edges[cell + 1] * (1.0 + 1e-12)
            assert item.cell.max() == cells - 1


def test_main_effects() -> None:
    """A panel for each parameter, two in a row, with its scale and label, all by one axis."""
    table = grid()
    y = column(table)
    figure = main_effects(table, parameters(table), quantity(y))
    assert below(figure)[0] == "Y of it: how it changes with each parameter"
    assert written(figure.axes[0]) == ["middle 80 % of the scenarios", "mean of the scenarios"]
    for axes, name, label, scale, unit in zip(
        figure.axes, "ab", ("rate of spring a [N/mm]", "b"), ("linear", "log"), (1e-3, 1.0),
        strict=True,
    ):  # fmt: skip
        x = unit * column(table, name)
        assert (axes.get_xlabel(), axes.get_xscale()) == (label, scale)
        (line,) = axes.get_lines()
        np.testing.assert_array_equal(line.get_xdata(), np.unique(x))
        (band,) = [item for item in axes.collections if isinstance(item, PolyCollection)]
        corners = band.get_paths()[0].vertices
        for value, mean in zip(np.unique(x), line.get_ydata(), strict=True):
            part = y[(x == value) & np.isfinite(y)]
            assert mean == pytest.approx(part.mean(), rel=1e-12)
            edges = corners[corners[:, 0] == value, 1]
            ends = [edges.min(), edges.max()]
            assert ends == pytest.approx(np.percentile(part, [10, 90]), rel=1e-12)
    assert [axes.get_ylabel() for axes in figure.axes] == ["y of it [mdeg]", ""]
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()
    places = [axes.get_subplotspec().rowspan.start for axes in figure.axes]
    assert places == [0, 0]
    # An odd one leaves a place empty; one alone has the whole width.
    more = main_effects(table, [*parameters(table), parameters(table)[0]], quantity(y))
    assert [axes.axison for axes in more.axes] == [True, True, True, False]
    assert [axes.get_ylabel() for axes in more.axes[:3]] == ["y of it [mdeg]", "", "y of it [mdeg]"]
    assert more.get_figheight() > figure.get_figheight()
    assert len(main_effects(table, parameters(table)[:1], quantity(y)).axes) == 1


def test_level_lines() -> None:
    """Levels over both parameters, upright where their values say so, filled and labelled."""
    table = grid()
    y = column(table)
    y[5] = 201.0
    figure = level_lines(table, *parameters(table), quantity(y))
    axes, bar = figure.axes
    assert below(figure)[0] == "Y of it over rate of spring a and b"
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "log")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("rate of spring a [N/mm]", "b")
    assert bar.get_ylabel() == "y of it [mdeg]"
    filled, lines = [item for item in axes.collections if isinstance(item, QuadContourSet)]
    assert filled.filled
    assert not lines.filled
    np.testing.assert_array_equal(filled.levels, lines.levels)
    assert 5 <= len(filled.levels) <= 10
    assert (filled.zmin, filled.zmax) == (y.min(), y.max())
    # Between two values of a the mean goes evenly from 100 a to the next, and b adds up to 3.
    checked = 0
    for level, path in zip(lines.levels, lines.get_paths(), strict=True):
        for a, b in path.vertices:
            cell = np.searchsorted([1.0, 10.0, 100.0, 1000.0], b, side="right") - 1
            low, high = 10.0 ** min(cell, 2), 10.0 ** min(cell + 1, 3)
            wanted = 100.0 * 1e3 * a + math.log10(low) + (b - low) / (high - low)
            assert level == pytest.approx(wanted, abs=1.1)
            checked += 1
    # Every level between the least and the largest value is a line.
    inner = int(np.count_nonzero((lines.levels > y.min()) & (lines.levels < y.max())))
    assert inner >= 5
    assert checked >= 2 * inner
    # Levels are labelled with their own values.
    assert {float(text.get_text()) for text in axes.texts} <= set(lines.levels)
    assert axes.texts
    # Turned round, both axes with their scales change places.
    other = level_lines(table, *parameters(table)[::-1], quantity(y)).axes[0]
    assert (other.get_xscale(), other.get_yscale()) == ("log", "linear")
    assert other.get_xlim() == axes.get_ylim()


@pytest.mark.parametrize(
    "y", [np.full(12, 7.0), np.where(np.arange(12) < 2, np.arange(12.0), np.nan)]
)
def test_a_field_without_levels_is_shown_by_its_cells(y: Array) -> None:
    """One value everywhere, or two alone."""
    table = grid()
    axes = level_lines(table, *parameters(table), quantity(y)).axes[0]
    (mesh,) = axes.collections
    assert isinstance(mesh, QuadMesh)
    found = np.ma.filled(mesh.get_array(), np.nan).reshape(4, 3)
    np.testing.assert_array_equal(found, y.reshape(3, 4).T)
    single = made_up(
        [axis("a", 1.0, 1.0, values=[1.0]), axis("b", 1.0, 4.0, values=[1.0, 2.0, 4.0])],
        a=np.ones(3), b=np.array([1.0, 2.0, 4.0]), y=np.arange(3.0),
    )  # fmt: skip
    axes = level_lines(single, *parameters(single), quantity(np.arange(3.0))).axes[0]
    assert isinstance(axes.collections[0], QuadMesh)


def test_what_stands_above() -> None:
    """What it is of, title and model, how many scenarios are there, taken and without value."""
    table = grid()
    y = column(table)
    lines = below(level_lines(table, *parameters(table), quantity(y)))
    assert lines == [
        "Y of it over rate of spring a and b", "a title", "a model",
        "24 of 36 scenarios, 12 of them taken, 1 of them without a value",
    ]  # fmt: skip
    whole = made_up(list(table.axes), a=column(table, "a"), b=column(table, "b"), y=y)
    object.__setattr__(whole, "stored", 12)
    object.__setattr__(whole, "title", "")
    y[5] = 0.0
    lines = below(main_effects(whole, parameters(whole), quantity(y)))
    assert lines[1:] == ["a model", "12 of 36 scenarios"]
    object.__setattr__(whole, "scenarios", 12)
    lines = below(main_effects(whole, parameters(whole), quantity(y)))
    assert lines[1:] == ["a model", "12 scenarios"]
    means = "Every value is the mean of the scenarios near it, whatever their other parameters."
    third = made_up([*table.axes, axis("c", 1.0, 1.0, values=[1.0])], a=column(table, "a"),
                    b=column(table, "b"), c=np.ones(12), y=y)  # fmt: skip
    sampled = made_up([table.axes[0], axis("b", 1.0, 1e3, scale="log")], a=column(table, "a"),
                      b=column(table, "b"), y=y)  # fmt: skip
    for other in (third, sampled):
        assert below(level_lines(other, *parameters(other)[:2], quantity(y)))[1] == means


def test_quantities_in_units_for_people() -> None:
    """Seconds as ms, rebounds in rad as mdeg and in m as um, shares in per cent: by hand."""
    values = np.array([0.25, np.nan])
    for name, unit, label, factor in (
        ("duration_s", b"s", "time to rest [ms]", 1e3),
        ("rebound_amplitude_1", b"rad", "first rebound amplitude [mdeg]", 180e3 / math.pi),
        ("rebound_amplitude_1", b"m", "first rebound amplitude [um]", 1e6),
        ("clamped_share", b"1", "share of the turn clamped [%]", 100.0),
    ):
        field = pa.field(name, pa.float64(), metadata={b"unit": unit})
        table = pa.table([pa.array(values)], schema=pa.schema([field]))
        sweep = SweepTable(title="", model="", axes=(), quantities=(name,), scenarios=2, stored=2,
                           table=table)  # fmt: skip
        found = Quantity.of(sweep, name)
        assert found.shown.label == label
        np.testing.assert_allclose(found.values, factor * values, rtol=1e-12)


def test_indices_of_figures_count_on_and_are_written_on_one_scale() -> None:
    """The mean of 39.5 and 0.5 is 40, which is written 0."""
    table = pa.table({"rest_index": [39.5, 0.5, 30.0]})
    sweep = SweepTable(title="", model="", axes=(), quantities=("rest_index",), scenarios=3,
                       stored=3, table=table)  # fmt: skip
    found = Quantity.of(sweep, "rest_index")
    assert found.values.tolist() == [39.5, 40.5, 30.0]
    assert [found.short(value) for value in (39.5, 40.5, 40.0)] == ["39.5", "0.5", "0"]


def test_which_figures_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For each quantity two files in their format and folder; the first one without a choice."""
    read: list[tuple[Any, ...]] = []
    drawn: list[tuple[str, str]] = []
    table = grid()

    def read_sweep(*arguments: Any) -> SweepTable:
        read.append(arguments)
        return table

    def levels(_sweep: Any, across: Parameter, upwards: Parameter, *_: Any) -> Figure:
        drawn.append((across.name, upwards.name))
        return Figure()

    monkeypatch.setattr(sweep_plots, "read_sweep", read_sweep)
    monkeypatch.setattr(sweep_plots, "level_lines", levels)
    monkeypatch.setattr(sweep_plots, "main_effects", lambda *_: Figure())
    found = plot_sweep(tmp_path / "sweep")
    home = tmp_path / "sweep" / "plots"
    subjects = ("main_effects", "level_lines")
    assert found == [home / f"{item}_y.svg" for item in subjects]
    assert all(b"<svg" in path.read_bytes() for path in found)
    assert read == [(tmp_path / "sweep", 1_000_000)]
    found = plot_sweep(
        "sweep", quantities=["z", "collisions"], across="b", kind="png", target=tmp_path / "here"
    )
    assert found == [
        tmp_path / "here" / f"{item}_{name}.png" for name in ("z", "collisions")
        for item in subjects
    ]  # fmt: skip
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in found)
    plot_sweep("sweep", upwards="a", target=tmp_path / "here")
    assert drawn == [("a", "b"), ("b", "a"), ("b", "a"), ("b", "a")]
    with pytest.raises(UnknownNameError, match="no quantity named 'w'"):
        plot_sweep("sweep", quantities=["w"], target=tmp_path / "here")
    table = made_up(list(table.axes), a=column(table, "a"), b=column(table, "b"),
                    y=np.full(12, np.nan))  # fmt: skip
    with pytest.raises(InputError, match="no scenario has a value of y; see the column message"):
        plot_sweep("sweep", target=tmp_path / "here")
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is not a folder"):
        plot_sweep("sweep", target=tmp_path / "file")
    assert len(list((tmp_path / "here").iterdir())) == 6
