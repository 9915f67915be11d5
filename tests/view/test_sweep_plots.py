"""Figures of a sweep: what they average, and that they show what is in the table.

Made-up sweeps whose means have a closed form, and a real one; what stands around the curves are
reviewed texts of both.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyarrow as pa
import pytest
from drawn import drawn
from matplotlib.collections import PolyCollection
from matplotlib.contour import QuadContourSet
from snapshots import Words

from nipper_pin import InputError, UnknownNameError, read_sweep
from nipper_pin.cli import main
from nipper_pin.study.sweep import SweepTable, read_plan, sweep
from nipper_pin.view.studies.sweep_plots import (
    Parameter,
    Quantity,
    level_lines,
    main_effects,
    plot_sweep,
)

Array = Any
STUDY = """
format = 1
title = "Three parameters"
quantities = ["duration_s", "rebound_amplitude_1"]
[parameters]
speed_rpm = { low = 450.0, high = 650.0, points = 3 }
restitution = { low = 0.05, high = 0.2, points = 3, scale = "log" }
"links.top_nipper.mass_kg" = { values = [1.2, -1.0] }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep with every second scenario marked: a link of negative mass."""
    home = tmp_path_factory.mktemp("sweep")
    file = home / "study.toml"
    file.write_text(STUDY, encoding="utf-8")
    sweep(read_plan(str(file)), home / "out", workers=1)
    return home / "out"


def axis(name: str, low: float, high: float, **more: object) -> dict[str, object]:
    return {"name": name, "path": name, "low": low, "high": high, "scale": "linear", "values": [],
            **more}  # fmt: skip


def made_up(axes: list[dict[str, object]], **columns: Array) -> SweepTable:
    n = len(next(iter(columns.values())))
    return SweepTable(
        title="a title", model="a model", axes=tuple(axes), quantities=("y",), scenarios=3 * n,
        stored=2 * n, table=pa.table(columns),
    )  # fmt: skip


def grid(y: Array | None = None) -> SweepTable:
    """y = 100 a + log10(b) on a grid of 3 by 4, with one value missing, or other values."""
    a, b = np.meshgrid([1.0, 2.0, 4.0], [1.0, 10.0, 100.0, 1000.0], indexing="ij")
    if y is None:
        y = (100.0 * a + np.log10(b)).ravel()
        y[5] = np.nan
    return made_up(
        [axis("a", 1.0, 4.0, values=[1.0, 2.0, 4.0], path="springs.a.rate_N_per_m"),
         axis("b", 1.0, 1e3, values=[1.0, 10.0, 100.0, 1e3], scale="log")],
        a=a.ravel(), b=b.ravel(), y=y,
    )  # fmt: skip


def parameters(table: SweepTable) -> list[Parameter]:
    return [Parameter.of(table, place) for place in range(len(table.axes))]


def column(table: SweepTable, name: str = "y") -> Array:
    return np.array(table.table[name].to_numpy(), dtype=float)


def lines_of(table: SweepTable, *places: int) -> Any:
    """Level lines over two of its parameters."""
    found = parameters(table)
    return level_lines(table, *(found[place] for place in places or (0, 1)), y_of(table))


def y_of(table: SweepTable) -> Quantity:
    return Quantity.of(table, "y")


def test_parameters_and_their_cells() -> None:
    """Values of a grid are cells of their own; samples have 4 to 24 of about twelve values.

    Cells divide the range evenly, on a logarithmic scale by equal ratios.
    """
    a, b = parameters(grid())
    assert (a.name, a.shown.label, a.log) == ("a", "rate of spring a [N/mm]", False)
    assert (b.shown.label, b.log) == ("b", True)
    assert (a.grid, b.grid) == (True, True)
    np.testing.assert_allclose(a.centres, [1e-3, 2e-3, 4e-3], rtol=1e-15)
    np.testing.assert_array_equal(a.cell, np.repeat([0, 1, 2], 4))
    np.testing.assert_array_equal(b.cell, np.tile([0, 1, 2, 3], 3))
    for count, cells in ((12, 4), (191, 4), (300, 5), (12 * 64, 8), (12 * 24**2 * 4, 24)):
        # As many different values, each of them twice.
        x = np.tile(np.linspace(2.0, 32.0, count), 2)
        for scale, space in (("linear", np.linspace), ("log", np.geomspace)):
            (item,) = parameters(made_up([axis("x", 2.0, 32.0, scale=scale)], x=x, y=x))
            # Edges and middles of cells, one after the other.
            places = space(2.0, 32.0, 2 * cells + 1)
            np.testing.assert_allclose(item.centres, places[1::2], rtol=1e-12)
            low, high = (places[0:-1:2] * (1.0 - 1e-12), places[2::2] * (1.0 + 1e-12))
            assert (x >= low[item.cell]).all()
            assert (x <= high[item.cell]).all()
            assert set(item.cell) == set(range(cells))


def test_bands_of_main_effects() -> None:
    """At every value the mean as a line and the 10th to 90th per cent of scenarios as a band.

    Values that are not finite are left out.
    """
    random = np.random.default_rng(3)
    x = np.repeat([1.0, 2.0, 4.0], 44)
    y = x**2 + random.exponential(size=len(x))
    y[::15] = np.nan
    table = made_up([axis("k", 1.0, 4.0, values=[1.0, 2.0, 4.0])], k=x, y=y)
    (axes,) = main_effects(table, parameters(table), y_of(table)).axes
    (line,) = axes.get_lines()
    (band,) = [item for item in axes.collections if isinstance(item, PolyCollection)]
    corners = {tuple(np.round(row, 9)) for row in band.get_paths()[0].vertices}
    for value, mean in zip([1.0, 2.0, 4.0], line.get_ydata(), strict=True):
        part = sorted(y[(x == value) & np.isfinite(y)])
        assert len(part) == 41
        assert mean == pytest.approx(sum(part) / 41.0, rel=1e-12)
        # Of 41 sorted values the 5th and the 37th lie at a tenth and at nine tenths.
        for edge in (part[4], part[36]):
            assert (round(value, 9), round(float(edge), 9)) in corners


def test_level_lines_are_where_their_value_is() -> None:
    """Between two values of a the mean goes evenly from 100 a to the next, and b adds up to 3.

    Of three values in each cell the mean is that; a fourth one is missing.
    """
    once = grid(100.0 * np.repeat([1.0, 2.0, 4.0], 4) + np.tile([0.0, 1.0, 2.0, 3.0], 3))
    a, b, y = (column(once, name) for name in "aby")
    values = np.concatenate([y - 40.0, y + 50.0, y - 10.0, np.nan * y])
    table = made_up(list(once.axes), a=np.tile(a, 4), b=np.tile(b, 4), y=values)
    axes = lines_of(table).axes[0]
    _, lines = [item for item in axes.collections if isinstance(item, QuadContourSet)]
    checked = 0
    for level, path in zip(lines.levels, lines.get_paths(), strict=True):
        for a, b in path.vertices:
            cell = np.searchsorted([1.0, 10.0, 100.0, 1000.0], b, side="right") - 1
            low, high = 10.0 ** min(cell, 2), 10.0 ** min(cell + 1, 3)
            wanted = 100.0 * 1e3 * a + math.log10(low) + (b - low) / (high - low)
            assert level == pytest.approx(wanted, abs=1.1)
            checked += 1
    inner = int(np.count_nonzero((lines.levels > y.min()) & (lines.levels < y.max())))
    assert inner >= 5
    assert checked >= 2 * inner


def sampled() -> SweepTable:
    """One parameter of a grid and one whose values are drawn."""
    a = np.repeat([1.0, 2.0, 4.0], 40)
    b = np.tile(np.geomspace(1.0, 1e3, 40), 3)
    axes = [axis("a", 1.0, 4.0, values=[1.0, 2.0, 4.0]), axis("b", 1.0, 1e3, scale="log")]
    return made_up(axes, a=a, b=b, y=a * np.log10(b))


# One value everywhere, two alone, and one value of a parameter have no levels, but cells.
MADE_UP = {
    "effects": lambda: main_effects(grid(), parameters(grid()), y_of(grid())),
    "effects of three": lambda: main_effects(
        grid(), [*parameters(grid()), parameters(grid())[0]], y_of(grid())
    ),
    "effects of one": lambda: main_effects(grid(), parameters(grid())[:1], y_of(grid())),
    "levels": lambda: lines_of(grid()),
    "levels turned": lambda: lines_of(grid(), 1, 0),
    "levels of samples": lambda: lines_of(sampled()),
    "one value": lambda: lines_of(grid(np.full(12, 7.0))),
    "two values": lambda: lines_of(grid(np.where(np.arange(12) < 2, np.arange(12.0), np.nan))),
}


@pytest.mark.parametrize("name", MADE_UP)
def test_made_up_figures(name: str, words: Words) -> None:
    words(drawn(MADE_UP[name]()))


@pytest.mark.parametrize("name", ["duration_s", "rebound_amplitude_1"])
def test_figures_of_a_sweep(folder: Path, name: str, words: Words) -> None:
    """Both for both quantities; they say what is missing from them."""
    sweep = read_sweep(folder)
    found, quantity = parameters(sweep), Quantity.of(sweep, name)
    figures = main_effects(sweep, found, quantity), level_lines(sweep, *found[:2], quantity)
    words("\n".join(drawn(figure) for figure in figures))


def test_indices_of_figures_count_on_and_are_written_on_one_scale() -> None:
    """The mean of 39.5 and 0.5 is 40, which is written 0."""
    table = pa.table({"rest_index": [39.5, 0.5, 30.0]})
    sweep = SweepTable(title="", model="", axes=(), quantities=("rest_index",), scenarios=3,
                       stored=3, table=table)  # fmt: skip
    found = Quantity.of(sweep, "rest_index")
    assert found.values.tolist() == [39.5, 40.5, 30.0]
    assert [found.short(value) for value in (39.5, 40.5, 40.0)] == ["39.5", "0.5", "0"]


def test_files_of_a_sweep(folder: Path, tmp_path: Path) -> None:
    """Two for each quantity in their format and folder; of the first one without a choice."""
    subjects = ("main_effects", "level_lines")
    written = plot_sweep(folder)
    assert written == [folder / "plots" / f"{item}_duration_s.svg" for item in subjects]
    assert all(ElementTree.parse(path).getroot().tag.endswith("svg") for path in written)
    names = ["collisions", "rebound_amplitude_1"]
    written = plot_sweep(
        folder, quantities=names, across="restitution", kind="png", target=tmp_path / "here"
    )
    wanted = [f"{item}_{name}.png" for name in names for item in subjects]
    assert [path.name for path in written] == wanted
    assert sorted(item.name for item in (tmp_path / "here").iterdir()) == sorted(wanted)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)


def test_unusable_requests(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for arguments, said in (
        (["--quantity", "duration"], "no quantity named 'duration'"),
        (["--quantity", "premise_holds"], "no quantity named 'premise_holds'"),
        (["--x", "speed"], "no parameter named 'speed'"),
        (["--x", "speed_rpm", "--y", "speed_rpm"], "need two parameters"),
    ):
        assert main(["plot", str(folder), "--out", str(tmp_path / "out"), *arguments]) == 2
        assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    with pytest.raises(UnknownNameError):
        plot_sweep(folder, upwards="mass")
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is not a folder"):
        plot_sweep(folder, target=tmp_path / "file")


def test_one_parameter_has_no_level_lines(tmp_path: Path) -> None:
    """Nor does a quantity without a value have a figure: no jaw collides forty times."""
    head, mass = STUDY[: STUDY.index("speed_rpm =")], STUDY[STUDY.index('"links.') :]
    file, folder = tmp_path / "study.toml", tmp_path / "out"
    file.write_text(head.replace("rebound_amplitude_1", "time_s_40") + mass, encoding="utf-8")
    sweep(read_plan(str(file)), folder, workers=1)
    (written,) = plot_sweep(folder)
    assert written.name == "main_effects_duration_s.svg"
    words = r"level lines need two parameters; .* has only links\.top"
    with pytest.raises(InputError, match=words):
        plot_sweep(folder, across="links.top_nipper.mass_kg")
    words = "no scenario has a value of time_s_40; see the column message"
    with pytest.raises(InputError, match=words):
        plot_sweep(folder, quantities=["time_s_40"], target=tmp_path / "here")
    assert not (tmp_path / "here").exists()
