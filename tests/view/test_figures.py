"""Figures as reviewed texts: what stands around the curves, and where they go; and their files.

That the curves of a run are the motion is what test_judged says.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from drawn import drawn
from judge import press
from matplotlib.image import imread
from rich.console import Console
from runs_shown import run_of, slotted, turn, with_elements
from snapshots import Words

from nipper_pin import Case, EventKind, Solution, check, compare, load, simulate
from nipper_pin.study.next_steps import NextSteps
from nipper_pin.study.speed_limit import SpeedLimit, SpeedRange, Verdict
from nipper_pin.view.compare.files import curves_figure
from nipper_pin.view.run import print_solution
from nipper_pin.view.run.bounces import impulse_figure, transition_figure
from nipper_pin.view.run.export import export
from nipper_pin.view.run.plots import figures
from nipper_pin.view.run.timelines import force_figure, motion_figure, phase_figure
from nipper_pin.view.studies.check_report import print_report
from nipper_pin.view.studies.speed_limit_plot import speed_limit_figure

FIGURES = {
    "motion": motion_figure,
    "forces": force_figure,
    "phases": phase_figure,
    "impulses": impulse_figure,
    "transition": lambda run: transition_figure(run, run.transitions[0]),
}


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("name", ["cycle", "many_turns", "transition", "press"])
def test_figures(name: str, figure: str, request: pytest.FixtureRequest, words: Words) -> None:
    """A turn, twenty of which two are shown, a part of one, and a machine of another kind."""
    run: Solution = request.getfixturevalue(name)
    words(drawn(FIGURES[figure](run)))


@pytest.fixture(scope="module", name="press")
def turn_of_a_press() -> Solution:
    return turn(press(), 60.0, 3.0)


@pytest.mark.parametrize("figure", ["motion", "forces", "impulses"])
def test_figures_of_stops_on_both_sides(figure: str, words: Words) -> None:
    """Gaps from the stops, not coordinates."""
    words(drawn(FIGURES[figure](run_of("boxed"))))


def test_figure_of_a_comparison(words: Words) -> None:
    """Both curves of the window and, enlarged, of the transition."""
    words(drawn(curves_figure(compare(*(turn(load("e62"), rpm, 24.0) for rpm in (450.0, 520.0))))))


def up_to(limit: float | None) -> tuple[SpeedRange, ...]:
    if limit is None:
        return (SpeedRange(300.0, 900.0, Verdict.YES),)
    return SpeedRange(300.0, limit, Verdict.YES), SpeedRange(limit, 900.0, Verdict.NO)


@pytest.mark.parametrize(
    ("settles", "repeats"), [(544.7, 651.9), (None, None), (None, 800.0)], ids=str
)
def test_figure_of_a_speed_limit(
    settles: float | None, repeats: float | None, words: Words
) -> None:
    """Three speeds; at the last one two turns differ, and the jaw is not at rest."""
    nan = float("nan")
    words(drawn(speed_limit_figure(SpeedLimit(
        model="m", title="a machine", stop="jaw", speed_rpm=np.array([300.0, 600.0, 900.0]),
        status=("followed",) * 3, turns=np.array([2, 2, 400]), repeats_after=np.array([1, 1, 2]),
        closing=np.array([34.0, 35.0, 36.0]), rest=np.array([36.0, 39.0, nan]),
        opening=np.array([47.0, 47.5, nan]), clamped_share=np.array([0.275, 0.2125, 0.0]),
        margin=np.array([11.0, 8.5, nan]),
        rests=np.array([[36.0, nan], [39.0, nan], [nan, nan]]),
        touches=np.array([[34.0, nan], [35.0, nan], [36.0, 36.5]]),
        settled=up_to(settles), single=up_to(repeats),
    ))))  # fmt: skip


# Files.


def test_a_stop_that_is_open_at_the_end_has_left_and_not_come_back() -> None:
    """A turn that ends while the steeve floats: the report says when it leaves, and no more."""
    run = simulate(load("e62"), Case(speed_rpm=650.0, window="cycle", start_index=30.0))
    (released,) = (item for item in run.events if item.kind is EventKind.RELEASE)
    assert released is run.events[-1]
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
        ({"stops.jaw.restitution": 0.9}, Case(speed_rpm=650.0), ["motion", "phases", "impulses"]),
        ({"stops.jaw.restitution": 0.0}, Case(speed_rpm=450.0), ["impulses"]),
    ],
)  # fmt: skip
def test_which_figures_a_run_has(changes: dict[str, float], case: Case, names: list[str]) -> None:
    """None of what did not happen: forces in a transition, a rest, motion."""
    assert list(figures(simulate(load("e62", changes), case))) == names


def test_files_of_a_run(tmp_path: Path) -> None:
    """Every figure is in one, and none is blank."""
    folder = tmp_path / "new" / "folder"
    run = simulate(load("e62", {"stops.jaw.restitution": 0.9}), Case(speed_rpm=650.0))
    written = export(run, str(folder))
    files = [file for file in written if file.suffix == ".png"]
    assert [file.stem for file in files] == list(figures(run))
    assert sorted(folder.iterdir()) == sorted(written)
    assert all(imread(file)[::4, ::4, :3].std() > 0.02 for file in files)


# Springs, dampers, slots and limits in words, as `check` and the tables of a run have them.


def test_words_of_elements(words: Words) -> None:
    """One of each kind, with the units of people."""
    stream = io.StringIO()
    console = Console(file=stream, width=100)
    print_report(check(with_elements(), 600.0), NextSteps((), ()), console)
    print_solution(run_of("elements"), console)
    words(stream.getvalue())


def test_words_of_a_slot(words: Words) -> None:
    """Side, joint and place of every stop; the frame and the axis that a pin slides in."""
    stream = io.StringIO()
    print_report(check(slotted(), 60.0), NextSteps((), ()), Console(file=stream, width=100))
    words(stream.getvalue())
