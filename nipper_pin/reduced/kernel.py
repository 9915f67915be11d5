"""Transitions of the reduced model, compiled: collisions, flights, rest, and the errors of all."""

from __future__ import annotations

from math import exp, pi

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .compiled import compiled, forget_stale
from .flight import flight
from .layout import (
    AMPLITUDE,
    AMPLITUDE_ERROR,
    ANGLE,
    APPROACH,
    AT_REST,
    BY_U,
    BY_V,
    BY_X,
    CASE_NUMBERS,
    COLUMNS,
    ENERGY,
    EPS,
    HIGH,
    IMPULSE,
    IMPULSE_ERROR,
    LEVELS,
    LOW,
    NOT_PRESSED,
    RATE_ERROR,
    REBOUND,
    REBOUND_ERROR,
    RESIDUAL,
    SCALE,
    SCRATCH_ROWS,
    SEPARATION,
    SIZES,
    SPEED,
    TIME,
    TIME_ERROR,
    TOO_MANY,
    TRAVEL_MOST,
    Tables,
    Work,
)
from .panel import acceleration, chebyshev, contract, mix

_POINTS = 8
# What the last extrapolations differ by may be less than the error of the better one: by up to 10
# in one of 20000 random cases, near the speed at which the stop is no longer pressed shut.
_SAFETY = 16.0
# A bounce's time and the next rate feel a change of x'' once and twice.
_FELT = 3.0


@compiled
def _limit(series: FloatArray, count: int, drift: float) -> tuple[float, float]:
    """Extrapolate times to zero rate by Neville's scheme; see hybrid/series.py."""
    first = max(0, count - _POINTS)
    size = count - first
    if size < 2:
        return np.inf, np.inf
    for i in range(first, count - 1):
        if series[1, i + 1] >= series[1, i]:
            return np.inf, np.inf
    for i in range(size):
        series[2, i] = series[0, first + i] - series[0, count - 1]
    best, best_error, previous, gained = np.inf, np.inf, 0.0, 0.0
    for order in range(1, size):
        for i in range(size - order):
            far, near = series[1, first + i], series[1, first + i + order]
            series[2, i] = (far * series[2, i + 1] - near * series[2, i]) / (far - near)
        last = series[2, size - order - 1]
        # Extrapolations may agree by chance. Each should gain about the ratio of its rates, but
        # no more than the change of x'' that is ahead: far bounces do not know of it.
        ratio = max(series[1, count - 1] / series[1, count - order], drift)
        error = max(abs(last - previous), ratio * gained)
        if error < best_error:
            best, best_error = last, error
        gained = abs(last - previous)
        previous = last
    return best, best_error


@compiled
def _sizes(tables: Tables, sizes: FloatArray, speed: float, gravity: float, stiffness: FloatArray,
           preload: FloatArray) -> None:  # fmt: skip
    """Sums of the terms of x'', all positive, with bounds in the places of the functions."""
    for row in range(3):
        values = tables.residual
        if row == BY_X:
            values = tables.steepest_x
        elif row == BY_U:
            values = tables.steepest_u
        total = speed * speed * values[0] + abs(gravity) * values[3]
        for k in range(len(stiffness)):
            total += abs(stiffness[k]) * (abs(preload[k]) * values[4 + 2 * k] + values[5 + 2 * k])
        sizes[row, 0], sizes[row, 1], sizes[row, 2] = total, speed * values[1], values[2]
    sizes[BY_V, 0], sizes[BY_V, 1] = speed * tables.largest[1], 2.0 * tables.largest[2]


@compiled
def _size(sizes: FloatArray, row: int, rate: float) -> float:
    """One of the sums at a rate of x."""
    return float(sizes[row, 0] + rate * (sizes[row, 1] + rate * sizes[row, 2]))


@compiled
def _flight_errors(sizes: FloatArray, speed: float, T: float, v: float, a: float, peak: float,
                   fastest: float, changed: float, left: float, dt: float,
                   dw: float) -> tuple[float, float, float]:  # fmt: skip
    """Errors at the end of a flight, by the formula in :func:`nipper_pin.reduced.build`.

    One more sweep would change x'' by no more than Lv T + Lx T^2 / 2 times the last change.

    Returns:
        Bounds on the errors of its duration, rate at the end and amplitude.
    """
    Lv, Lx = _size(sizes, BY_V, fastest), _size(sizes, BY_X, fastest)
    Lt = speed * _size(sizes, BY_U, fastest)
    felt = min(Lv * T + 0.5 * Lx * T * T, 50.0)
    steady = felt * changed + _size(sizes, RESIDUAL, fastest) + Lt * dt
    e = steady + left
    K = exp(felt)
    rho = a * T / v
    duration = K * (dw * T + 0.5 * e * T * T) / abs(v) + 4.0 * EPS * T
    lever = abs(1.0 - 0.5 * rho)
    if rho > 1.0:
        lever = (1.0 + (rho - 1.0) ** 2) / (2.0 * rho)
    growth = abs(1.0 - rho) + (K - 1.0) * (1.0 + abs(rho))
    # What a grid misses changes its sign, so that it may act on the rate and not on the time.
    rate = growth * dw + K * (steady * lever + left) * T + 4.0 * EPS * abs(v)
    return duration, rate, K * (dw * peak + 0.5 * e * peak * peak)


