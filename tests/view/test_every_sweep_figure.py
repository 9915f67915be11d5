"""All that the figures of a sweep show: places, colours, scales, words, and files.

Made-up sweeps whose means have a closed form, so that every line and level is known.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.colors import to_hex
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
    parallel_coordinates,
)
from nipper_pin.view.studies.sweep_figures.tenths import tenths
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
    np.testing.assert_allclose(a.borders, [0.0, 1.0 / 6.0, 2.0 / 3.0, 1.0], rtol=1e-12)
    np.testing.assert_allclose(b.borders, [0.0, 1.0 / 6.0, 0.5, 5.0 / 6.0, 1.0], rtol=1e-12)
    np.testing.assert_array_equal(a.cell, np.repeat([0, 1, 2], 4))
    np.testing.assert_array_equal(b.cell, np.tile([0, 1, 2, 3], 3))
    for count, cells in ((12, 4), (191, 4), (300, 5), (12 * 64, 8), (12 * 24**2 * 4, 24)):
        # As many different values, each of them twice.
        x = np.tile(np.linspace(2.0, 32.0, count), 2)
        for scale in ("linear", "log"):
            table = made_up([axis("x", 2.0, 32.0, scale=scale)], x=x, y=x)
            (item,) = parameters(table)
            assert len(item.centres) == cells
            np.testing.assert_allclose(item.borders, np.linspace(0.0, 1.0, cells + 1), atol=1e-15)
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


LOW, HIGH, OTHERS = "#0072b2", "#d55e00", "#8c8c8c"


def groups_of_lines(axes: Any) -> dict[str, Array]:
    """Points of all scenarios that are drawn, by the colour of their lines."""
    return {
        to_hex(item.get_color()[0]): np.array(item.get_segments())
        for item in axes.collections if isinstance(item, LineCollection)
    }  # fmt: skip


def bars(axes: Any, place: int, colour: str) -> Array:
    """Place, width, foot and height of the bars of one colour beside an axis."""
    found = [
        (bar.get_x(), bar.get_width(), bar.get_y(), bar.get_height()) for bar in axes.patches
        if to_hex(bar.get_facecolor()) == colour and abs(bar.get_x() - place) < 0.5
    ]  # fmt: skip
    return np.array(found)


@pytest.mark.parametrize(
    ("values", "low", "high"),
    [
        # Of 101 values the tenth percentile is the 11th and the ninetieth the 91st.
        (range(101), "lowest 11 %: up to 10", "highest 11 %: from 90"),
        ([*range(51, 101), *range(51)], "lowest 11 %: up to 10", "highest 11 %: from 90"),
        # Between two values it is neither: of 100 the last ten, and of 21 the last three.
        (range(100), "lowest 10 %: up to 9", "highest 10 %: from 90"),
        (range(1000, 22_000, 1000), "lowest 14 %: up to 3000", "highest 14 %: from 19000"),
        ([-0.125 * k for k in range(11)], "lowest 18 %: up to -1.12", "highest 18 %: from -0.125"),
        # What most scenarios have in common is neither low nor high.
        ([0.0] * 95 + [1.0] * 5, "lowest 0 %: up to 0", "highest 5 %: from 1"),
        ([0.0] * 5 + [1.0] * 95, "lowest 5 %: up to 0", "highest 0 %: from 1"),
        ([5.0] * 6 + [6.0] * 9 + [7.0] * 5, "lowest 30 %: up to 5", "highest 25 %: from 7"),
        ([5.0] + [6.0] * 18 + [7.0], "lowest 5 %: up to 5", "highest 5 %: from 7"),
        ([3.0] * 20, "lowest 0 %: up to 3", "highest 0 %: from 3"),
        ([1.0] * 50 + [2.0] * 50, "lowest 50 %: up to 1", "highest 50 %: from 2"),
    ],
)  # fmt: skip
def test_tenths(values: list[float], low: str, high: str) -> None:
    """How many scenarios are in each, which ones, and what is said of them."""
    y = np.array(values, dtype=float)
    for found, words, sign in zip(tenths(y, quantity(y)), (low, high), (1.0, -1.0), strict=True):
        assert found.words == f"{words} mdeg"
        count = round(float(words.split()[1]) * len(y) / 100.0)
        inside = set(np.argsort(sign * y, kind="stable")[:count].tolist())
        assert set(np.flatnonzero(found.inside).tolist()) == inside


def test_parallel_coordinates() -> None:
    """Every scenario with a value crosses each axis at its place; the two tenths have a colour.

    Of the 11 values 100, 101, 102, 103, 200, 202, ... the tenth percentile is 101 and the ninetieth
    402: two scenarios below and two above.
    """
    table = grid()
    y = column(table)
    figure = parallel_coordinates(table, parameters(table), quantity(y))
    (axes,) = figure.axes
    assert below(figure)[0] == "Y of it: settings with low and with high values"
    assert below(figure)[1].startswith("All scenarios as lines. Bars beside an axis: ")
    assert written(axes) == [
        "lowest 18 %: up to 101 mdeg", "highest 18 %: from 402 mdeg", "all others",
    ]  # fmt: skip
    looks = [to_hex(handle.get_color()) for handle in axes.get_legend().legend_handles]
    assert looks == [LOW, HIGH, OTHERS]
    known = np.isfinite(y)
    a, b = column(table, "a")[known], column(table, "b")[known]
    y = y[known]
    size = (y - 100.0) / 303.0
    wanted = np.stack([(a - 1.0) / 3.0, np.log10(b) / 3.0, size], axis=1)
    groups = groups_of_lines(axes)
    for colour, inside in ((LOW, y <= 101.0), (HIGH, y >= 402.0), (OTHERS, abs(y - 251.5) < 150.5)):
        np.testing.assert_allclose(groups[colour][:, :, 1], wanted[inside], atol=1e-12)
        assert (groups[colour][:, :, 0] == [0.0, 1.0, 2.0]).all()
    assert sum(len(points) for points in groups.values()) == 11
    drawn = [item for item in axes.collections if isinstance(item, LineCollection)]
    assert all(item.get_rasterized() for item in drawn)
    # The grey ones lie below both others.
    order = {to_hex(item.get_color()[0]): item.get_zorder() for item in drawn}
    assert order[OTHERS] < min(order[LOW], order[HIGH])


def test_scales_of_parallel_coordinates() -> None:
    """An upright line at each place, its least value below, its largest above, a few between."""
    table = grid()
    y = column(table)
    (axes,) = parallel_coordinates(table, parameters(table), quantity(y)).axes
    upright = [line for line in axes.lines if np.ptp(line.get_ydata()) == 1.0]
    assert [line.get_xdata()[0] for line in upright] == [0.0, 1.0, 2.0]
    for place, (low, high, log) in enumerate(
        [(1e-3, 4e-3, False), (1.0, 1000.0, True), (100.0, 403.0, False)]
    ):
        foot, head = (text for text in axes.texts if text.get_position()[0] == place)
        assert float(foot.get_text()) == pytest.approx(low, rel=1e-3)
        assert float(head.get_text()) == pytest.approx(high, rel=1e-3)
        assert foot.get_position()[1] < 0.0
        assert head.get_position()[1] > 1.0
        assert (foot.get_va(), head.get_va()) == ("top", "bottom")
        inner = [text for text in axes.texts if 0.0 < place - text.get_position()[0] < 0.5]
        assert 1 <= len(inner) <= 8
        for text in inner:
            value, height = float(text.get_text()), text.get_position()[1]
            share = math.log(value / low) / math.log(high / low) if log else (value - low) / (
                high - low
            )  # fmt: skip
            assert height == pytest.approx(share, abs=1e-9)
            assert 0.08 < height < 0.92
    labels = [text.get_text() for text in axes.get_xticklabels()]
    assert [re.sub(r"\s+", " ", text) for text in labels] == [
        "rate of spring a [N/mm]", "b", "y of it [mdeg]",
    ]  # fmt: skip
    assert max(len(line) for text in labels for line in text.splitlines()) <= 17
    assert list(axes.get_xticks()) == [0.0, 1.0, 2.0]
    assert len(axes.get_yticks()) == 0
    assert axes.get_xlim()[0] < 0.0
    assert axes.get_xlim()[1] > 2.0
    assert axes.get_ylim()[0] < 0.0
    assert axes.get_ylim()[1] > 1.0


def test_bars_beside_parallel_coordinates() -> None:
    """Which share of a cell belongs to each tenth, counted by hand; all scenarios on the last axis.

    Of a = 1 two of four are low, of a = 4 two of four high; of b = 1 one of three is low, of 10 one
    of two, of 100 and 1000 one of three high. The largest share, a half, is 0.3 wide.
    """
    table = grid()
    y = column(table)
    (axes,) = parallel_coordinates(table, parameters(table), quantity(y)).axes
    borders = ([0.0, 1.0 / 6.0, 2.0 / 3.0, 1.0], [0.0, 1.0 / 6.0, 0.5, 5.0 / 6.0, 1.0])
    shares = (
        ([1.0 / 2.0, 0.0, 0.0], [0.0, 0.0, 1.0 / 2.0]),
        ([1.0 / 3.0, 1.0 / 2.0, 0.0, 0.0], [0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0]),
    )
    for place in (0, 1):
        for colour, side, share in zip((LOW, HIGH), (-1.0, 1.0), shares[place], strict=True):
            x, width, foot, height = bars(axes, place, colour).T
            np.testing.assert_array_equal(x, place)
            np.testing.assert_allclose(width, side * 0.6 * np.array(share), atol=1e-12)
            np.testing.assert_allclose(foot, borders[place][:-1], atol=1e-12)
            np.testing.assert_allclose(height, np.diff(borders[place]), atol=1e-12)
    # 100 to 103 lie in the first of 40 equal parts of 100 to 403, 400 to 403 in the last.
    low, others, high = (bars(axes, 2, colour) for colour in (LOW, OTHERS, HIGH))
    assert low[0, 1] == pytest.approx(0.3 * 2 / 4)
    assert others[0, :2] == pytest.approx((2.0 + 0.3 * 2 / 4, 0.3 * 2 / 4))
    assert high[-1, :2] == pytest.approx((2.0 + 0.3 * 2 / 4, 0.3 * 2 / 4))
    assert sum(part[:, 1].sum() for part in (low, others, high)) == pytest.approx(0.3 * 11 / 4)


def test_of_many_scenarios_fifteen_hundred_are_drawn() -> None:
    """Different ones, from all over the sweep, and of one value a line half-way."""
    x = np.linspace(0.0, 1.0, 4000)
    table = made_up([axis("x", 0.0, 1.0), axis("k", 5.0, 5.0)], x=x, k=np.full(4000, 5.0), y=x * x)
    figure = parallel_coordinates(table, parameters(table), quantity(x * x))
    drawn = np.concatenate(list(groups_of_lines(figure.axes[0]).values()))[:, :, 1]
    assert below(figure)[1].startswith("1,500 scenarios as lines. Bars")
    # The bars are of all of them: a tenth of 4,000; 18 cells have 222 or 223 each.
    x, width, _, height = bars(figure.axes[0], 0, LOW).T
    assert (width * height).sum() == pytest.approx(-0.3 * 400.0 / 4000.0, rel=1.0 / 222.0)
    assert len(np.unique(drawn[:, 0])) == 1500
    np.testing.assert_allclose(drawn[:, 2], drawn[:, 0] ** 2, atol=1e-9)
    np.testing.assert_array_equal(drawn[:, 1], 0.5)
    # A share of 0.375 of each tenth, by chance within 5 standard deviations.
    share = np.histogram(drawn[:, 0], 10, (0.0, 1.0))[0] / 400.0
    assert np.abs(share - 0.375).max() < 5.0 * math.sqrt(0.375 * 0.625 / 400.0)


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
    """For each quantity three files in their format and folder; the first one without a choice."""
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
    for name in ("main_effects", "parallel_coordinates"):
        monkeypatch.setattr(sweep_plots, name, lambda *_: Figure())
    found = plot_sweep(tmp_path / "sweep")
    home = tmp_path / "sweep" / "plots"
    subjects = ("main_effects", "parallel", "level_lines")
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
    assert len(list((tmp_path / "here").iterdir())) == 9
