"""Dense samples of a solution for pictures, with both limits at every event."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...hybrid import Event, Segment, Solution
from ..reading import shown_phases, shown_until

_FEWEST = 49
_PER_TURN = 720


@dataclass(frozen=True)
class ForceRange:
    """Range of the normal force of a closed stop in one phase, over the turns shown.

    Attributes:
        closed: Closed stops of the phase.
        lowest: [N], of a hinge's stop without a contact [N m].
        t_lowest: Its time [s].
        highest: In the same unit.
        t_highest: Its time [s].
    """

    closed: frozenset[str]
    stop: str
    lowest: float
    t_lowest: float
    highest: float
    t_highest: float


def sample_coordinates(
    solution: Solution, t_start: float, t_end: float
) -> tuple[FloatArray, FloatArray]:
    """Times [s], shape (K,), and configurations, shape (K, nv), with every event among them."""
    trajectory = solution.trajectory
    times, states = [], []
    for _, t in _pieces(solution, t_start, t_end):
        inner, last = trajectory.evaluate(t[:-1]), trajectory.evaluate(t[-1:], left=True)
        times.append(t)
        states += [inner.q, last.q]
    return np.concatenate(times), np.concatenate(states)


def lift(solution: Solution, event: Event) -> tuple[float, float] | None:
    """Largest gap of a released stop until its next event, and the time until then.

    Args:
        event: Release of one stop.

    Returns:
        Gap [rad or m] and time [s]; None if the window ends before the stop closes.
    """
    name = event.stops[0]
    later = (item for item in solution.events[event.number :] if name in item.stops)
    following = next(later, None)
    if following is None:
        return None
    _, q = sample_coordinates(solution, event.t, following.t)
    return float(solution.mechanism.stop(name).gaps(q).max()), following.t - event.t


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


def force_ranges(solution: Solution) -> tuple[ForceRange, ...]:
    """Ranges of the forces of closed stops, by phase, over the turns shown."""
    samples: dict[tuple[frozenset[str], str], list[tuple[FloatArray, FloatArray]]] = {}
    for phase in shown_phases(solution):
        if not phase.closed:
            continue
        sampled = sample_forces(solution, phase.t_start, min(phase.t_end, shown_until(solution)))
        for stop in sorted(phase.closed):
            samples.setdefault((phase.closed, stop), []).append(sampled[stop])
    found = []
    for (closed, stop), parts in samples.items():
        t = np.concatenate([part[0] for part in parts])
        force = np.concatenate([part[1] for part in parts])
        if np.isnan(force).all():
            continue
        low, high = int(np.nanargmin(force)), int(np.nanargmax(force))
        found.append(
            ForceRange(
                closed, stop, float(force[low]), float(t[low]), float(force[high]), float(t[high])
            )
        )
    return tuple(found)


def shaft_rates(solution: Solution) -> dict[str, tuple[float, float]]:
    """Smallest and largest rate of every driven joint over the turns shown.

    Returns:
        Both by drive [rad/s or m/s]; empty for a run without motion.
    """
    found: list[FloatArray] = []
    for _, t in _pieces(solution, 0.0, shown_until(solution)):
        inner = solution.trajectory.evaluate(t[:-1])
        found += [inner.v, solution.trajectory.evaluate(t[-1:], left=True).v]
    if not found:
        return {}
    v = np.concatenate(found)
    lowest, highest = v.min(axis=0), v.max(axis=0)
    return {
        drive.name: (float(lowest[drive.index]), float(highest[drive.index]))
        for drive in solution.mechanism.drives
    }


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
