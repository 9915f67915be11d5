"""The figures exist as files, are those of what happened, and leave global state alone."""

import io
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from rich.console import Console

from nipper_pin import Case, EventKind, InputError, Solution, load, simulate
from nipper_pin.view.run.plots import plot_solution
from nipper_pin.view.run.sampling import lift
from nipper_pin.view.run.table import print_solution


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


def test_plots_leave_pyplot_alone() -> None:
    code = "import sys, nipper_pin.view.run.plots; assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
