"""Turns that must repeat: what is known of the next one is not computed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System
from ...mechanism import Mechanism
from ...tolerances.hybrid import SAME_POSITION, SAME_RATE
from ..segment import Segment
from ..state import State


def comes_back(system: System) -> bool:
    """True if the drives come back with the cylinder, but for whole turns of a crank."""
    positions = np.zeros((2, system.body.nv))
    positions[:, system.driven] = system.shaft.driven(np.array([0.0, system.shaft.period]))[0]
    return winding(system.mechanism, positions[0], positions[1]) is not None


def winding(
    mechanism: Mechanism, start: FloatArray, end: FloatArray, within: float = SAME_POSITION
) -> FloatArray | None:
    """By how much hinges have wound on where the links stand as before.

    Links stand the same after whole turns of a hinge; springs and stops at the hinge do not.

    Args:
        start: Configuration, shape (nv,) [rad or m].
        end: Another one, likewise.
        within: What positions of one assembly may differ by, in units of coordinates.

    Returns:
        Multiples of 2 pi, zero for all other coordinates, shape (nv,) [rad]; None if the links
        stand elsewhere.
    """
    bound = {spring.index for spring in mechanism.springs}
    bound |= {table.index for table in mechanism.tabulated_springs}
    bound |= {force.index for force in mechanism.forces}
    bound |= {stop.index for stop in mechanism.stops}
    winds = np.zeros(len(start))
    for joint in mechanism.joints:
        winds[joint.index] = joint.kind == "revolute" and joint.index not in bound
    wound = 2.0 * np.pi * winds * np.rint((end - start) / (2.0 * np.pi))
    apart = np.abs(end - start - wound) / mechanism.units
    return wound if apart.max(initial=0.0) <= within else None


def repeats(
    system: System,
    previous: Sequence[Segment],
    current: Sequence[Segment],
    start: State,
    end: State,
) -> FloatArray | None:
    """By how much hinges wind on in this turn, if the one after must equal it.

    With held drives a phase without freedom is determined by the cylinder angle and the assembly of
    the links, so two turns that share such a phase at the same angle are equal from there on. An
    event at the very border of two turns may, by round-off, belong to either, and a flight may
    bring the links to another assembly: this turn has to end as it began.

    Args:
        previous: Segments of the turn before; none before the first.
        current: Segments of this turn.
        start: State at its start.
        end: State at its end.

    Returns:
        As :func:`winding`; None if the next turn has to be computed.
    """
    if not system.held or not comes_back(system):
        return None
    period = system.shaft.period
    units = system.body.units
    changed = float((np.abs(end.v - start.v) / units).max())
    panels = [panel for part in current for panel in part.panels]
    fastest = max(float((np.abs(panel.v) / units).max()) for panel in panels)
    if start.closed != end.closed or changed > SAME_RATE * fastest:
        return None
    # The links may have come to their other assembly, where rates may be the same.
    wound = winding(system.mechanism, start.q, end.q)
    first, last = current[0], current[-1]
    if first.kinematic and last.kinematic and first.closed == last.closed:
        return wound
    shared = any(
        old.kinematic
        and new.kinematic
        and old.closed == new.closed
        and old.t_start + period < new.t_end
        and new.t_start < old.t_end + period
        for old in previous
        for new in current
    )
    return wound if shared else None
