"""Names and titles that look like markup or formulas."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import nipper_pin
from nipper_pin.cli import main
from nipper_pin.mechanism import find_model
from nipper_pin.view.plain_texts import plain

FORMULA = "$\\frac{$"


def test_markup_and_formulas_in_names_are_printed_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Closing tags that open nothing are errors of the library that prints tables.

    Those that mean nothing to a formula are errors of the one that draws figures.
    """
    folder = tmp_path / "m"
    folder.mkdir()
    model = find_model("hanging_pendulum")
    name = f"[/x]jaw{FORMULA}"
    for suffix in ("urdf", "toml"):
        text = (model / f"hanging_pendulum.{suffix}").read_text(encoding="utf-8")
        text = text.replace('"jaw"', f'"{name}"' if suffix == "urdf" else f"'{name}'")
        text = text.replace("stops.jaw]", f"stops.'{name}']").partition("[shortcuts]")[0]
        title = f"title = '[bold]t[/y]{FORMULA}'"
        text = re.sub("^title = .*$", lambda _, title=title: title, text, flags=re.MULTILINE)
        (folder / f"m.{suffix}").write_text(text)
    out = str(tmp_path / "run")
    for words in (["check"], ["simulate", "--speed", "300", "--forces", "--out", out]):
        assert main([words[0], str(folder), *words[1:]]) == 0
        said = capsys.readouterr().out
        assert said.startswith(f"[bold]t[/y]{FORMULA}")
        assert name in said
    assert (tmp_path / "run" / "motion.png").stat().st_size > 0


def test_plain_texts(tmp_path: Path) -> None:
    """Titles, labels, legends and names beside an axis; powers of ten stay formulas."""
    figure = Figure()
    axes = figure.subplots()
    axes.semilogy([0.0, 1.0], [1.0, 100.0], label=FORMULA)
    axes.legend(title=FORMULA)
    axes.set_xticks([0.0, 1.0], [FORMULA, "b"])
    for write in (axes.set_title, axes.set_xlabel, axes.set_ylabel, figure.suptitle):
        write(FORMULA)
    figure.text(0.5, 0.5, FORMULA)
    with pytest.raises(ValueError, match="frac"):
        figure.savefig(tmp_path / "figure.svg")
    plain(figure).savefig(tmp_path / "figure.svg")
    assert "10^{2}" in (tmp_path / "figure.svg").read_text(encoding="utf-8")


def test_figures_are_written_in_one_place_which_draws_texts_as_they_stand() -> None:
    saved = [
        (file.name, line.strip())
        for file in Path(nipper_pin.__file__).parent.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if ".savefig(" in line
    ]
    assert {name for name, _ in saved} == {"figure_file.py"}
    assert all(line.startswith("plain(") for _, line in saved if "document," not in line), saved
