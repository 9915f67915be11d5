"""The figures of a solution."""

from __future__ import annotations

from matplotlib.figure import Figure

from ...hybrid import Solution, Window
from .bounces import impulse_figure, transition_figure
from .timelines import force_figure, motion_figure, phase_figure

PLOTS = ("motion", "phases", "transition", "impulses", "forces")
"""Names of the figures of a solution, of which one may have fewer."""


def figures(solution: Solution) -> dict[str, Figure]:
    """The figures of a solution, which a notebook shows.

    Of many turns the first two are drawn. There is no figure of what did not happen.

    Returns:
        By name: "motion" and "phases" need motion and a stop, "transition" a completed one with a
        rebound, "impulses" a collision, and "forces" the window "cycle".
    """
    found = {}
    if solution.segments and solution.mechanism.stops:
        found = {"motion": motion_figure(solution), "phases": phase_figure(solution)}
    bounced = [item for item in solution.transitions if item.collisions > 1]
    if bounced:
        found["transition"] = transition_figure(solution, bounced[0])
    if any(item.impulse > 0.0 for item in solution.collisions):
        found["impulses"] = impulse_figure(solution)
    if solution.case.window is Window.CYCLE and solution.mechanism.stops:
        found["forces"] = force_figure(solution)
    return found
