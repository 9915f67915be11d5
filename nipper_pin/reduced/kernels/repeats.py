"""Ends of turns, and whether one repeats an earlier one, compiled."""

from __future__ import annotations

from math import inf, pi

from ...arrays import FloatArray
from ...tolerances.reduced import SAME_TURN
from . import layout as rows
from .compiled import part
from .layout import Charts, Motion

_TURN = 2.0 * pi
# Longest period that is looked for [turns].
_MOST_PERIOD = 64


@part
def mark(ends: FloatArray, turn: int, rest: tuple[float, float], at: Motion) -> None:
    """Write the end of a turn.

    Args:
        turn: Turns that are over.
        rest: Chart and travel of the end of the last rest; -1 without one, and infinity at rest.
    """
    row = ends[turn]
    row[0], row[1] = rest
    row[2], row[3], row[4], row[5], row[6] = at.chart, at.x, at.v, at.dx, at.dv


@part
def begin_at(ends: FloatArray, turn: int) -> tuple[bool, bool, Motion]:
    """How the turn after ``turn`` others begins.

    Returns:
        Whether that is known, which it is not at a collision in that very instant; whether the
        chart's stop is closed; and the state.
    """
    row = ends[turn]
    resting = row[0] >= 0.0 and row[1] == inf
    at = Motion(int(row[2]), 0.0, 0.0, row[3], row[4], 0.0, row[5], row[6])
    return resting or row[3] != 0.0, resting, at


@part
def repeats(charts: Charts, ends: FloatArray, turn: int) -> int:
    """After how many turns one repeats an earlier one; 0 if it is not known to.

    What follows a rest does not depend on what was before it, so two turns whose last rests end at
    the same travel end alike. Without a rest their states at the end have to be the same.
    """
    now = ends[turn]
    for back in range(1, min(turn, _MOST_PERIOD) + 1):
        then = ends[turn - back]
        if now[0] != then[0] or now[2] != then[2]:
            continue
        if now[0] >= 0.0:
            if now[1] == then[1] or abs(now[1] - then[1]) <= SAME_TURN * _TURN:
                return back
            continue
        c = int(now[2])
        wide = charts.numbers[c, rows.HIGH] - charts.numbers[c, rows.LOW]
        fast = max(abs(now[4]), abs(then[4]))
        if abs(now[3] - then[3]) <= SAME_TURN * wide and abs(now[4] - then[4]) <= SAME_TURN * fast:
            return back
    return 0