@compiled
def _drift(sizes: FloatArray, speed: float, w: float, a: float, ahead: float) -> float:
    """Bound on the relative error of what is ahead of a series with constant acceleration."""
    by_time = speed * ahead * _size(sizes, BY_U, w)
    by_gap = 0.5 * w * w / -a * _size(sizes, BY_X, w)
    by_rate = 2.0 * w * _size(sizes, BY_V, w)
    return float(min(_FELT * (by_time + by_gap + by_rate) / -a, 1.0))


@compiled
def _inertia(tables: Tables, u: float) -> float:
    """Effective inertia at x = 0."""
    cells, count = tables.inertia.shape
    width = tables.travel / cells
    cell = min(max(int(u / width), 0), cells - 1)
    place = 2.0 * (u - cell * width) / width - 1.0
    return chebyshev(tables.inertia, cell, 0, count, place)


@compiled
def _transition(grids: FloatArray, tables: Tables, work: Work, speed: float, restitution: float,
                stiffness: FloatArray, preload: FloatArray, gravity: float, rest_rate: float,
                tolerance: float, table: FloatArray) -> tuple[int, int, float, float]:  # fmt: skip
    """One transition into a table of shape (COLUMNS, collisions).

    Returns:
        Status, number of collisions, time of rest, bound on its error.
    """
    case, mixed, poly, nodes, series = work.case, work.mixed, work.poly, work.nodes, work.series
    sizes = work.sizes
    degree = tables.equation.shape[3]
    case[SPEED], case[TRAVEL_MOST] = speed, tables.travel
    case[LOW], case[HIGH] = tables.low, tables.high
    case[SCALE] = 2.0 / (tables.high - tables.low)
    mix(tables, mixed, speed, gravity, stiffness, preload)
    _sizes(tables, sizes, speed, gravity, stiffness, preload)
    smallest = tolerance ** (1.0 / 3.0)
    most = table.shape[1]
    t = dt = dw = 0.0
    before = tables.approach * speed
    fastest_rebound = 0.0
    rest, rest_error = np.nan, np.nan
    dv = tables.approach_residual * speed
    for n in range(most):
        u = speed * t
        w = -restitution * before
        dw = restitution * dv
        C = _inertia(tables, u)
        table[TIME, n] = t
        table[ANGLE, n] = tables.touch_angle + tables.sense * u
        table[APPROACH, n] = before
        table[SEPARATION, n] = w
        table[IMPULSE, n] = C * (1.0 + restitution) * -before / tables.lever
        table[ENERGY, n] = 0.5 * C * (1.0 - restitution * restitution) * before * before
        table[TIME_ERROR, n] = dt
        table[RATE_ERROR, n] = dv
        # The inertia changes by less than itself over the whole domain.
        relative = tables.inertia_residual + speed * dt / tables.travel
        about_stop = C * (1.0 + restitution) * (dv + abs(before) * relative)
        table[IMPULSE_ERROR, n] = about_stop / tables.lever
        table[AMPLITUDE, n] = table[REBOUND, n] = 0.0
        table[AMPLITUDE_ERROR, n] = table[REBOUND_ERROR, n] = 0.0
        contract(mixed, poly, poly.shape[0] - 1, tables.travel, u)
        still = acceleration(case, poly, degree, 0.0, 0.0)
        if w <= 0.0:
            return (AT_REST if still < 0.0 else NOT_PRESSED), n + 1, t, dt
        fastest_rebound = max(fastest_rebound, w)
        series[0, n] = t
        series[1, n] = w
        if rest_rate > 0.0:
            found = w < rest_rate and still < 0.0
            ahead, uncertain = 0.0, 0.0
        else:
            a = acceleration(case, poly, degree, 0.0, w)
            ahead, uncertain = np.inf, np.inf
            if a < 0.0 and restitution < 1.0:
                ahead = -2.0 * w / (a * (1.0 - restitution))
            whole = t + ahead
            found = ahead <= tolerance * 2.0 * pi / speed
            if found or w <= smallest * fastest_rebound:
                drift = _drift(sizes, speed, w, a, ahead)
                if found:
                    uncertain = ahead * drift
                else:
                    limit, uncertain = _limit(series, n + 1, drift)
                    found = uncertain <= tolerance * whole
                    ahead = limit if found else ahead
            found = found and still < 0.0
        if found:
            rest = t + ahead
            # What is ahead is proportional to the rate that it starts with.
            rest_error = dt + _SAFETY * uncertain + abs(ahead) * (dw / w)
        ended, T, v, top, peak, a, fastest, changed, left = flight(
            grids, case, mixed, poly, nodes, degree, u, w, tolerance, n == 0
        )
        status = int(ended)
        if status != AT_REST:
            table[AMPLITUDE, n] = table[REBOUND, n] = np.nan
            table[AMPLITUDE_ERROR, n] = table[REBOUND_ERROR, n] = np.nan
            return (AT_REST if found else status), n + 1, rest, rest_error
        duration, dv, height = _flight_errors(
            sizes, speed, T, v, a, peak, fastest, changed, left, dt, dw
        )
        table[AMPLITUDE, n] = top
        table[AMPLITUDE_ERROR, n] = height + 4.0 * EPS * top
        table[REBOUND, n] = T
        table[REBOUND_ERROR, n] = duration
        if found:
            return AT_REST, n + 1, rest, rest_error
        t += T
        dt += duration
        before = v
    return TOO_MANY, most, rest, rest_error


