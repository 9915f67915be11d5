"""Arrival of a turn at the touch, compiled: opening, bounces and rests of the waiting stop.

Motion after a rest is independent of the motion before it. Whether the machine rests is computed
with low accuracy; only flight at the touch is computed accurately, from the last rest on.
"""

from __future__ import annotations

from math import exp

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import (
    BEFORE_TOUCH,
    FLIGHT_UNRESOLVED,
    FORCE_SIGN,
    LATE_REST_SAFETY,
    PHASE_TOLERANCE,
    STEADY_DECELERATION,
)
from . import layout as rows
from .compiled import part
from .flight import flight
from .flight_errors import drift, exponent, flight_errors, size
from .layout import Case, Charts, Turn, Work
from .panel import acceleration, along, chebyshev, contract

_MOST_FLIGHTS = 64
_PLACES = 24
_ROOT_STEPS = 60


@part
def line(functions: FloatArray, one: Case, found: FloatArray) -> None:
    """Combine functions along a stop for a case, one row a cell."""
    stiffness, preload = one.stiffness, one.preload
    for cell in range(functions.shape[1]):
        for i in range(functions.shape[2]):
            value = one.speed**2 * functions[0, cell, i] + one.gravity * functions[3, cell, i]
            for k in range(len(stiffness)):
                unit = preload[k] * functions[4 + 2 * k, cell, i] + functions[5 + 2 * k, cell, i]
                value += stiffness[k] * unit
            found[cell, i] = value


@part
def released(line: FloatArray, length: float, begin: float, end: float) -> float:
    """First place in [begin, end] from which on the force of a stop is zero or below.

    Returns:
        The place; ``end`` plus 1 if there is none; -1 if round-off hides the sign.
    """
    cells, count = line.shape
    width = length / cells
    scale = 0.0
    for cell in range(cells):
        scale = max(scale, abs(line[cell, 0]))
    beside = FORCE_SIGN * scale
    older = old = -np.inf
    for cell in range(min(max(int(begin / width), 0), cells - 1), cells):
        left, right = max(begin, cell * width), min(end, (cell + 1) * width)
        if left >= right:
            break
        bound = line[cell, 0]
        for i in range(1, count):
            bound += abs(line[cell, i])
        if bound < -beside:
            older = old = -np.inf
            continue
        step = (right - left) / _PLACES
        for j in range(_PLACES + 1):
            u = left + step * j
            value = within(line, cell, width, u)
            if value > 0.0:
                return u if old == -np.inf else _crossing(line, length, u - step, u)
            if j == 0:
                # The end of the cell before.
                old = value if old == -np.inf else old
                continue
            # Between places it is higher by less than it falls beside them.
            fall = old - value if older == -np.inf else old - min(older, value)
            if old >= older and old >= value and old + fall > 0.0:
                top = _top(line, length, max(begin, u - 2.0 * step), u)
                highest = along(line, length, top)
                if abs(highest) <= beside:
                    return -1.0
                if highest > 0.0:
                    return _crossing(line, length, max(begin, u - 2.0 * step), top)
            older, old = old, value
    return -1.0 if old > -beside and old > -np.inf else end + 1.0


@part
def within(line: FloatArray, cell: int, width: float, u: float) -> float:
    """Value of a series of the travel at a place of a cell, or beside it."""
    return chebyshev(line, cell, 0, line.shape[1], 2.0 * (u - cell * width) / width - 1.0)


@part
def _top(line: FloatArray, length: float, low: float, high: float) -> float:
    """Place of the largest value between two places that hold one."""
    for _ in range(_ROOT_STEPS):
        third = (high - low) / 3.0
        left, right = low + third, high - third
        if along(line, length, left) < along(line, length, right):
            low = left
        else:
            high = right
    return 0.5 * (low + high)


