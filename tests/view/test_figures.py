"""Figures as reviewed texts: what stands around the curves, and where they go.

That the curves of a run are the motion is what test_motion_shown says.
"""

from __future__ import annotations

import numpy as np
import pytest
from drawn import drawn
from judge import press
from runs_shown import run_of, turn
from snapshots import Words

from nipper_pin import Solution, compare, load
from nipper_pin.study.speed_limit import SpeedLimit, SpeedRange, Verdict
from nipper_pin.view.compare.files import curves_figure
from nipper_pin.view.run.bounces import impulse_figure, transition_figure
from nipper_pin.view.run.timelines import force_figure, motion_figure, phase_figure
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
