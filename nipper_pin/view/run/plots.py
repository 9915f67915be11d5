"""A solution as figures in files."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from ...errors import InputError
from ...hybrid import Solution, Window
from ..figure_file import write_figure
from .bounces import impulse_figure, transition_figure
from .timelines import force_figure, motion_figure, phase_figure

PLOTS = ("motion", "phases", "transition", "impulses", "forces")
"""Names of the figures of a solution, of which one may have fewer."""


def plot_solution(solution: Solution, folder: str | Path) -> list[Path]:
    """Write the figures of a solution as PNG files, each when it is complete.

    Args:
        folder: Folder, made if it does not exist; files of the same names are replaced.

    Returns:
        The files: ``motion.png``, ``phases.png``, ``transition.png``, ``impulses.png`` and
        ``forces.png``, in this order.

    Raises:
        InputError: The folder cannot be written.
    """
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{target}: cannot be made a folder ({error.strerror})"
        raise InputError(message, folder=str(target)) from error
    return [
        write_figure(drawn, target / f"{name}.png") for name, drawn in figures(solution).items()
    ]


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