@part
def _crossing(line: FloatArray, length: float, low: float, high: float) -> float:
    """Rising zero of a line, on its far side."""
    for _ in range(_ROOT_STEPS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if along(line, length, middle) > 0.0:
            high = middle
        else:
            low = middle
    return high


@part
def arrives(grids: FloatArray, y: Charts, turn: Turn, work: Work, speed: float,
            rest_rate: float) -> tuple[int, float, float]:  # fmt: skip
    """Decide in which phase the machine arrives at the touch.

    Args:
        y: Functions of (u, y), combined for the case in ``work``.
        turn: The rest of the turn.
        work: Scratch arrays of these tables, with y'' along y = 0 combined for the case.
        speed: Cylinder speed [rad/s].
        rest_rate: Threshold of rest, or 0.

    Returns:
        HOLDS, FAILS or UNKNOWN; of a machine that is in flight at the touch the travel and rate at
        which it left its stop, independent of the motion before: at a release, or at the opening.
    """
    case, mixed, poly, nodes = work.case[0], work.mixed[0], work.poly, work.nodes
    press = work.line[0]
    degree, e_N, touch = y.equation.shape[4], turn.restitution, case[rows.TRAVEL_MOST]
    u, w = 0.0, -turn.restitution * case[rows.ARRIVE] * speed
    u_free, w_free = u, w
    at_opening = True
    for _ in range(_MOST_FLIGHTS):
        resting = w <= 0.0
        if not resting:
            contract(mixed, poly, poly.shape[0] - 1, touch, u)
            still = acceleration(case, poly, degree, 0.0, 0.0)
            a = acceleration(case, poly, degree, 0.0, w)
            if rest_rate > 0.0:
                resting = w < rest_rate and still < 0.0
            elif a < 0.0 and still < 0.0 and e_N < 1.0:
                ahead = -2.0 * w / (a * (1.0 - e_N))
                over = u + LATE_REST_SAFETY * speed * ahead
                steady = drift(work.sizes[0], speed, w, a, ahead) < STEADY_DECELERATION
                if over < touch - BEFORE_TOUCH and steady:
                    next_one = released(press, touch, u, touch)
                    if next_one < 0.0:
                        return rows.UNKNOWN, 0.0, 0.0
                    resting = next_one > over
        if resting:
            u = released(press, touch, u, touch)
            if u < 0.0 or abs(u - touch) < BEFORE_TOUCH:
                return rows.UNKNOWN, 0.0, 0.0
            if u > touch:
                return rows.HOLDS, 0.0, 0.0
            w = 0.0
            u_free, w_free = u, w
        ended, T, v, _, _, _, _, _, _, _, _ = flight(
            grids, case, mixed, poly, nodes, degree, u, 0.0, w, PHASE_TOLERANCE, at_opening
        )
        at_opening = False
        if int(ended) == rows.LEFT_TRAVEL:
            return rows.FAILS, u_free, w_free
        if int(ended) != rows.AT_REST:
            return rows.UNKNOWN, 0.0, 0.0
        u += speed * T
        if u > touch - BEFORE_TOUCH:
            return rows.UNKNOWN, 0.0, 0.0
        w = -e_N * v
    return rows.UNKNOWN, 0.0, 0.0


@part
def in_flight(grids: FloatArray, y: Charts, turn: Turn, work: Work, speed: float, u: float,
              w: float, rest_rate: float, tolerance: float,
              ) -> tuple[bool, float, float, float, float]:  # fmt: skip
    """Solve the flight that is under way at the touch, from where the stop was left.

    Returns:
        Whether it was resolved; x and x' at the touch, and bounds on their errors.
    """
    case, mixed, poly, nodes, sizes = (
        work.case[0], work.mixed[0], work.poly, work.nodes, work.sizes[0]
    )  # fmt: skip
    degree = y.equation.shape[4]
    failed = (False, 0.0, 0.0, 0.0, 0.0)
    at_opening = u == 0.0
    dt, dw = 0.0, turn.restitution * case[rows.ARRIVE_ERROR] * speed if at_opening else 0.0
    for _ in range(_MOST_FLIGHTS):
        ended, T, v, _, peak, a, fastest, changed, left, x, _ = flight(
            grids, case, mixed, poly, nodes, degree, u, 0.0, w, tolerance, at_opening
        )
        at_opening = False
        status = int(ended)
        if status == rows.LEFT_TRAVEL:
            found, rate = x, v
            steady = changed + _steady(sizes, speed, fastest, dt) + left
            K = exp(exponent(sizes, fastest, T))
            dy = K * (dw * T + 0.5 * steady * T * T) + fastest * dt + 4.0 * EPS * abs(found)
            dv = K * (dw + steady * T) + abs(a) * dt + 4.0 * EPS * fastest
            if not dy < FLIGHT_UNRESOLVED * found:
                return failed
            place = case[rows.SCALE] * (found - case[rows.LOW]) - 1.0
            size_of = turn.touch.shape[1]
            x = chebyshev(turn.touch, 0, 0, size_of, place)
            by_y = chebyshev(turn.touch, 1, 0, size_of, place)
            by_u = chebyshev(turn.touch, 2, 0, size_of, place)
            # The derivatives change by less than themselves over the whole domain.
            bent = dy / (case[rows.HIGH] - case[rows.LOW])
            dx = abs(by_y) * dy + turn.touch_errors[0]
            dv = (
                abs(by_y) * dv
                + abs(rate) * (turn.touch_errors[1] + abs(by_y) * bent)
                + speed * (turn.touch_errors[2] + abs(by_u) * bent)
            )
            return True, x, by_y * rate + by_u * speed, dx, dv
        if status != rows.AT_REST:
            return failed
        duration, dv, _ = flight_errors(sizes, speed, T, v, a, peak, fastest, changed, left, dt, dw)
        u += speed * T
        dt += duration
        w, dw = -turn.restitution * v, turn.restitution * dv
        if w <= 0.0 or w < rest_rate:
            return failed
    return failed


@part
def _steady(sizes: FloatArray, speed: float, fastest: float, dt: float) -> float:
    """Error of y'' of the tables and of the time."""
    return size(sizes, rows.RESIDUAL, fastest) + speed * size(sizes, rows.BY_U, fastest) * dt


@part
def landed(sizes: FloatArray, speed: float, T: float, v: float, a: float, fastest: float,
           changed: float, left: float, dx: float, dw: float) -> tuple[float, float]:  # fmt: skip
    """Errors of time and rate at the end of a flight that starts with errors of x and x'."""
    felt = exponent(sizes, fastest, T)
    K = exp(felt)
    e = felt * changed + _steady(sizes, speed, fastest, 0.0) + left
    off = K * (dx + dw * T + 0.5 * e * T * T)
    dt = off / abs(v) + 4.0 * EPS * T
    rate = K * (dw + (e + size(sizes, rows.BY_X, fastest) * dx) * T) + abs(a) * dt
    return dt, rate + 4.0 * EPS * abs(v)
