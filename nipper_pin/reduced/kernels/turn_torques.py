"""Largest torques of the drives in a turn, compiled: from the panels of its motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...tolerances.reduced import FLAT_EXTREME
from . import flight as panels
from . import layout as rows
from .compiled import compiled, part
from .flight_errors import size
from .in_memory import in_memory
from .layout import Charts, Job, Motion, Records, Settings, Solver, Work
from .panel import acceleration, along, chebyshev, contract, place_of, position, rate_at, reach
from .turn import FLYING, RESTING, follow
from .turn_charts import case_of, prepare, records_in, scratch
from .turn_events import begin_at
from .turn_quantities import begun

# Places of a panel by its nodes, and of a rest by cells of its chart.
_PER_NODE, _PER_CELL, _LEAST = 2, 24, 4
_SEARCH_STEPS = 40


@part
def torque_at(torques: Solver, i: int, u: float, x: float, v: float, a: float) -> float:
    """Torque at a travel in a chart; ``i`` is the place of chart and drive."""
    work, degree = torques.work, torques.charts.equation.shape[4]
    row = len(work.poly) - 1
    contract(torques, i, row, u)
    place = place_of(torques.charts.numbers[i], x)
    by_a = chebyshev(work.poly, row, 3 * degree, degree, place)
    return acceleration(torques, i, row, x, v) + by_a * a


@part
def _value(torques: Solver, i: int, block: FloatArray, sigma: float) -> float:
    """Torque at a part of a panel that is kept."""
    numbers = block[rows.KEPT]
    h, order = numbers[panels.LENGTH], int(numbers[panels.NODES])
    # By round-off beyond the chart, there may be a cell that is combined for no case.
    past = numbers[panels.FROM] + torques.one.speed * h * sigma
    u = min(past, torques.charts.numbers[i, rows.TRAVEL_MOST])
    if order == 0:
        return torque_at(torques, i, u, 0.0, 0.0, 0.0)
    x = position(block, order, h, numbers[panels.X_BEGIN], numbers[panels.V_BEGIN], sigma)
    v = rate_at(block, order, h, numbers[panels.V_BEGIN], sigma)
    a = chebyshev(block, rows.SERIES, rows.ZERO, order, 2.0 * sigma - 1.0)
    return torque_at(torques, i, u, x, v, a)


@part
def _extreme(torques: Solver, i: int, block: FloatArray, bracket: tuple[float, float],
             sign: float) -> float:  # fmt: skip
    """Largest value of sign times the torque between two places that hold one."""
    low, high = bracket
    best = 0.0
    for _ in range(_SEARCH_STEPS):
        third = (high - low) / 3.0
        left = sign * _value(torques, i, block, low + third)
        right = sign * _value(torques, i, block, high - third)
        best = max(best, left, right)
        if high - low < FLAT_EXTREME:
            break
        if left < right:
            low += third
        else:
            high -= third
    return best


@part
def _panel(torques: Solver, i: int, block: FloatArray, beaten: float) -> float:
    """Largest torque of a panel; less may be returned than ``beaten``."""
    numbers = block[rows.KEPT]
    order, end = int(numbers[panels.NODES]), numbers[panels.COVERED]
    count = _PER_NODE * order
    if order == 0:
        cells = torques.one.speed * numbers[panels.LENGTH] * torques.charts.numbers[i, rows.PER_RAD]
        count = max(_LEAST, int(_PER_CELL * cells) + 1)
    most, old = 0.0, _value(torques, i, block, 0.0)
    older = new = _value(torques, i, block, end / count)
    for j in range(count + 1):
        most = max(most, abs(old))
        # Beyond both ends it is taken as mirrored.
        if (old - older) * (new - old) <= 0.0:
            # Between places it goes beyond them by less than it changes beside them.
            reach = abs(old) + max(abs(old - older), abs(new - old))
            if reach > max(most, beaten):
                sign = 1.0 if old > 0.0 else -1.0
                bracket = end * max(j - 1, 0) / count, end * min(j + 1, count) / count
                most = max(most, _extreme(torques, i, block, bracket, sign))
        older, old = old, new
        new = _value(torques, i, block, end * (j + 2) / count) if j + 2 <= count else older
    return most


@part
def _off(sizes: FloatArray, fastest: float, du: float, dx: float, dv: float) -> float:
    """Bound on the error of a sum of functions at errors of travel, gap and rate."""
    wrong = size(sizes, rows.RESIDUAL, fastest) + size(sizes, rows.BY_U, fastest) * du
    wrong += size(sizes, rows.BY_X, fastest) * dx + size(sizes, rows.BY_V, fastest) * dv
    return float(wrong)


@part
def _wrong(solver: Solver, torques: Solver, i: int, at: Motion, fastest: float, steepest: float,
           da: float) -> float:  # fmt: skip
    """Bound on the error of a torque by those of the functions and of the motion.

    Args:
        at: A motion with the errors of that.
        fastest: Largest rate.
        steepest: Largest x''; zero at rest, which has no error of it.
        da: Bound on what the solver adds to the error of x''.
    """
    du, dx, dv = solver.one.speed * at.dt, at.dx, at.dv
    wrong = _off(torques.work.sizes[i], fastest, du, dx, dv)
    if steepest > 0.0:
        da += _off(solver.work.sizes[at.chart], fastest, du, dx, dv)
        # Of the function of x'' the bound on its error, and its largest value.
        wrong += torques.charts.gap_bounds[i, 0] * steepest + torques.charts.gap_bounds[i, 1] * da
    return float(wrong)


@part
def _along(solver: Solver, torques: Solver, c: int, i: int, block: FloatArray) -> float:
    """Bound on the error of the torque along a panel.

    The motion reaches each of its places late, so its travel, too, is off.
    """
    numbers = block[rows.KEPT]
    late, dx, dv = numbers[panels.T_WRONG], numbers[panels.X_WRONG], numbers[panels.V_WRONG]
    order, h = int(numbers[panels.NODES]), numbers[panels.LENGTH]
    fastest = steepest = 0.0
    for j in range(order + 1 if order > 0 else 0):
        sigma = numbers[panels.COVERED] * j / order
        fastest = max(fastest, abs(rate_at(block, order, h, numbers[panels.V_BEGIN], sigma)))
        a = chebyshev(block, rows.SERIES, rows.ZERO, order, 2.0 * sigma - 1.0)
        steepest = max(steepest, abs(a))
    at = Motion(c, 0.0, 0.0, 0.0, 0.0, late, dx, dv)
    return _wrong(solver, torques, i, at, fastest, steepest, numbers[panels.A_WRONG])


@part
def _after_bounces(solver: Solver, torques: Solver, c: int, i: int,
                   block: FloatArray) -> tuple[float, float]:  # fmt: skip
    """Torque in bounces too small to be computed, and a bound on its error.

    At rest but for the acceleration of a flight; what their rate, gap and travel change is error.
    """
    u, w, charts = block[rows.KEPT, panels.FROM], block[rows.KEPT, panels.BOUNCED], solver.charts
    still = along(solver.work.line[c], charts.numbers[c, rows.PER_RAD], u)
    lasts = 2.0 * w / (-still * (1.0 - solver.one.restitution[charts.stops[c, rows.OWN]]))
    at = Motion(c, u, 0.0, 0.0, 0.0, lasts, 0.5 * w * w / -still, w)
    wrong = _wrong(solver, torques, i, at, w, -still, 0.0)
    return abs(torque_at(torques, i, u, 0.0, 0.0, still)), wrong


@part
def largest_torques(solver: Solver, torques: Solver, most: FloatArray, wrong: FloatArray) -> None:
    """Largest torque of each drive in the motion that is kept.

    Args:
        solver: With the motion.
        torques: With the charts of the torques.
        most: Written, shape (drives,).
        wrong: Written: bounds on the errors, likewise.
    """
    drives = len(most)
    for d in range(drives):
        largest = beside = bounced = 0.0
        for number in range(solver.records.counts[rows.PANELS]):
            block = solver.records.panels[number]
            c = int(block[rows.KEPT, panels.CHART])
            i = c * drives + d
            reach(torques, i, 0.0, torques.charts.numbers[i, rows.TRAVEL_MOST])
            largest = max(largest, _panel(torques, i, block, largest))
            # An extreme that is just beaten may be the larger one by its error.
            beside = max(beside, _along(solver, torques, c, i, block))
            if block[rows.KEPT, panels.BOUNCED] > 0.0:
                value, off = _after_bounces(solver, torques, c, i, block)
                largest, bounced = max(largest, value), max(bounced, value + off)
        most[d], wrong[d] = largest, max(beside, bounced - largest)


@compiled
def run_torques(grids: FloatArray, charts: Charts, torques: Charts, cases: FloatArray,
                settings: Settings, job: Job, panels: int, events: FloatArray,
                told: NDArray[np.int64], found: FloatArray) -> None:  # fmt: skip
    """Largest torques of the last turns of many cases.

    The turns are followed once more, and the last of them again with their motion kept.

    Args:
        panels: Panels of the motion of a turn that are kept.
        events: Scratch, shape (most, COLUMNS).
        told: Written: the status, shape (n,).
        found: Written, shape (n, last, 2, drives): largest torques and bounds on their errors, the
            last turn first; NaN before the first one.
    """
    found[:] = np.nan
    works = scratch(charts, job.bounces), scratch(torques, 0)
    # Of the first run only the ends of turns are read later on.
    records = records_in(events, job.turns, 0), records_in(events, 1, panels)
    _all(grids, charts, torques, works, cases, settings, job, records, told, found)


@part
def _all(grids: FloatArray, charts: Charts, torques: Charts, works: tuple[Work, Work],
         cases: FloatArray, settings: Settings, job: Job, records: tuple[Records, Records],
         told: NDArray[np.int64], found: FloatArray) -> None:  # fmt: skip
    """All cases, one after the other."""
    machine, drives = in_memory(charts), in_memory(torques)
    work, mixed = in_memory(works[0]), in_memory(works[1])
    first, again = in_memory(records[0]), in_memory(records[1])
    for i in range(len(cases)):
        one = in_memory(case_of(charts, cases[i]))
        solver = in_memory(Solver(grids, machine, work, one, first))
        keeper = in_memory(Solver(grids, machine, work, one, again))
        torques_of = in_memory(Solver(grids, drives, mixed, one, again))
        prepare(solver, rows.YES)
        prepare(torques_of, rows.NO)
        told[i] = _torques(solver, keeper, torques_of, settings, job, found[i])
        if told[i] != rows.AT_REST:
            found[i] = np.nan


@part
def _torques(solver: Solver, again: Solver, torques: Solver, settings: Settings, job: Job,
             found: FloatArray) -> int:  # fmt: skip
    """Largest torques of one of the cases; its status.

    Args:
        solver: Follows the turns.
        again: Follows one of them again, and keeps its motion.
        torques: With the charts of the torques.
    """
    start, turns = begun(job.begin, solver.one.speed), job.turns
    status, _ = follow(solver, settings, turns, start[0], start[1], job.clamp)
    done = solver.records.counts[rows.DONE]
    for j in range(min(len(found), done) if status == rows.AT_REST else 0):
        phase, at = start
        if done - 1 - j > 0:
            known, resting, at = begin_at(solver.records.ends, done - 1 - j)
            phase = RESTING if resting else FLYING
            if not known:
                return int(rows.UNTOLD)
        # A literal 1 would be a type of its own, for which all of it is compiled once more.
        status, _ = follow(again, settings, min(turns, 1), phase, at, job.clamp)
        if status != rows.AT_REST:
            return status
        largest_torques(again, torques, found[j, 0], found[j, 1])
    return status
