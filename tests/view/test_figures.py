"""The figures of a run as reviewed texts: what stands around the curves, and where they go.

That the curves are the motion is what test_every_plot says.
"""

from __future__ import annotations

import pytest
from drawn import drawn
from judge import press
from snapshots import Words

from nipper_pin import Case, Solution, Window, simulate
from nipper_pin.view.run.bounces import impulse_figure, transition_figure
from nipper_pin.view.run.timelines import force_figure, motion_figure, phase_figure

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
    return simulate(press(), Case(speed_rpm=60.0, window=Window.CYCLE, start_index=3.0))
