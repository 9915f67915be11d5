"""Pace of a film: slow around events, quick between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...hybrid import Solution
from ..reading import shown_until

FRAMES_PER_SECOND = 30.0
FASTEST = 50.0
LONGEST = 120.0
"""Seconds of a film whose slow motion is not given, and of any GIF."""
_SLOW = (1000.0, 500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0)
_MOST_FRAMES = 6000
_MARGIN = 0.01  # of a turn: slow motion begins so long before an event
_JOINED = 0.07  # of a turn: between events closer than this it goes on
_FLANK = 17


@dataclass(frozen=True)
class Pace:
    """Frames of a film on both clocks.

    Attributes:
        playback: Time on the viewer's clock [s], shape (K,), growing from 0.
        machine: Time of the solution [s], shape (K,).
        stretch: Seconds of playback in a second of the machine, shape (K,).
    """

    playback: FloatArray
    machine: FloatArray
    stretch: FloatArray

    def playback_at(self, t: FloatArray | float) -> FloatArray:
        """Playback time of a machine time [s]; frames stand at all events."""
        return np.asarray(np.interp(t, self.machine, self.playback))


def pace(solution: Solution, slow: float | None) -> Pace:
    """Choose the frames of a film.

    Args:
        solution: The solution; of many turns only those that pictures show.
        slow: Stretch of time around events [-]. Between them it is at most ``FASTEST``. None: 1000,
            or the largest round one of which the film takes no longer than ``LONGEST``.

    Returns:
        Frames, evenly spaced in playback, with one more at every event.
    """
    end = shown_until(solution)
    events = np.array([event.t for event in solution.events if event.t <= end])
    return paced(events, end, solution.shaft.period, slow)


def paced(events: FloatArray, end: float, period: float, slow: float | None) -> Pace:
    """Choose frames by the times of events.

    Args:
        events: Their times, ascending, shape (E,) [s].
        end: End of the film on the same clock, which begins at 0 [s].
        period: Time of a turn [s].
        slow: Stretch of time around events [-]; None as in :func:`pace`.
    """
    for stretch in _SLOW if slow is None else (slow,):
        knots, slopes, playback = _clocks(events, end, period, stretch)
        if playback[-1] <= LONGEST:
            break
    count = min(int(FRAMES_PER_SECOND * playback[-1]) + 2, _MOST_FRAMES)
    machine = np.interp(np.linspace(0.0, playback[-1], count), playback, knots)
    machine[-1] = end
    machine = np.unique(np.concatenate([machine, events]))
    place = np.clip(np.searchsorted(knots, machine, side="right") - 1, 0, len(slopes) - 1)
    return Pace(np.interp(machine, knots, playback), machine, slopes[place])


def steady(solution: Solution, slow: float) -> Pace:
    """Frames of a film that is equally slow from its start to its end."""
    end = shown_until(solution)
    events = [event.t for event in solution.events if event.t <= end]
    count = min(int(FRAMES_PER_SECOND * slow * end) + 2, _MOST_FRAMES)
    machine = np.unique([*np.linspace(0.0, end, count), *events])
    return Pace(slow * machine, machine, np.full(len(machine), slow))


def round_slow(end: float, longest: float) -> float:
    """The largest round stretch of time with which a time [s] takes no longer than it may [s]."""
    return next((slow for slow in _SLOW if slow * end <= longest), _SLOW[-1])


def _clocks(
    events: FloatArray, end: float, period: float, slow: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Knots of the profile [s], the stretch between them, and the playback there [s]."""
    knots, stretch = _profile(events, end, period, slow)
    slopes = 0.5 * (stretch[1:] + stretch[:-1])
    return knots, slopes, np.concatenate([[0.0], np.cumsum(slopes * np.diff(knots))])


def _profile(
    events: FloatArray, end: float, period: float, slow: float
) -> tuple[FloatArray, FloatArray]:
    """Knots [s] and the stretch there: ``slow`` around groups of events, with short flanks."""
    quick, margin = min(slow, FASTEST), _MARGIN * period
    groups: list[list[float]] = []
    for t in events:
        if groups and t - groups[-1][1] < _JOINED * period:
            groups[-1][1] = t
        else:
            groups.append([t, t])
    ramp = np.linspace(0.0, 1.0, _FLANK)
    # Equal ratios from knot to knot: the eye judges a speed by its ratio to the last one.
    rise = quick * (slow / quick) ** ramp
    values = np.concatenate([rise, rise[::-1]])
    places = [
        np.concatenate([first - margin * (2.0 - ramp), last + margin * (1.0 + ramp)])
        for first, last in groups
    ]
    knots = np.unique(np.clip(np.concatenate([[0.0, end], *places]), 0.0, end))
    stretch = np.full(len(knots), quick)
    for place in places:
        stretch = np.maximum(stretch, np.interp(knots, place, values, left=quick, right=quick))
    return knots, stretch
