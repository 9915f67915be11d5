"""How errors grow along a panel of a flight, compiled.

An error (dx, dv) obeys dx'' = a_x dx + a_v dv + e, a_x and a_v the derivatives of x'' along the
motion. Over a panel it is (dx, dv) -> Phi (dx, dv) + r e. The errors e of the panels may have any
signs, so what becomes of them is added by absolute values.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .compiled import compiled
from .hits import Held
from .layout import GROWTH, LOW, SCALE, SPAN, SPEED
from .panel import chebyshev, contract, position, rate_at

# Steps of a panel; panels are shorter than a period of what they resolve.
_STEPS = 16


@compiled
def begin_growth(nodes: FloatArray) -> None:
    """Mark that no panel has been traced yet."""
    nodes[GROWTH, 0] = np.nan


@compiled
def grow(held: Held, end: float) -> None:
    """Carry the growth of errors over a panel up to ``end``.

    The row GROWTH holds what becomes of dx = 1 and dv = 1 at the start of the flight and of e = 1:
    three errors of x, then three of x'.
    """
    nodes = held.nodes
    g = nodes[GROWTH]
    if np.isnan(g[0]):
        g[0], g[1], g[2], g[3], g[4], g[5] = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    xx, xv, vx, vv, rx, rv = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0
    h = held.h * end / _STEPS
    for step in range(_STEPS):
        by_x, by_v = _slopes(held, end * (step + 0.5) / _STEPS)
        # The exponential of the step to second order.
        a, b = 1.0 + 0.5 * h * h * by_x, h + 0.5 * h * h * by_v
        c, d = h * by_x * (1.0 + 0.5 * h * by_v), 1.0 + h * by_v + 0.5 * h * h * (by_x + by_v**2)
        xx, vx = a * xx + b * vx, c * xx + d * vx
        xv, vv = a * xv + b * vv, c * xv + d * vv
        rx, rv = a * rx + b * rv + 0.5 * h * h, c * rx + d * rv + b
    for k in range(2):
        x, v = g[k], g[3 + k]
        g[k], g[3 + k] = xx * x + xv * v, vx * x + vv * v
    x, v = g[2], g[5]
    g[2] = abs(xx) * x + abs(xv) * v + abs(rx)
    g[5] = abs(vx) * x + abs(vv) * v + abs(rv)


@compiled
def _slopes(held: Held, sigma: float) -> tuple[float, float]:
    """Derivatives of x'' by x and by x' at a place of a panel."""
    case, poly, degree = held.case, held.poly, held.degree
    row = poly.shape[0] - 1
    contract(held.mixed, poly, row, case[SPAN], held.u + held.h * case[SPEED] * sigma)
    x = position(held.nodes, held.order, held.h, held.x0, held.v0, sigma)
    v = rate_at(held.nodes, held.order, held.h, held.v0, sigma)
    place = case[SCALE] * (x - case[LOW]) - 1.0
    by_v = chebyshev(poly, row, degree, degree, place)
    by_v += 2.0 * v * chebyshev(poly, row, 2 * degree, degree, place)
    older, old, by_x = 0.0, 1.0, 0.0
    for m in range(1, degree):
        # T_m' = m U_(m-1).
        terms = poly[row, m] + v * (poly[row, degree + m] + v * poly[row, 2 * degree + m])
        by_x += m * terms * old
        older, old = old, 2.0 * place * old - older
    return case[SCALE] * by_x, by_v
