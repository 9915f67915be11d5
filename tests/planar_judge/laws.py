"""Motions of the drives over the angle psi of the input shaft, with two derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray
Motion = Callable[[float], tuple[float, float, float]]


class Law(NamedTuple):
    """A coordinate over psi and its two derivatives; ``knots`` are where a polynomial changes."""

    motion: Motion
    knots: tuple[float, ...] = ()


def read_laws(drives: Mapping[str, Mapping[str, Any]]) -> dict[str, Law]:
    """Laws of all drives by name."""
    laws: dict[str, Law] = {}

    def law(name: str) -> Law:
        if name not in laws:
            item = drives[name]
            laws[name] = (
                _times(law(item["of"]), item["ratio"]) if "of" in item else _LAWS[item["law"]](item)
            )
        return laws[name]

    return {name: law(name) for name in drives}


def _times(law: Law, ratio: float) -> Law:
    def motion(psi: float) -> tuple[float, float, float]:
        value, first, second = law.motion(psi)
        return ratio * value, ratio * first, ratio * second

    return Law(motion, law.knots)


def _constant(item: Mapping[str, Any]) -> Law:
    return Law(lambda psi: (item["ratio"] * psi, item["ratio"], 0.0))


def _screw(item: Mapping[str, Any]) -> Law:
    lead = item["lead_mm_per_turn"] / 1000.0 / (2.0 * math.pi)
    return Law(lambda psi: (lead * psi, lead, 0.0))


def _guide(item: Mapping[str, Any]) -> Law:
    """Angle of a bar that turns about its axis and in which a crank pin slides.

    The pin p(psi) has the polar angle theta and distance rho from the guide axis, and the bar's
    line passes beside the axis by the offset e: angle = theta - asin(e / rho).
    """
    radius, offset = item["crank_radius_mm"] / 1000.0, item.get("guide_offset_mm", 0.0) / 1000.0
    centre = (np.array(item["crank_axis_mm"]) - np.array(item["guide_axis_mm"])) / 1000.0
    middle = math.atan2(centre[1], centre[0])

    def motion(psi: float) -> tuple[float, float, float]:
        out = np.array([math.cos(psi), math.sin(psi)])
        p, p1, p2 = centre + radius * out, radius * np.array([-out[1], out[0]]), -radius * out
        rho = math.hypot(*p)
        rho1 = p @ p1 / rho
        rho2 = (p1 @ p1 + p @ p2 - rho1 * rho1) / rho
        theta1 = (p[0] * p1[1] - p[1] * p1[0]) / rho**2
        theta2 = (p[0] * p2[1] - p[1] * p2[0]) / rho**2 - 2.0 * theta1 * rho1 / rho
        # Counted from the line of centres the angle never comes near half a turn.
        local = math.atan2(centre[0] * p[1] - centre[1] * p[0], centre[0] * p[0] + centre[1] * p[1])
        s = offset / rho
        cosine = math.sqrt(1.0 - s * s)
        s1 = -s * rho1 / rho
        s2 = -s1 * rho1 / rho - s * (rho2 / rho - (rho1 / rho) ** 2)
        asin1 = s1 / cosine
        asin2 = s2 / cosine + s * s1 * s1 / cosine**3
        return middle + local - math.asin(s), theta1 - asin1, theta2 - asin2

    return Law(motion)


def _fourier(item: Mapping[str, Any]) -> Law:
    """Fourier series, of an angle or a travel."""
    unit, scale = ("_mm", 1e-3) if any(key.endswith("_mm") for key in item) else ("_rad", 1.0)
    mean = item.get("mean" + unit, 0.0)
    cosine, sine = item.get("cosine" + unit, ()), item.get("sine" + unit, ())

    def motion(psi: float) -> tuple[float, float, float]:
        value, first, second = mean, 0.0, 0.0
        for n, c in enumerate(cosine, start=1):
            value += c * math.cos(n * psi)
            first -= n * c * math.sin(n * psi)
            second -= n * n * c * math.cos(n * psi)
        for n, s in enumerate(sine, start=1):
            value += s * math.sin(n * psi)
            first += n * s * math.cos(n * psi)
            second -= n * n * s * math.sin(n * psi)
        return scale * value, scale * first, scale * second

    return Law(motion)


def _table(item: Mapping[str, Any]) -> Law:
    """Periodic quintic spline through the rows of one turn, solved for here as B-splines."""
    from scipy.interpolate import BSpline

    key, scale = ("coordinate_mm", 1e-3) if "coordinate_mm" in item else ("coordinate_rad", 1.0)
    rows = np.radians(np.array(item["cylinder_angle_deg"], dtype=float))
    values = scale * np.array(item[key], dtype=float)[:-1]
    turn, count = 2.0 * math.pi, len(rows) - 1
    places = np.arange(-5, count + 6)
    knots = rows[:-1][places % count] + turn * (places // count)
    collocation = np.zeros((count, count))
    for column in range(count + 5):
        one = BSpline(knots, np.eye(count + 5)[column], 5)
        collocation[:, column % count] += one(knots[5 : 5 + count])
    weights = np.linalg.solve(collocation, values)
    spline = BSpline(knots, weights[np.arange(count + 5) % count], 5)
    slopes = spline.derivative(1), spline.derivative(2)

    def motion(psi: float) -> tuple[float, float, float]:
        place = rows[0] + (psi - rows[0]) % turn
        return float(spline(place)), float(slopes[0](place)), float(slopes[1](place))

    return Law(motion, tuple(rows[1:]))


def _cam(item: Mapping[str, Any]) -> Law:
    """Rise, dwell and return of a cam, from ``start_deg`` on."""
    lift = math.radians(item.get("lift_deg", 0.0)) + item.get("lift_mm", 0.0) / 1000.0
    start = math.radians(item.get("start_deg", 0.0))
    rise, fall = math.radians(item["rise_deg"]), math.radians(item["return_deg"])
    down = rise + math.radians(item.get("dwell_deg", 0.0))
    shape = _SHAPES[item["motion"]]

    def motion(psi: float) -> tuple[float, float, float]:
        place = (psi - start) % (2.0 * math.pi)
        if place < rise:
            x, v, a = shape(place / rise)
            return lift * x, lift * v / rise, lift * a / rise**2
        if place < down:
            return lift, 0.0, 0.0
        if place < down + fall:
            x, v, a = shape((place - down) / fall)
            return lift * (1.0 - x), -lift * v / fall, -lift * a / fall**2
        return 0.0, 0.0, 0.0

    shares = (0.0, 0.125, 0.875, 1.0)
    knots = {start + rise * s for s in shares} | {start + down + fall * s for s in shares}
    return Law(motion, tuple(sorted(knots)))


def _sine(s: float) -> tuple[float, float, float]:
    turn = 2.0 * math.pi
    return s - math.sin(turn * s) / turn, 1.0 - math.cos(turn * s), turn * math.sin(turn * s)


def _two_sines(s: float) -> tuple[float, float, float]:
    """Acceleration of a fast sine up to an eighth, then of one a third as fast; integrated."""
    if s > 0.5:
        x, v, a = _two_sines(1.0 - s)
        return 1.0 - x, v, -a
    top, fast, slow = 4.0 * math.pi**2 / (4.0 + math.pi), 4.0 * math.pi, 4.0 * math.pi / 3.0
    t = min(s, 0.125)
    x, v = top / fast * (t - math.sin(fast * t) / fast), top / fast * (1.0 - math.cos(fast * t))
    a = top * math.sin(fast * t)
    if s > 0.125:
        phase, t = slow * (s - 0.125) + math.pi / 2.0, s - 0.125
        x += v * t - top / slow**2 * (math.sin(phase) - 1.0)
        v, a = v - top / slow * math.cos(phase), top * math.sin(phase)
    return x, v, a


def _polynomial(order: int) -> Motion:
    """The polynomial from 0 to 1 whose first derivatives vanish at both ends."""
    powers = np.arange(order, 2 * order)
    rows = [[math.perm(int(p), k) for p in powers] for k in range(order)]
    weights = np.linalg.solve(np.array(rows, dtype=float), np.eye(order)[0]).round()
    value = np.polynomial.Polynomial(np.concatenate([np.zeros(order), weights]))
    first, second = value.deriv(1), value.deriv(2)
    return lambda s: (float(value(s)), float(first(s)), float(second(s)))


_SHAPES: dict[str, Motion] = {
    "cycloidal": _sine,
    "modified_sine": _two_sines,
    "polynomial_345": _polynomial(3),
    "polynomial_4567": _polynomial(4),
}
_LAWS: dict[str, Callable[[Mapping[str, Any]], Law]] = {
    "constant_speed": _constant,
    "screw": _screw,
    "oscillating_guide": _guide,
    "fourier": _fourier,
    "table": _table,
    "cam": _cam,
}


def extreme(law: Law, kind: str) -> float:
    """Angle in a turn at which a law is smallest or largest, from the root of its slope."""
    from scipy.optimize import brentq

    sign = 1.0 if kind == "minimum" else -1.0
    grid = 2.0 * math.pi * np.arange(721) / 720.0
    best = int(np.argmin([sign * law.motion(psi)[0] for psi in grid[:-1]]))
    step = grid[1]
    found = brentq(
        lambda psi: sign * law.motion(psi)[1], grid[best] - step, grid[best] + step, xtol=1e-15
    )
    return float(found % (2.0 * math.pi))