@compiled
def _scratch(tables: Tables, most: int) -> Work:
    """Scratch arrays."""
    _, cells, count_u, count_x = tables.equation.shape
    rows = (3 + tables.gaps.shape[0]) * count_x
    finest = LEVELS[-1]
    return Work(
        np.zeros(CASE_NUMBERS), np.zeros((cells, count_u, rows)), np.zeros((finest + 1, rows)),
        np.zeros((SCRATCH_ROWS, finest + 2)), np.zeros((3, most)),
        np.zeros((SIZES, 3)),
    )  # fmt: skip


@compiled
def _summary(
    table: FloatArray, status: int, count: int, rest: float, error: float
) -> tuple[float, float, float, float]:
    """Duration, its error, share of the first two rebounds, worst relative error of four."""
    if status != AT_REST:
        return np.nan, np.nan, np.nan, np.nan
    share = table[TIME, 2] / rest if count > 2 and rest > 0.0 else np.nan
    bound = error / rest if rest > 0.0 else 0.0
    if table[AMPLITUDE, 0] > 0.0:
        bound = max(bound, table[AMPLITUDE_ERROR, 0] / table[AMPLITUDE, 0])
    for n in range(min(2, count)):
        if table[REBOUND, n] > 0.0:
            bound = max(bound, table[REBOUND_ERROR, n] / table[REBOUND, n])
    return rest, error, share, bound


@compiled
def run_one(grids: FloatArray, tables: Tables, speed: float, restitution: float,
            stiffness: FloatArray, preload: FloatArray, gravity: float, rest_rate: float,
            tolerance: float, most: int,
            ) -> tuple[int, tuple[float, float, float, float], FloatArray]:  # fmt: skip
    """One transition; see :func:`run_batch`.

    Returns:
        Status, what :func:`run_batch` writes to ``rest``, and the table, shape (COLUMNS, count).
    """
    table = np.empty((COLUMNS, most))
    status, count, rest, error = _transition(
        grids, tables, _scratch(tables, most), speed, restitution, stiffness, preload, gravity,
        rest_rate, tolerance, table,
    )  # fmt: skip
    return status, _summary(table, status, count, rest, error), table[:, :count].copy()


@compiled
def run_batch(grids: FloatArray, tables: Tables, speed: FloatArray, restitution: FloatArray,
              stiffness: FloatArray, preload: FloatArray, gravity: FloatArray, rest_rate: float,
              tolerance: float, table: FloatArray, status: NDArray[np.int64],
              counts: NDArray[np.int64], rest: FloatArray) -> None:  # fmt: skip
    """Transitions of a batch.

    Args:
        grids: Collocation grids.
        tables: The reduced model.
        speed: Cylinder speeds, shape (n,) [rad/s].
        restitution: Shape (n,).
        stiffness: Shape (n, springs).
        preload: Shape (n, springs).
        gravity: By the gravity of the model, shape (n,).
        rest_rate: Threshold of rest, or 0 for the limit of the series.
        tolerance: Relative accuracy of flights and of the limit.
        table: Written: collisions, shape (n, COLUMNS, most), filled with NaN beforehand.
        status: Written: shape (n,), integers.
        counts: Written: collisions, shape (n,), integers.
        rest: Written, shape (n, 4): time of rest and its error [s], share of the first two
            rebounds in it, bound on the worst relative error.
    """
    work = _scratch(tables, table.shape[2])
    for i in range(len(speed)):
        status[i], counts[i], end, error = _transition(
            grids, tables, work, speed[i], restitution[i], stiffness[i], preload[i], gravity[i],
            rest_rate, tolerance, table[i],
        )  # fmt: skip
        rest[i, 0], rest[i, 1], rest[i, 2], rest[i, 3] = _summary(
            table[i], status[i], counts[i], end, error
        )


forget_stale(__file__)
