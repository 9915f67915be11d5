"""Events of a motion with bounds on their errors, and ends of turns, compiled."""

from __future__ import annotations

from math import inf, pi

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import GROWTH_SAFETY, SAME_TURN
from . import layout as rows
from .compiled import part
from .flight_errors import of_solver, size
from .layout import Charts, Flown, Motion, Records, Solver
from .panel import along

TURN = 2.0 * pi
# Longest period that is looked for [turns].
_MOST_PERIOD = 64


@part
def errors_after(nodes: FloatArray, sizes: FloatArray, speed: float, flown: Flown, at: Motion,
                 bend: float) -> tuple[float, float]:  # fmt: skip
    """Errors of x and x' after a flight along which they were traced, from those at its start.

    With ``bend`` = x'' / x' at the end the second error is that of x' where x is zero.
    """
    fastest, dx, dw, g = flown.fastest, at.dx, at.dv, nodes[rows.GROWTH]
    late = speed * size(sizes, rows.BY_U, fastest) * at.dt
    e = of_solver(sizes, flown) + size(sizes, rows.RESIDUAL, fastest) + late
    x = GROWTH_SAFETY * (abs(g[0]) * dx + abs(g[1]) * dw + g[2] * e)
    v = abs(g[3] - bend * g[0]) * dx + abs(g[4] - bend * g[1]) * dw
    v = GROWTH_SAFETY * (v + (g[5] + abs(bend) * g[2]) * e)
    return x, v + 4.0 * EPS * fastest


@part
def strike(solver: Solver, at: Motion) -> Motion:
    """Write a collision of a chart's stop, and return the motion after it."""
    charts, one, records = solver.charts, solver.one, solver.records
    memory, counts, number = solver.work.memory, records.counts, charts.numbers[at.chart]
    stop = charts.stops[at.chart, rows.OWN]
    e_N, lever, v = one.restitution[stop], charts.lever[stop], at.v
    C = along(charts.inertia[at.chart], number[rows.PER_RAD], at.u)
    row = records.events[counts[rows.EVENTS]]
    row[:] = np.nan
    row[rows.KIND], row[rows.STOP], row[rows.TIME] = rows.COLLISION, stop, at.t
    row[rows.TRAVEL] = TURN * counts[rows.DONE] + number[rows.BEGIN] + at.u
    row[rows.APPROACH], row[rows.SEPARATION] = v, -e_N * v
    row[rows.IMPULSE] = C * (1.0 + e_N) * -v / lever
    row[rows.ENERGY] = 0.5 * C * (1.0 - e_N * e_N) * v * v
    row[rows.TIME_ERROR], row[rows.RATE_ERROR] = at.dt + 4.0 * EPS * at.t, at.dv
    # The inertia changes by less than itself over a chart.
    relative = number[rows.INERTIA_ERROR] + one.speed * at.dt / number[rows.TRAVEL_MOST]
    row[rows.IMPULSE_ERROR] = C * (1.0 + e_N) * (at.dv + abs(v) * relative) / lever
    by_rate = abs(v) * (at.dv + abs(v) * relative) + at.dv * at.dv
    row[rows.ENERGY_ERROR] = C * (1.0 - e_N * e_N) * by_rate
    memory[rows.LAST] = counts[rows.EVENTS]
    memory[rows.RISEN] = memory[rows.RISEN_ERROR] = 0.0
    memory[rows.FLOWN] = memory[rows.FLOWN_ERROR] = 0.0
    counts[rows.EVENTS] += 1
    return Motion(at.chart, at.u, at.t, 0.0, -e_N * v, at.dt, 0.0, e_N * at.dv)


@part
def rebounded(solver: Solver, T: float, top: float, late: float, wrong: float) -> None:
    """Write the rebound of the last collision, whose last flight took a time T up to a gap."""
    memory = solver.work.memory
    if memory[rows.LAST] < 0.0:
        return
    row = solver.records.events[int(memory[rows.LAST])]
    row[rows.AMPLITUDE] = max(memory[rows.RISEN], top)
    row[rows.AMPLITUDE_ERROR] = max(memory[rows.RISEN_ERROR], wrong)
    row[rows.AMPLITUDE_ERROR] += 4.0 * EPS * row[rows.AMPLITUDE]
    row[rows.REBOUND] = memory[rows.FLOWN] + T
    row[rows.REBOUND_ERROR] = memory[rows.FLOWN_ERROR] + late


@part
def note(records: Records, kind: int, stop: int, t: float, travel: float, dt: float) -> None:
    """Write a rest or a release."""
    row = records.events[records.counts[rows.EVENTS]]
    row[:] = np.nan
    row[rows.KIND], row[rows.STOP] = kind, stop
    row[rows.TIME], row[rows.TRAVEL] = t, travel
    row[rows.TIME_ERROR] = dt + 4.0 * EPS * t
    records.counts[rows.EVENTS] += 1


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
            if now[1] == then[1] or abs(now[1] - then[1]) <= SAME_TURN * TURN:
                return back
            continue
        c = int(now[2])
        wide = charts.numbers[c, rows.HIGH] - charts.numbers[c, rows.LOW]
        fast = max(abs(now[4]), abs(then[4]))
        if abs(now[3] - then[3]) <= SAME_TURN * wide and abs(now[4] - then[4]) <= SAME_TURN * fast:
            return back
    return 0
