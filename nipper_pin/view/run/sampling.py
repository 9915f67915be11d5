"""Dense samples of a solution for pictures, with both limits at every event."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arrays import FloatArray
from ...hybrid import Segment, Solution
from ...hybrid.result.trajectory import Motion

_FEWEST = 49
_PER_TURN = 720


def sample_motion(solution: Solution, t_start: float, t_end: float) -> Iterator[Motion]:
    """States along a stretch of time, with every event among them."""
    for _, t in _pieces(solution, t_start, t_end):
        yield solution.trajectory.evaluate(t[:-1])
        yield solution.trajectory.evaluate(t[-1:], left=True)


def sample_coordinates(
    solution: Solution, t_start: float, t_end: float
) -> tuple[FloatArray, FloatArray]:
    """Times [s], shape (K,), and configurations, shape (K, nv), with every event among them."""
    found = list(sample_motion(solution, t_start, t_end))
    return np.concatenate([item.t for item in found]), np.concatenate([item.q for item in found])


def sample_forces(
    solution: Solution, t_start: float, t_end: float
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Times [s] and normal forces [N or N m] of every stop while it is closed, shape (K,) each.

    Stretches are separated by a NaN, so that a line through them breaks at jumps.
    """
    trajectory, nothing = solution.trajectory, np.empty(0)
    times = {stop.name: [nothing] for stop in solution.mechanism.stops}
    forces = {stop.name: [nothing] for stop in solution.mechanism.stops}
    for segment, t in _pieces(solution, t_start, t_end):
        if not segment.closed:
            continue
        inner = trajectory.reactions(t[:-1]).contacts
        last = trajectory.reactions(t[-1:], left=True).contacts
        for name in segment.closed:
            times[name] += [t, t[-1:]]
            forces[name] += [inner[name], last[name], np.array([np.nan])]
    return {name: (np.concatenate(times[name]), np.concatenate(forces[name])) for name in times}


def _pieces(
    solution: Solution, t_start: float, t_end: float
) -> Iterator[tuple[Segment, FloatArray]]:
    """Segments inside a stretch of time with the times to sample, ends included."""
    for segment in solution.segments:
        begin, end = max(segment.t_start, t_start), min(segment.t_end, t_end)
        if end > begin:
            share = (end - begin) / solution.shaft.period
            # Cosines stand closest at the ends, where a gap falls to zero.
            steps = np.linspace(0.0, np.pi, _FEWEST + int(_PER_TURN * share))
            times = begin + (end - begin) * 0.5 * (1.0 - np.cos(steps))
            times[-1] = end
            yield segment, times
