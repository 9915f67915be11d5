"""An optimum as text and as a figure: what is drawn and said is what was found."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from nipper_pin.study.optimise import Optimum, optimise, read_problem
from nipper_pin.view.front_plot import front_figure, plot_front
from nipper_pin.view.optimise_report import print_optimum

MASS = Path(__file__).resolve().parents[1] / "verification" / "models" / "bouncing_mass"
STUDY = f"""
format = 1
[optimise]
title = "A ball [bold]and[/bold] a table"
model = "{MASS}"
minimise = "duration_s"
maximise = "rebound_amplitude_1"
speed_rpm = 60.0
[[optimise.parameters]]
path = "stops.table.restitution"
lower = 0.05
upper = 0.3
[[optimise.parameters]]
path = "drives.table.lead_mm_per_turn"
lower = 20.0
upper = 100.0
[optimise.constraints]
rebound_time_s_1 = {{ upper = 0.005 }}
"""


@pytest.fixture(scope="module")
def optimum(tmp_path_factory: pytest.TempPathFactory) -> Optimum:
    file = tmp_path_factory.mktemp("optimum") / "study.toml"
    file.write_text(STUDY, encoding="utf-8")
    return optimise(read_problem(file), starts=2, points=4, check=False, workers=1)


def test_figure_shows_the_front_and_the_model(optimum: Optimum, tmp_path: Path) -> None:
    """Both aims of every point, the model's own, and the places of the numbers below."""
    above, below = front_figure(optimum).axes
    front, model = above.lines
    aims = ("rebound_amplitude_1", "duration_s")
    wanted = np.array([[item.values[name] for name in aims] for item in optimum.front])
    np.testing.assert_array_equal(front.get_xydata(), wanted)
    assert len(wanted) == 4
    assert optimum.before is not None
    np.testing.assert_array_equal(
        model.get_xydata(), [[optimum.before.values[name] for name in aims]]
    )
    # Its restitution of 0.5 and 1.5 m/s give a rebound of 0.15 s.
    assert model.get_label() == "the model (breaks a limit)"
    for place, line in enumerate(below.lines):
        np.testing.assert_array_equal(line.get_ydata(), [item.z[place] for item in optimum.front])
    assert "rebound amplitude 1 [m]" in below.get_xlabel()
    path = plot_front(optimum, tmp_path / "front.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    assert [item.name for item in tmp_path.iterdir()] == ["front.png"]


def test_text_says_what_holds_and_fits_a_terminal(optimum: Optimum) -> None:
    """At the least e and V nothing but bounds holds the time back; all four front points show."""
    out = io.StringIO()
    print_optimum(optimum, Console(file=out, width=80))
    text = out.getvalue()
    assert max(len(line) for line in text.splitlines() if line != optimum.command) <= 80
    # What looks like markup in a title is the user's.
    assert "A ball [bold]and[/bold] a table" in text
    flat = " ".join(text.split())
    assert "stops.table.restitution >= 0.05: one unit more of room is worth" in flat
    assert "with room left: rebound_time_s_1 <= 0.005" in flat
    assert "the model itself breaks rebound_time_s_1 <= 0.005" in flat
    for item in optimum.front:
        assert f"{item.values['duration_s']:.5g}" in text
    assert "nipper-pin simulate" in text
