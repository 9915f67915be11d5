"""Bounds on the errors of flights, compiled.

An error (dx, dv) obeys dx'' = a_x dx + a_v dv + e, a_x and a_v the derivatives of x'' along the
motion. Over a panel it is (dx, dv) -> Phi (dx, dv) + r e. The errors e of the panels may have any
signs, so what becomes of them is added by absolute values.

Error of a case, as the kernel propagates it: an error of x'' of at most

    eps = r0 w^2 + r1 w |x'| + r2 x'^2 + rg + sum_k k (r_k |p| + r_ks) + solver's

(r the residuals) and errors dt, dw of time and rate at the start of a flight of length T that
ends with rate v and acceleration a change, by Gronwall's lemma with F = Lv T + Lx T^2 / 2,
K = exp(F), e = eps + Lt dt and rho = a T / v (2 for a ballistic flight),

    |dT|  <= K (dw T + e T^2 / 2) / |v|,
    |dv|  <= (|1 - rho| + (K - 1) (1 + |rho|)) dw + K e T int_0^1 |1 - rho s| ds,

The solver's part is F times the last change of x'' in the iteration, plus the defect between
nodes: the equation of motion is evaluated at three points between the nodes, and a defect d
there acts like a steady error of less than 12 d / n^2 on n nodes, since polynomials of the
degrees that are missing nearly cancel when they are integrated. That they do not act alike on
time and rate is allowed for: this part has at least 1 in the place of the last integral.

The change of x'' by a late start, Lt dt, is nearly constant along a short flight: for it the
last integral has no modulus, |1 - rho / 2|, and 4 times the travel of the flight in
radians of that with it.

Lv, Lx, Lt are Lipschitz constants of x'' by rate, coordinate and time from the largest
values and derivatives of the tables. Times add up; the restitution scales dv to the next dw.
"""

from __future__ import annotations

from math import exp

from ...arrays import FloatArray
from ...tolerances.mechanics import EPS
from . import layout as rows
from .compiled import part
from .hits import SolvedPanel
from .layout import Case, Flown
from .panel import chebyshev, combine, contract, place_of, position, rate_at

# Steps of a panel; panels are shorter than a period of what they resolve.
_STEPS = 16


@part
def grow(solved: SolvedPanel, end: float) -> None:
    """Carry the growth of errors over a panel up to ``end``.

    The row GROWTH holds what becomes of dx = 1 and dv = 1 at the start of the flight and of e = 1:
    three errors of x, then three of x'.
    """
    g = solved.solver.work.nodes[rows.GROWTH]
    xx, xv, vx, vv, rx, rv = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0
    h = solved.h * end / _STEPS
    for step in range(_STEPS):
        by_x, by_v = _slopes(solved, end * (step + 0.5) / _STEPS)
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


@part
def _slopes(solved: SolvedPanel, sigma: float) -> tuple[float, float]:
    """Derivatives of x'' by x and by x' at a place of a panel."""
    solver, c = solved.solver, solved.c
    poly, nodes, number = solver.work.poly, solver.work.nodes, solver.charts.numbers[c]
    row, degree, order = len(poly) - 1, solver.charts.equation.shape[4], rows.LEVELS[solved.level]
    contract(solver, c, row, solved.u + solved.h * solver.one.speed * sigma)
    x = position(nodes, order, solved.h, solved.x0, solved.v0, sigma)
    v = rate_at(nodes, order, solved.h, solved.v0, sigma)
    place = place_of(number, x)
    by_v = chebyshev(poly, row, degree, degree, place)
    by_v += 2.0 * v * chebyshev(poly, row, 2 * degree, degree, place)
    older, old, by_x = 0.0, 1.0, 0.0
    for m in range(1, degree):
        # T_m' = m U_(m-1).
        terms = poly[row, m] + v * (poly[row, degree + m] + v * poly[row, 2 * degree + m])
        by_x += m * terms * old
        older, old = old, 2.0 * place * old - older
    return number[rows.SCALE] * by_x, by_v


