"""Gauss collocation of q'' = a(t, q, q') over one step, order 2 s at its end.

Source: E. Hairer, S. Norsett, G. Wanner, Solving Ordinary Differential Equations I, section II.7.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

Array = np.ndarray
Accelerations = Callable[[Array, Array, Array], Array]
_ITERATIONS, _STALLED = 40, 4


class Rule(NamedTuple):
    """Nodes on 0 to 1, integrals to the nodes and to the end, and the transform to Legendre."""

    nodes: Array
    once: Array
    twice: Array
    weights: Array
    moments: Array
    transform: Array


@cache
def rule(stages: int) -> Rule:
    """The Gauss rule with so many stages."""
    x, w = legendre.leggauss(stages)
    nodes, weights = 0.5 * (x + 1.0), 0.5 * w
    orders = np.arange(stages)
    values = legendre.legvander(x, stages - 1)
    transform = (2 * orders[:, None] + 1) * values.T * weights
    once = _integrals(stages, x) @ transform
    return Rule(nodes, once, once @ once, weights, weights * (1.0 - nodes), transform)


def _integrals(stages: int, x: Array) -> Array:
    """Integrals from 0 to the places x (on -1 to 1) of the Legendre polynomials."""
    integrals = [legendre.legint(one, lbnd=-1) for one in np.eye(stages)]
    return np.array([0.5 * legendre.legval(x, item) for item in integrals]).T


class Step(NamedTuple):
    """A step from t0 of length h: states at the nodes and at the end, and what is unresolved."""

    t0: float
    h: float
    q: Array
    v: Array
    a: Array
    q_end: Array
    v_end: Array
    tail: float


class Mixing:
    """Anderson's acceleration of a fixed-point iteration x = g(x), which stiff springs slow down.

    Source: H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.
    """

    def __init__(self, unit: Array, depth: int = 6) -> None:
        self.unit, self.depth = unit, depth
        self.places: list[Array] = []
        self.misses: list[Array] = []

    def next(self, x: Array, g: Array) -> Array:
        """The next place to try, from a place and the function there."""
        self.places.append((x / self.unit).ravel())
        self.misses.append(((g - x) / self.unit).ravel())
        del self.places[: -self.depth], self.misses[: -self.depth]
        if len(self.places) == 1:
            return g
        dX, dF = np.diff(np.array(self.places), axis=0).T, np.diff(np.array(self.misses), axis=0).T
        share = np.linalg.lstsq(dF, self.misses[-1], rcond=1e-12)[0]
        mixed = self.places[-1] + self.misses[-1] - (dX + dF) @ share
        return np.asarray(mixed.reshape(x.shape) * self.unit)


def step(
    f: Accelerations, t0: float, h: float, q0: Array, v0: Array, guess: Array, unit: Array,
    stages: int, floor: float,
) -> Step | None:  # fmt: skip
    """One step; None if the iteration does not settle.

    Args:
        f: Accelerations (K, n) at K times and states.
        t0: Start [s].
        h: Length [s].
        q0: Coordinates.
        v0: Rates.
        guess: Accelerations at the start, or at the nodes.
        unit: Size of one in each coordinate.
        stages: Number of nodes.
        floor: Acceleration, in units, that counts as none beside what the machine does.
    """
    r = rule(stages)
    t = t0 + h * r.nodes
    a = np.broadcast_to(guess, (stages, len(q0))).copy()
    mixing, best, stalled = Mixing(unit), np.inf, 0
    settled, scale = a, floor
    for _ in range(_ITERATIONS):
        q = q0 + h * r.nodes[:, None] * v0 + h * h * (r.twice @ a)
        v = v0 + h * (r.once @ a)
        found = f(t, q, v)
        change = float((np.abs(found - a) / unit).max())
        size = float((np.abs(found) / unit).max()) + floor
        if not np.isfinite(change) or change > 1e6 * size:
            return None
        # It settles on round-off, which a stiff drive train makes larger.
        stalled = stalled + 1 if change > 0.5 * best else 0
        if change < best:
            best, settled, scale = change, found, size
        if change <= 1e-15 * size or (stalled >= _STALLED and best < 1e-12 * size):
            break
        a = mixing.next(a, found)
    # Beside the size that it had there: an iteration that runs away grows beyond any change.
    size = scale
    if best > 1e-9 * size:
        return None
    a = settled
    q_end = q0 + h * v0 + h * h * (r.moments @ a)
    v_end = v0 + h * (r.weights @ a)
    q = q0 + h * r.nodes[:, None] * v0 + h * h * (r.twice @ a)
    v = v0 + h * (r.once @ a)
    tail = float((np.abs(r.transform[-2:] @ a) / unit).max()) / size
    return Step(t0, h, q, v, a, q_end, v_end, tail)


def values_between(nodes: Array, sigma: Array) -> Array:
    """The polynomial through values at the nodes (s, ...) at places 0 to 1."""
    coefficients = rule(len(nodes)).transform @ nodes
    return legendre.legvander(2.0 * sigma - 1.0, len(nodes) - 1) @ coefficients


def integrated(nodes: Array, sigma: Array) -> tuple[Array, Array]:
    """Single and double integral from 0 to the places 0 to 1, as factors of sigma, sigma^2.

    Divided by sigma and sigma squared they keep their relative precision near the start.
    """
    r = rule(len(nodes))
    # Over 0 to sigma by the same rule, exact for these polynomials.
    places = sigma[:, None] * r.nodes
    inner = values_between(nodes, places.ravel()).reshape(places.shape)
    return inner @ r.weights, inner @ r.moments
