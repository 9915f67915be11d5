"""Names and titles that look like markup or formulas, and links in a circle."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import nipper_pin
from nipper_pin import Case, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import find_model
from nipper_pin.view.plain_texts import plain
from nipper_pin.view.run.plots import plot_solution


def toml(old: str, new: str) -> Callable[[str], str]:
    return lambda text: re.sub(old, lambda _: new, text, count=1, flags=re.MULTILINE)


def test_markup_in_names_is_printed_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Closing tags that open nothing are errors of the library that prints tables."""
    folder = tmp_path / "m"
    folder.mkdir()
    model = find_model("hanging_pendulum")
    for suffix in ("urdf", "toml"):
        text = (model / f"hanging_pendulum.{suffix}").read_text(encoding="utf-8")
        text = text.replace('"jaw"', '"[/x]jaw"').replace("stops.jaw]", 'stops."[/x]jaw"]')
        text = re.sub("^title = .*$", 'title = "[bold]t[/y]"', text, flags=re.MULTILINE)
        (folder / f"m.{suffix}").write_text(text.partition("[shortcuts]")[0])
    out = str(tmp_path / "run")
    for words in (["check"], ["simulate", "--speed", "300", "--forces", "--out", out]):
        assert main([words[0], str(folder), *words[1:]]) == 0
        said = capsys.readouterr().out
        assert said.startswith("[bold]t[/y]")
        assert "[/x]jaw" in said


@pytest.mark.slow
def test_dollars_in_names_are_no_formulas(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor in any figure: each is made plain before it is written."""
    folder = tmp_path / "m"
    folder.mkdir()
    model = find_model("hanging_pendulum")
    name = r"$\\frac{$jaw"
    for suffix in ("urdf", "toml"):
        text = (model / f"hanging_pendulum.{suffix}").read_text(encoding="utf-8")
        text = text.replace('"jaw"', f'"{name}"' if suffix == "toml" else '"$\\frac{$jaw"')
        text = text.replace("stops.jaw]", f'stops."{name}"]').partition("[shortcuts]")[0]
        (folder / f"m.{suffix}").write_text(text)
    run = ["simulate", str(folder), "--speed", "300", "--window", "cycle"]
    assert main([*run, "--out", str(tmp_path / "run")]) == 0
    assert "$\\frac{$jaw" in capsys.readouterr().out
    # Figures are written in one place, which draws texts as they stand.
    saved = [
        (file.name, line.strip())
        for file in Path(nipper_pin.__file__).parent.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if ".savefig(" in line
    ]
    assert {name for name, _ in saved} == {"figure_file.py"}
    assert all(line.startswith("plain(") for _, line in saved if "document," not in line), saved


def test_plain_texts(tmp_path: Path) -> None:
    """Titles, labels, legends and names beside an axis; powers of ten stay formulas."""
    figure = Figure()
    axes = figure.subplots()
    axes.semilogy([0.0, 1.0], [1.0, 100.0], label="$\\frac{$")
    axes.legend(title="$\\frac{$")
    axes.set_xticks([0.0, 1.0], ["$\\frac{$", "b"])
    for write in (axes.set_title, axes.set_xlabel, axes.set_ylabel, figure.suptitle):
        write("$\\frac{$")
    figure.text(0.5, 0.5, "$\\frac{$")
    with pytest.raises(ValueError, match="frac"):
        figure.savefig(tmp_path / "figure.svg")
    plain(figure).savefig(tmp_path / "figure.svg")
    assert "10^{2}" in (tmp_path / "figure.svg").read_text(encoding="utf-8")


def test_a_title_is_no_formula(tmp_path: Path) -> None:
    """Dollars of a title are drawn as they are."""
    folder = tmp_path / "m"
    shutil.copytree(find_model("e62"), folder)
    for suffix in ("urdf", "toml"):
        (folder / f"e62.{suffix}").rename(folder / f"m.{suffix}")
    text = (folder / "m.toml").read_text(encoding="utf-8")
    (folder / "m.toml").write_text(toml("^title = .*$", "title = '$\\frac{$'")(text))
    run = simulate(load(folder), Case(speed_rpm=650.0))
    assert run.mechanism.title == "$\\frac{$"
    assert plot_solution(run, tmp_path / "plots")
