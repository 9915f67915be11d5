"""Figures of a sweep: what they average, and that they show what is in the table."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from nipper_pin import InputError, UnknownNameError
from nipper_pin.cli import main
from nipper_pin.study.sweep import SweepTable, read_plan, read_sweep, run_sweep
from nipper_pin.study.sweep.results.chunk_file import about, encode
from nipper_pin.view.studies import sweep_plots
from nipper_pin.view.studies.sweep_figures import (
    Parameter,
    Quantity,
    cell_means,
    level_lines,
    main_effects,
)
from nipper_pin.view.studies.sweep_plots import plot_sweep

STUDY = """
format = 1
title = "Three parameters"
quantities = ["duration_s", "rebound_amplitude_1"]
[parameters.speed_rpm]
low = 450.0
high = 650.0
points = 3
[parameters.restitution]
low = 0.05
high = 0.2
points = 3
scale = "log"
[parameters."links.top_nipper.mass_kg"]
values = [1.2, -1.0]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep with every second scenario marked: a link of negative mass."""
    home = tmp_path_factory.mktemp("sweep")
    file = home / "study.toml"
    file.write_text(STUDY, encoding="utf-8")
    run_sweep(read_plan(str(file)), home / "out", workers=1)
    return home / "out"


def made_up(axes: list[dict[str, object]], columns: dict[str, np.ndarray]) -> SweepTable:
    n = len(next(iter(columns.values())))
    return SweepTable(
        title="made up", model="none", axes=tuple(axes), quantities=("y",), scenarios=n, stored=n,
        table=pa.table(columns),
    )  # fmt: skip


def axis(name: str, low: float, high: float, **more: object) -> dict[str, object]:
    return {"name": name, "path": name, "low": low, "high": high, "scale": "linear", "values": [],
            **more}  # fmt: skip


def test_cell_means_against_a_loop() -> None:
    """Written out in plain Python; empty cells and values that are not finite are told apart."""
    random = np.random.default_rng(3)
    across, upwards = random.integers(0, 4, 50), random.integers(0, 5, 50)
    y = random.normal(size=50)
    y[::7] = np.nan
    across[across == 2] = 3
    found = cell_means(across, upwards, (4, 5), y)
    for i in range(4):
        for j in range(5):
            inside = [
                value
                for value, a, b in zip(y, across, upwards, strict=True)
                if (a, b) == (i, j) and np.isfinite(value)
            ]
            if inside:
                assert found[i, j] == pytest.approx(sum(inside) / len(inside), rel=1e-12)
            else:
                assert np.isnan(found[i, j])
    assert np.isnan(found[2]).all()


def test_main_effects_of_a_known_function() -> None:
    """y = x^2 + z with z evenly about zero: the mean over x is the parabola, that over z a line.

    The cells of a sampled parameter hold 4000 / 18 scenarios: their means stray by the width of a
    cell and the scatter of a mean, 0.1 in all; a swapped or reversed column misses by 1.
    """
    random = np.random.default_rng(5)
    x, z = random.uniform(-1.0, 1.0, 4000), random.uniform(-1.0, 1.0, 4000)
    table = made_up([axis("x", -1.0, 1.0), axis("z", -1.0, 1.0)], {"x": x, "z": z, "y": x * x + z})
    parameters = [Parameter.of(table, place) for place in range(2)]
    figure = main_effects(table, parameters, Quantity.of(table, "y"))
    for axes, wanted in zip(figure.axes, (np.square, lambda z: z + 1.0 / 3.0), strict=True):
        (line,) = axes.get_lines()
        np.testing.assert_allclose(line.get_ydata(), wanted(line.get_xdata()), atol=0.2)
        assert np.abs(line.get_ydata() - wanted(line.get_xdata())).mean() < 0.05
        assert len(line.get_xdata()) == 18


@pytest.mark.slow
def test_figures_of_a_sweep(folder: Path, tmp_path: Path) -> None:
    """Both for both quantities, well-formed, and they say what is missing from them."""
    names = ["duration_s", "rebound_amplitude_1"]
    written = plot_sweep(folder, quantities=names, target=tmp_path)
    subjects = ("main_effects", "level_lines")
    wanted = [f"{subject}_{name}.svg" for name in names for subject in subjects]
    assert [path.name for path in written] == wanted
    for path in written:
        assert ElementTree.parse(path).getroot().tag.endswith("svg")
    (png,) = plot_sweep(folder, kind="png", target=tmp_path)[1:]
    assert png.read_bytes().startswith(b"\x89PNG")
    sweep = read_sweep(folder)
    parameters = [Parameter.of(sweep, place) for place in range(3)]
    quantity = Quantity.of(sweep, "duration_s")
    figure = level_lines(sweep, parameters[0], parameters[1], quantity)
    assert figure.get_suptitle() == "Time to rest over cylinder speed and restitution of stop jaw"
    below = figure.get_supxlabel()
    assert "9 of them without a value" in below
    assert "not the maker's data" in below
    assert figure.axes[0].get_yscale() == "log"


def test_level_lines_show_the_table(folder: Path) -> None:
    """The field behind the lines is the one scenario of each pair that has a value."""
    sweep = read_sweep(folder)
    rows = [row for row in sweep.table.to_pylist() if row["outcome"] == "at_rest"]
    assert len(rows) == 9
    speed, e = (Parameter.of(sweep, place) for place in (0, 1))
    y = sweep.table["rebound_amplitude_1"].to_numpy()
    field = cell_means(speed.cell, e.cell, (3, 3), y)
    for row in rows:
        i = [450.0, 550.0, 650.0].index(row["speed_rpm"])
        j = int(np.argmin(np.abs(e.centres - row["restitution"])))
        assert field[i, j] == row["rebound_amplitude_1"]
    # A livelier jaw at a higher speed rebounds higher: rows and columns are where they should be.
    assert (np.diff(field, axis=0) > 0.0).all()
    assert (np.diff(field, axis=1) > 0.0).all()


def test_thinned_reading_is_even(folder: Path, tmp_path: Path) -> None:
    """Every k-th scenario across chunks of any size, and the damaged file of a sweep is named.

    The grids have 3, 3 and 2 values: k = 4 would be enough, and would meet one mass only.
    """
    whole = read_sweep(folder).table["scenario"].to_pylist()
    assert whole == list(range(18))
    table = pq.read_table(folder / "chunks" / "0000000.parquet")
    copy = tmp_path / "copy"
    (copy / "chunks").mkdir(parents=True)
    (copy / "plan.json").write_bytes((folder / "plan.json").read_bytes())
    for number, (start, stop) in enumerate([(0, 5), (5, 6), (6, 18)]):
        part = table.slice(start, stop - start)
        columns = {name: part[name] for name in part.column_names}
        content = encode(columns, units={}, about=about(table))
        (copy / "chunks" / f"{number:07d}.parquet").write_bytes(content)
    thin = read_sweep(copy, 5)
    assert thin.stored == 18
    assert thin.table["scenario"].to_pylist() == [0, 5, 10, 15]
    assert len(set(thin.table["links.top_nipper.mass_kg"].to_pylist())) == 2
    (copy / "chunks" / "0000001.parquet").write_bytes(b"PAR1 and nothing more")
    with pytest.raises(InputError, match=r"0000001\.parquet: damaged"):
        read_sweep(copy)


def test_unusable_requests(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for arguments, said in (
        (["--quantity", "duration"], "no quantity named 'duration'"),
        (["--x", "speed"], "no parameter named 'speed'"),
        (["--x", "speed_rpm", "--y", "speed_rpm"], "need two parameters"),
    ):
        assert main(["plot", str(folder), "--out", str(tmp_path / "out"), *arguments]) == 2
        assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main(["plot", str(tmp_path / "nothing")]) == 2
    assert "not the plan of a sweep" in capsys.readouterr().err
    with pytest.raises(UnknownNameError):
        plot_sweep(folder, upwards="mass")


def test_one_parameter_has_no_level_lines() -> None:
    item = SimpleNamespace(name="speed_rpm")
    assert sweep_plots._pair([item], None, None, "here") is None  # type: ignore[list-item]
    with pytest.raises(InputError, match="level lines need two parameters; here has only speed"):
        sweep_plots._pair([item], "speed_rpm", None, "here")  # type: ignore[list-item]
