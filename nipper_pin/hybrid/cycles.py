"""Turns that must repeat: what is known of the next one is not computed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..dynamics.system import System
from .segment import Segment
from .state import State

# [rad or m]
_SAME_POSITION = 1e-9
# Change of rates, as a share of the largest of the turn: far above amplified round-off, far below
# what an event changes.
_SAME_RATE = 1e-6


def comes_back(system: System) -> bool:
    """True if the drives come back with the cylinder; one may wind on, turn by turn."""
    left, right = system.shaft.driven(np.array([0.0, system.shaft.period]))[0]
    return bool(np.abs(right - left).max(initial=0.0) <= _SAME_POSITION)


def repeats(
    system: System,
    previous: Sequence[Segment],
    current: Sequence[Segment],
    start: State,
    end: State,
) -> bool:
    """True if the turn after this one must equal this one.

    With held drives a phase without freedom is determined by the cylinder angle and the assembly of
    the links, so two turns that share such a phase at the same angle are equal from there on. An
    event at the very border of two turns may, by round-off, belong to either, and a flight may
    bring the links to another assembly: this turn has to end as it began.

    Args:
        system: The system.
        previous: Segments of the turn before; none before the first.
        current: Segments of this turn.
        start: State at its start.
        end: State at its end.
    """
    if not system.held:
        return False
    if not comes_back(system):
        return False
    period = system.shaft.period
    changed = float(np.abs(end.v - start.v).max())
    fastest = max(float(np.abs(panel.v).max()) for part in current for panel in part.panels)
    if start.closed != end.closed or changed > _SAME_RATE * fastest:
        return False
    if np.abs(end.q - start.q).max() > _SAME_POSITION:
        # The links have come to their other assembly, where rates may be the same.
        return False
    first, last = current[0], current[-1]
    if first.kinematic and last.kinematic and first.closed == last.closed:
        return True
    return any(
        old.kinematic
        and new.kinematic
        and old.closed == new.closed
        and old.t_start + period < new.t_end
        and new.t_start < old.t_end + period
        for old in previous
        for new in current
    )