# A change of x'' enters the time of a bounce once and the next rate twice.
_FELT = 3.0
# Part of a late start's change of x'' that is not the same all along a flight, by its travel in
# radians: what drives and links prescribe changes by itself in about one.
_UNEVEN = 4.0


@part
def sizes_of(bounds: FloatArray, sizes: FloatArray, one: Case) -> None:
    """Write sums of the terms of x'', all positive, with bounds in the places of the functions.

    Args:
        bounds: Those of a chart, shape (functions, SIZES).
        sizes: Shape (3 SIZES,).
    """
    combine(bounds, one, rows.YES, sizes)
    # b x' + c x'^2 changes with x' by b + 2 c x'.
    by_v, with_v, squared = rows.BY_V, rows.SIZES + rows.BY_V, 2 * rows.SIZES + rows.BY_V
    sizes[by_v], sizes[with_v], sizes[squared] = sizes[with_v], 2.0 * sizes[squared], 0.0


@part
def size(sizes: FloatArray, row: int, rate: float) -> float:
    """One of the sums at a rate of x."""
    with_v, squared = sizes[rows.SIZES + row], sizes[2 * rows.SIZES + row]
    return float(sizes[row] + rate * (with_v + rate * squared))


@part
def exponent(sizes: FloatArray, fastest: float, T: float) -> float:
    """Exponent F of Gronwall's lemma for a time T."""
    by_v, by_x = size(sizes, rows.BY_V, fastest), size(sizes, rows.BY_X, fastest)
    return min(by_v * T + 0.5 * by_x * T * T, 50.0)


@part
def of_solver(sizes: FloatArray, flown: Flown) -> float:
    """Bound on what the solver adds to the error of x'' in a flight.

    One more sweep would change x'' by no more than Lv T + Lx T^2 / 2 times the last change.
    """
    return min(exponent(sizes, flown.fastest, flown.T), 1.0) * flown.changed + flown.left


@part
def flight_errors(sizes: FloatArray, speed: float, flown: Flown, dt: float,
                  dw: float) -> tuple[float, float, float]:  # fmt: skip
    """Errors at the end of a flight, by the formula at the head of this module.

    Returns:
        Bounds on the errors of its duration, rate at the end and amplitude.
    """
    T, v, fastest, left, peak = flown.T, flown.v, flown.fastest, flown.left, flown.peak
    Lt = speed * size(sizes, rows.BY_U, fastest)
    felt = exponent(sizes, fastest, T)
    # A late start changes x'' by nearly a constant along the flight.
    shifted = Lt * dt
    steady = felt * flown.changed + size(sizes, rows.RESIDUAL, fastest)
    e = steady + shifted + left
    K = exp(felt)
    rho = flown.a * T / v
    duration = K * (dw * T + 0.5 * e * T * T) / abs(v) + 4.0 * EPS * T
    lever = abs(1.0 - 0.5 * rho)
    if rho > 1.0:
        lever = (1.0 + (rho - 1.0) ** 2) / (2.0 * rho)
    growth = abs(1.0 - rho) + (K - 1.0) * (1.0 + abs(rho))
    # The defect of a grid changes its sign, so it may act on the rate without acting on the time.
    even = min(abs(1.0 - 0.5 * rho) + _UNEVEN * speed * T * lever, lever)
    known = steady * lever + shifted * even + left * max(lever, 1.0)
    rate = growth * dw + K * known * T + 4.0 * EPS * abs(v)
    return duration, rate, K * (dw * peak + 0.5 * e * peak * peak)


@part
def drift(sizes: FloatArray, speed: float, w: float, a: float, ahead: float) -> float:
    """Bound on the relative error of the remaining duration of a bounce series."""
    by_time = speed * ahead * size(sizes, rows.BY_U, w)
    by_gap = 0.5 * w * w / -a * size(sizes, rows.BY_X, w)
    by_rate = 2.0 * w * size(sizes, rows.BY_V, w)
    return float(min(_FELT * (by_time + by_gap + by_rate) / -a, 1.0))
