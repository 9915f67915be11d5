"""After how many turns a run repeats an earlier one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....tolerances.reduced import SAME_TURN
from ...run.windows import winding
from ..solution import Solution

# Longest period that is looked for [turns].
_MOST_PERIOD = 64
# Segments that tell how far coordinates move, more than a turn has.
_SHOWN = 200


class Repetition(NamedTuple):
    """How turns go on.

    Attributes:
        turn: Number of the first turn that ends as an earlier one did, or of the last one.
        after: After how many turns it repeats that one; 0 if none was met.
    """

    turn: int
    after: int


def repetition(solution: Solution) -> Repetition:
    """Find the first turn that ends like an earlier one, so that all further ones are known.

    Ends are alike if the same stops are closed and the states differ by no more than the engines
    call the same turn, relative to the largest change of coordinates of their kind. Shafts that
    move on their own have their rates in the state, too.

    Args:
        solution: A run of whole turns, followed to its end.
    """
    turns = solution.repeated_from or solution.case.cycles
    period = solution.shaft.period
    ends: FloatArray = np.arange(turns + 1.0) * period
    before = solution.trajectory.evaluate(ends[1:], left=True)
    first = solution.trajectory.evaluate(ends[:1])
    q, v = np.concatenate([first.q, before.q]), np.concatenate([first.v, before.v])
    closed = _closed_before(solution, ends)
    within_q, within_v = _sizes(solution)
    for turn in range(1, turns + 1):
        for back in range(1, min(turn, _MOST_PERIOD) + 1):
            old = turn - back
            if closed[old] != closed[turn]:
                continue
            wound = winding(solution.mechanism, q[old], q[turn], np.inf)
            moved = q[turn] - q[old] - (0.0 if wound is None else wound)
            if (np.abs(moved) <= within_q).all() and (np.abs(v[turn] - v[old]) <= within_v).all():
                return Repetition(turn, back)
    return Repetition(turns, 0 if solution.repeated_from is None else 1)


def _closed_before(solution: Solution, times: FloatArray) -> list[frozenset[str]]:
    """Stops that are closed up to each time; those at the start of the run at its start."""
    starts = np.array([segment.t_start for segment in solution.segments])
    places = np.maximum(np.searchsorted(starts, times, side="left") - 1, 0)
    return [solution.segments[place].closed for place in places]


def _sizes(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """What coordinates and rates of two ends that are alike may differ by, shape (nv,) each."""
    panels = [panel for segment in solution.segments[:_SHOWN] for panel in segment.panels]
    q = np.ptp(np.concatenate([panel.q for panel in panels]), axis=0)
    v = np.abs(np.concatenate([panel.v for panel in panels])).max(axis=0)
    for kind in ("prismatic", "revolute"):
        alike = [joint.index for joint in solution.mechanism.joints if joint.kind == kind]
        if alike:
            q[alike], v[alike] = q[alike].max(), v[alike].max()
    return SAME_TURN * q, SAME_TURN * v
