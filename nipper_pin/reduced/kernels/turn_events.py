"""Events of a turn and bounds on their errors, compiled."""

from __future__ import annotations

from math import exp, pi

import numpy as np

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import GROWTH_SAFETY
from . import layout as rows
from . import turn_layout as columns
from .arrival_check import within
from .compiled import part
from .flight_errors import exponent, size
from .panel import along, cell_at
from .turn_layout import Charts

_TURN = 2.0 * pi


@part
def errors_after(nodes: FloatArray, sizes: FloatArray, speed: float, T: float, fastest: float,
                 changed: float, left: float, dt: float, dx: float, dw: float, bend: float,
                 ) -> tuple[float, float]:  # fmt: skip
    """Errors of x and x' after a time T, of a flight that began with these errors.

    A long flight has told how errors grow along it; of a short one Gronwall's lemma does. With
    ``bend`` = x'' / x' at the end the second error is that of x' where x is zero.
    """
    felt = exponent(sizes, fastest, T)
    late = speed * size(sizes, rows.BY_U, fastest) * dt
    e = min(felt, 1.0) * changed + size(sizes, rows.RESIDUAL, fastest) + late + left
    g = nodes[rows.GROWTH]
    if not np.isnan(g[0]):
        x = GROWTH_SAFETY * (abs(g[0]) * dx + abs(g[1]) * dw + g[2] * e)
        v = abs(g[3] - bend * g[0]) * dx + abs(g[4] - bend * g[1]) * dw
        v = GROWTH_SAFETY * (v + (g[5] + abs(bend) * g[2]) * e)
    else:
        K = exp(felt)
        x = K * (dx + dw * T + 0.5 * e * T * T)
        v = K * (dw + (e + size(sizes, rows.BY_X, fastest) * dx) * T) + abs(bend) * x
    return x, v + 4.0 * EPS * fastest


@part
def collide(charts: Charts, events: FloatArray, n: int, c: int, speed: float, e_N: float,
             turn: int, t: float, u: float, v: float, dt: float, dv: float) -> None:  # fmt: skip
    """Write a collision of a chart's stop at travel u with rate v before it."""
    C = along(charts.inertia[c], charts.span[c], u)
    lever = charts.lever[charts.stop[c]]
    row = events[n]
    row[columns.KIND], row[columns.STOP], row[columns.TIME] = columns.COLLISION, charts.stop[c], t
    row[columns.TRAVEL] = _TURN * turn + charts.begin[c] + u
    row[columns.APPROACH], row[columns.SEPARATION] = v, -e_N * v
    row[columns.IMPULSE] = C * (1.0 + e_N) * -v / lever
    row[columns.ENERGY] = 0.5 * C * (1.0 - e_N * e_N) * v * v
    row[columns.AMPLITUDE] = row[columns.AMPLITUDE_ERROR] = np.nan
    row[columns.TIME_ERROR], row[columns.RATE_ERROR] = dt + 4.0 * EPS * t, dv
    # The inertia changes by less than itself over a chart.
    relative = charts.inertia_residual[c] + speed * dt / charts.travel[c]
    row[columns.IMPULSE_ERROR] = C * (1.0 + e_N) * (dv + abs(v) * relative) / lever
    by_rate = abs(v) * (dv + abs(v) * relative) + dv * dv
    row[columns.ENERGY_ERROR] = C * (1.0 - e_N * e_N) * by_rate


@part
def note(events: FloatArray, n: int, kind: int, stop: int, t: float, travel: float,
          dt: float) -> None:  # fmt: skip
    """Write a rest or a release."""
    row = events[n]
    row[:] = np.nan
    row[columns.KIND], row[columns.STOP] = kind, stop
    row[columns.TIME], row[columns.TRAVEL] = t, travel
    row[columns.TIME_ERROR] = dt + 4.0 * EPS * t


@part
def release_error(line: FloatArray, sizes: FloatArray, span: float, u: float) -> float:
    """Bound on the error of the travel at which the force of a stop has fallen to zero."""
    width = span / line.shape[0]
    cell, _ = cell_at(span, line.shape[0], u)
    step = 1e-3 * width
    later, before = within(line, cell, width, u + step), within(line, cell, width, u - step)
    slope = (later - before) / (2.0 * step)
    return float(size(sizes, rows.RESIDUAL, 0.0) / max(abs(slope), 1e-300))
