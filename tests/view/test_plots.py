"""The figures exist, show something in every panel, and leave global state alone."""

import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from rich.console import Console

from nipper_pin.errors import InputError
from nipper_pin.hybrid.case import Case
from nipper_pin.hybrid.event import EventKind
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import load
from nipper_pin.view.run.bounces import impulse_figure, transition_figure
from nipper_pin.view.run.plots import plot_solution
from nipper_pin.view.run.sampling import lift
from nipper_pin.view.run.table import print_solution
from nipper_pin.view.run.timelines import force_figure, motion_figure, phase_figure


def assert_every_panel_shows_something(figure: Figure) -> None:
    """Cut every panel out of the picture; shading and phase numbers alone are not enough."""
    figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(float)
    height = picture.shape[0]
    assert figure.axes
    for axes in figure.axes:
        box = axes.get_window_extent()
        panel = picture[
            height - int(box.y1) + 4 : height - int(box.y0) - 4, int(box.x0) + 4 : int(box.x1) - 4
        ]
        assert min(panel.shape[:2]) > 100
        assert panel.std() > 2.0
        assert (panel.std(axis=0).max(axis=1) > 1.0).mean() > 0.15


@pytest.mark.parametrize("draw", [
    motion_figure, phase_figure, force_figure, impulse_figure,
    lambda run: transition_figure(run, run.transitions[0]),
])  # fmt: skip
def test_no_panel_of_a_cycle_is_blank(draw: Callable[[Solution], Figure], cycle: Solution) -> None:
    assert_every_panel_shows_something(draw(cycle))


def test_a_stop_that_is_open_at_the_end_has_left_and_not_come_back() -> None:
    """A turn that ends while the steeve floats: the report says when it leaves, and no more."""
    run = simulate(load("e62"), Case(speed_rpm=650.0, window="cycle", start_index=30.0))
    (released,) = (item for item in run.events if item.kind is EventKind.RELEASE)
    assert released is run.events[-1]
    assert lift(run, released) is None
    stream = io.StringIO()
    print_solution(run, Console(file=stream, width=400))
    (told,) = (row for row in stream.getvalue().splitlines() if "leaves its stop" in row)
    assert "steeve" in told
    assert "later" not in told


@pytest.mark.parametrize(
    ("changes", "case", "names"),
    [
        (
            {}, Case(speed_rpm=650.0, window="cycle"),
            ["motion", "phases", "transition", "impulses", "forces"],
        ),
        ({}, Case(speed_rpm=650.0), ["motion", "phases", "transition", "impulses"]),
        ({"stops.jaw.restitution": 0.9}, Case(speed_rpm=650.0), ["motion", "phases", "impulses"]),
        ({"stops.jaw.restitution": 0.0}, Case(speed_rpm=450.0), ["impulses"]),
    ],
)  # fmt: skip
def test_which_figures_a_run_has(
    changes: dict[str, float], case: Case, names: list[str], tmp_path: Path
) -> None:
    """None of what did not happen: forces in a transition, a rest, motion."""
    folder = tmp_path / "new" / "folder"
    files = plot_solution(simulate(load("e62", changes), case), str(folder))
    assert [file.name for file in files] == [f"{name}.png" for name in names]
    assert sorted(folder.iterdir()) == sorted(files)
    assert all(imread(file)[..., :3].std() > 0.02 for file in files)


def test_a_folder_that_is_a_file_is_refused(transition: Solution, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be made a folder"):
        plot_solution(transition, tmp_path / "file")


def test_a_failure_leaves_no_half_file(
    transition: Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: Figure, target: Path, **__: object) -> None:
        Path(target).write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", fail)
    with pytest.raises(InputError, match="cannot be written"):
        plot_solution(transition, tmp_path)
    assert list(tmp_path.iterdir()) == []


def run_python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_importing_the_package_brings_neither_matplotlib_nor_rich() -> None:
    code = (
        "import sys, nipper_pin.view; "
        "print([m for m in ('matplotlib', 'rich') if m in sys.modules])"
    )
    assert run_python(code) == "[]"


def test_plots_leave_pyplot_alone() -> None:
    code = "import sys, nipper_pin.view.run.plots; print('matplotlib.pyplot' in sys.modules)"
    assert run_python(code) == "False"
